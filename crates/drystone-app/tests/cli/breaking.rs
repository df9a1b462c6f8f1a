//! Bodies that break.

use std::fs;

use crate::common::folder;
use serde_json::Value;

use crate::running::succeed;

#[test]
fn pieces_of_what_breaks_have_names_rows_and_nodes_from_when_they_come() {
    let folder = folder("fracture");
    let args = [
        "simulate",
        "fracture:pieces=10",
        "--seconds",
        "2.5",
        "--bake",
        "f.glb",
        "--trace",
        "t.csv",
    ];
    succeed(&folder, &[&args[..], &["--events", "e.jsonl", "--threads", "2"]].concat());

    // The bodies that broke, with their steps and pieces.
    let lines = fs::read_to_string(folder.join("e.jsonl")).unwrap();
    let events: Vec<Value> = lines.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let broken: Vec<&Value> = events.iter().filter(|e| e["type"] == "fracture").collect();
    for body in ["block", "rock", "pane"] {
        assert!(broken.iter().any(|e| e["body"] == body), "{body}: {broken:?}");
    }
    let mut rows = std::collections::BTreeMap::<String, Vec<u64>>::new();
    for row in fs::read_to_string(folder.join("t.csv")).unwrap().lines().skip(1) {
        let mut cells = row.split(',');
        let (step, _, body) = (cells.next().unwrap(), cells.next(), cells.next().unwrap());
        rows.entry(body.to_owned()).or_default().push(step.parse().unwrap());
    }
    for event in &broken {
        assert!(event["value"].as_f64() > event["limit"].as_f64(), "{event}");
        let step = event["step"].as_u64().unwrap();
        let own = &rows[event["body"].as_str().unwrap()];
        assert_eq!(own.last(), Some(&(step - 1)), "{event}");
        let pieces = event["pieces"].as_array().unwrap();
        assert!(pieces.len() > 1, "{event}");
        for piece in pieces {
            let name = piece.as_str().unwrap();
            assert!(name.contains(" piece "), "{name}");
            assert_eq!(rows[name].first(), Some(&step), "{name}");
        }
    }

    // The baked file: each piece is a node without size at first, the whole body one without size
    // at last.
    let file = fs::read(folder.join("f.glb")).unwrap();
    let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&file[20..20 + length]).unwrap();
    let binary = &file[20 + length + 8..];
    let animation = &json["animations"][0];
    let number = |of: &Value| usize::try_from(of.as_u64().unwrap_or(0)).unwrap();
    let scales_of = |name: &str| -> Vec<f32> {
        let nodes = json["nodes"].as_array().unwrap();
        let node = nodes.iter().position(|n| n["name"] == name).unwrap_or_else(|| panic!("{name}"));
        let mut channels = animation["channels"].as_array().unwrap().iter();
        let channel = channels
            .find(|c| c["target"]["node"] == node && c["target"]["path"] == "scale")
            .unwrap_or_else(|| panic!("{name}"));
        let sampler = &animation["samplers"][number(&channel["sampler"])];
        assert_eq!(sampler["interpolation"], "STEP");
        let accessor = &json["accessors"][number(&sampler["output"])];
        let view = &json["bufferViews"][number(&accessor["bufferView"])];
        let from = number(&view["byteOffset"]) + number(&accessor["byteOffset"]);
        let bytes = &binary[from..from + 12 * number(&accessor["count"])];
        bytes.chunks_exact(12).map(|b| f32::from_le_bytes(b[..4].try_into().unwrap())).collect()
    };
    for event in &broken {
        for piece in event["pieces"].as_array().unwrap() {
            let scales = scales_of(piece.as_str().unwrap());
            assert!(scales[0].abs() < 1e-9 && (scales[1] - 1.0).abs() < 1e-6, "{scales:?}");
        }
    }
    let pane = scales_of("pane");
    assert!((pane[0] - 1.0).abs() < 1e-6 && pane[1].abs() < 1e-9, "{pane:?}");
    // Read back as physics, there are the bodies of the scene and no pieces.
    let info = succeed(&folder, &["info", "f.glb"]);
    assert!(info.contains("4 dynamic"), "{info}");
}

#[test]
fn a_glued_wall_loses_bricks_and_goes_on_under_its_name() {
    let folder = folder("glued");
    let args = ["simulate", "wrecking_ball:bond=1", "--seconds", "3", "--bake", "w.glb"];
    succeed(
        &folder,
        &[&args[..], &["--trace", "t.csv", "--events", "e.jsonl", "--every", "20"]].concat(),
    );
    let lines = fs::read_to_string(folder.join("e.jsonl")).unwrap();
    assert!(lines.contains("\"type\":\"bond_break\""), "{lines}");
    assert!(lines.contains("\"cause\":\"glue\""), "{lines}");
    let trace = fs::read_to_string(folder.join("t.csv")).unwrap();
    assert!(trace.contains(",wall piece 1,"));
    assert!(trace.lines().last().is_some_and(|l| l.starts_with("180,")), "to the end");
    assert!(trace.lines().any(|l| l.starts_with("180,3.0,wall,")), "the largest part is the wall");
}
