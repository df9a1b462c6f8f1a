//! Reports, traces, events, baked files and lists.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::command::text;
use crate::common::folder;
use serde_json::Value;

use crate::running::{json, scene_with, succeed};

#[test]
fn the_hash_depends_neither_on_outputs_nor_on_threads() {
    let folder = folder("hash");
    let run = |name: &str, more: &[&str]| {
        let report = format!("{name}.json");
        let mut args = vec!["simulate", "pyramid:base=6", "--steps", "130", "--report", &report];
        args.extend_from_slice(more);
        succeed(&folder, &args);
        json(&folder.join(&report))
    };
    let plain = run("plain", &["--threads", "1"]);
    let outputs = ["--trace", "t.csv", "--events", "e.jsonl", "--bake", "b.glb", "--threads", "1"];
    for other in [run("outputs", &outputs), run("threads", &["--threads", "2"])] {
        for key in
            ["hash", "hashes", "contacts", "energy", "penetration", "momentum_drift", "asleep_end"]
        {
            assert_eq!(plain[key], other[key], "{key}");
        }
    }
    assert!(fs::metadata(folder.join("b.glb")).unwrap().len() > 100);
    let steps: Vec<u64> =
        plain["hashes"].as_array().unwrap().iter().map(|row| row[0].as_u64().unwrap()).collect();
    assert_eq!(steps, [60, 120]);
}

#[test]
fn the_report_has_every_key() {
    let folder = folder("report");
    let page = succeed(
        &folder,
        &["simulate", "hello", "--seconds", "0.5", "--hz", "120", "--report", "r.json"],
    );
    let report = json(&folder.join("r.json"));
    for pointer in [
        "/scene",
        "/method",
        "/hz",
        "/substeps",
        "/threads",
        "/simd",
        "/steps",
        "/bodies/static",
        "/bodies/kinematic",
        "/bodies/dynamic",
        "/shapes",
        "/joints",
        "/wall_ms/total",
        "/wall_ms/step_mean",
        "/wall_ms/step_median",
        "/wall_ms/step_p99",
        "/stages_ms",
        "/contacts/mean",
        "/contacts/max",
        "/energy/kinetic_start",
        "/energy/kinetic_end",
        "/energy/potential_start",
        "/energy/potential_end",
        "/energy/total_max",
        "/momentum_drift",
        "/penetration/max",
        "/penetration/p99",
        "/penetration/end_max",
        "/joint_error/max",
        "/joint_error/p99",
        "/asleep_end",
        "/audit/energy/elastic",
        "/audit/momentum/about_center",
        "/audit/penetration/p99",
        "/audit/joints/linear",
        "/audit/residual/relative",
        "/audit/non_finite",
        "/audit/awake",
        "/hash",
        "/hashes",
        "/faults",
        "/ignored",
    ] {
        let value = report.pointer(pointer);
        assert!(value.is_some_and(|v| !v.is_null()), "{pointer} is missing: {report}");
    }
    assert_eq!(
        (report["steps"].as_u64(), report["method"].as_str()),
        (Some(60), Some("soft-step"))
    );
    let hash = report["hash"].as_str().unwrap();
    assert!(hash.len() == 16 && hash.chars().all(|c| c.is_ascii_hexdigit()), "{hash}");
    assert!(page.contains(hash), "the page must show the hash:\n{page}");
    assert!(report["stages_ms"].as_object().unwrap().len() > 1);
}

#[test]
fn an_audit_says_what_is_awake_and_where_the_energy_went() {
    let folder = folder("audit");
    fs::write(folder.join("in.gltf"), scene_with(&[])).unwrap();
    let simulate = |flags: &[&str]| {
        let args = ["simulate", "in.gltf", "--steps", "10", "--report", "r.json"];
        let page = succeed(&folder, &[&args, flags].concat());
        (page, json(&folder.join("r.json")))
    };
    let (plain, without) = simulate(&[]);
    let (page, with) = simulate(&["--audit"]);
    assert_eq!(with["hash"], without["hash"], "an audit changes nothing");
    assert!(without["audit"]["ledger"].is_null() && !plain.contains("residual"), "{plain}");
    let ledger = &with["audit"]["ledger"];
    assert_eq!(ledger["steps"].as_u64(), Some(10));
    // A free fall: nothing comes in and nothing is lost.
    let value = |key: &str| ledger[key].as_f64().unwrap();
    assert!((value("start") - value("now")).abs() < 1.0e-5 * value("start"), "{ledger}");
    assert!(page.contains("'a \"box\", falling': it moves at"), "{page}");
    for subject in ["audit ", "ledger ", "momentum ", "spin ", "overlap ", "residual ", "awake "] {
        assert!(page.lines().any(|line| line.starts_with(subject)), "{subject} is missing: {page}");
    }
    let awake = &with["audit"]["awake"][0];
    assert_eq!(awake["path"], serde_json::json!(["a \"box\", falling"]));
}

#[test]
fn the_trace_has_a_row_for_every_body_and_kept_step() {
    let folder = folder("trace");
    fs::write(folder.join("in.gltf"), scene_with(&[])).unwrap();
    succeed(&folder, &["simulate", "in.gltf", "--steps", "10", "--trace", "t.csv", "--every", "4"]);
    let trace = fs::read_to_string(folder.join("t.csv")).unwrap();
    let mut lines = trace.lines();
    assert_eq!(lines.next(), Some("step,time,body,px,py,pz,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz,asleep"));
    let mut kept = Vec::new();
    for line in lines.filter(|line| line.contains("box")) {
        let (head, rest) = line.split_once("\"a \"\"box\"\", falling\",").unwrap();
        let step: u64 = head.split(',').next().unwrap().parse().unwrap();
        let numbers: Vec<f32> = rest.split(',').map(|x| x.parse().unwrap()).collect();
        assert_eq!(numbers.len(), 14, "{line}");
        kept.push((step, numbers[1]));
    }
    assert_eq!(kept.iter().map(|k| k.0).collect::<Vec<_>>(), [0, 4, 8]);
    assert!((kept[0].1 - 1.0).abs() < 1.0e-6, "it starts where the file puts it");
    assert!(kept[1].1 < kept[0].1, "it falls");
    assert_eq!(trace.lines().count(), 1 + 3 * 2, "the floor has its rows too");
}

#[test]
fn events_are_json_lines() {
    let folder = folder("events");
    fs::write(folder.join("in.gltf"), scene_with(&[("HEIGHT", "2.0")])).unwrap();
    succeed(&folder, &["simulate", "in.gltf", "--seconds", "4", "--events", "e.jsonl"]);
    let file = fs::read_to_string(folder.join("e.jsonl")).unwrap();
    let events: Vec<Value> = file.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let first = |kind: &str| events.iter().find(|e| e["type"] == kind);
    let begin = first("contact_begin").expect("it lands");
    for key in ["step", "time", "body_a", "body_b"] {
        assert!(!begin[key].is_null(), "{begin}");
    }
    let names = [&begin["body_a"], &begin["body_b"]];
    assert!(names.iter().any(|n| *n == "floor"), "{begin}");
    assert!(names.iter().any(|n| *n == "a \"box\", falling"), "{begin}");
    let hit = first("hit").expect("it lands at 5 m/s");
    let speed = hit["speed"].as_f64().unwrap();
    assert!((4.5..6.0).contains(&speed), "sqrt(2 g 1.5 m) = 5.4 m/s: {hit}");
    assert_eq!(hit["point"].as_array().unwrap().len(), 3);
    assert_eq!(first("sleep").expect("it comes to rest")["body"], "a \"box\", falling");
}

#[test]
fn lists_and_help_are_printed() {
    let folder = folder("lists");
    let scenes = succeed(&folder, &["scenes"]);
    for name in ["hello", "pyramid", "stack"] {
        assert!(scenes.lines().any(|line| line.starts_with(name)), "{name}:\n{scenes}");
    }
    assert!(succeed(&folder, &["methods"]).contains("(default)"));
    assert!(succeed(&folder, &["--version"]).starts_with("drystone "));
    assert!(succeed(&folder, &["simulate", "--help"]).contains("Exit status"));
    fs::write(folder.join("in.gltf"), scene_with(&[])).unwrap();
    let info = succeed(&folder, &["info", "in.gltf"]);
    assert!(info.contains("1 dynamic, 1 static") && info.contains("2 box"), "{info}");
}

#[test]
fn no_step_at_all_is_a_run_too() {
    let folder = folder("none");
    succeed(&folder, &["simulate", "hello", "--steps", "0", "--trace", "t.csv", "--bake", "b.glb"]);
    assert!(fs::read_to_string(folder.join("t.csv")).unwrap().lines().count() > 1);
}

#[test]
fn bodies_that_join_late_are_traced_and_baked() {
    let folder = folder("joining");
    let out = ["--steps", "40", "--trace", "t.csv", "--bake", "b.glb"];
    succeed(&folder, &[&["simulate", "large_world:tiles=10"], &out[..]].concat());
    let trace = fs::read_to_string(folder.join("t.csv")).unwrap();
    let rows = |step: &str| trace.lines().filter(|l| l.starts_with(&format!("{step},"))).count();
    assert!(rows("0") < rows("40"), "{} rows, then {}", rows("0"), rows("40"));
}

#[test]
fn what_stands_still_is_seen_in_a_baked_file() {
    let folder = folder("still");
    succeed(&folder, &["simulate", "hello", "--steps", "5", "--bake", "b.glb"]);
    let read = |bytes: &[u8], film: bool| {
        let options = drystone_scene::gltf::Options::default();
        let loaded =
            drystone_scene::gltf::from_slice(bytes, "b.glb", Path::new(""), &options).unwrap();
        if film { drystone_scene::gltf::film(loaded).unwrap() } else { loaded.scene }
    };
    let bytes = fs::read(folder.join("b.glb")).unwrap();
    // Bodies that a film brings later are none of its bodies at its beginning.
    let (film, scene) = (read(&bytes, true), read(&bytes, false));
    assert!(scene.bodies.len() >= 3, "a ground and two that fall");
    assert_eq!(film.bodies.len(), scene.bodies.len());
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_gone_is_no_failure() {
    let folder = folder("pipe");
    let mut child = Command::new(env!("CARGO_BIN_EXE_drystone"))
        .arg("scenes")
        .current_dir(&folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
}
