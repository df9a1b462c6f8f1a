//! Wrong usage, scenes that are refused, outputs that cannot be written.

use std::fs::{self, File};
use std::time::{Duration, Instant};

use crate::command::{drystone, text};
use crate::common::folder;

use crate::running::{fail, scene_with};

#[test]
fn wrong_usage_exits_with_two() {
    let folder = folder("usage");
    for args in [
        "",
        "fly",
        "simulate",
        "simulate hello --hz 0",
        "simulate hello --hz nan",
        "simulate hello --seconds -1",
        "simulate hello --seconds 1 --steps 1",
        "simulate hello --every 0",
        "simulate hello --threads 0",
        "simulate hello --threads 1000",
        "simulate hello --substeps 0",
        "simulate hello --method magic",
        "simulate hello --set gravity",
        "simulate hello --set contact.magic=1",
        "simulate hello --set gravity=1,2",
        "simulate hello --bake out.obj",
        "simulate hello --trace a --report a",
        "simulate hello --auto-colliders hull",
        "simulate hello extra",
        "simulate hello --snapshot",
        "simulate hello --record a --trace a",
        "replay",
        "info",
    ] {
        let output = drystone(&folder, &args.split_whitespace().collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(2), "{args}: {}", text(&output.stderr));
        assert!(!output.stderr.is_empty(), "{args}");
    }
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "wrong usage must leave no file");
}

#[test]
fn scenes_that_cannot_be_read_are_refused_in_one_line() {
    let folder = folder("unreadable");
    fs::create_dir(folder.join("directory.gltf")).unwrap();
    let write = |name: &str, content: &str| fs::write(folder.join(name), content).unwrap();
    write("empty.gltf", "");
    write("empty.glb", "");
    write("broken.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [");
    write("text.glb", "this is no scene\nat all\n");
    write("array.gltf", "[]");
    write("unknown.step", "x");
    write("nan.gltf", &scene_with(&[("HEIGHT", "NaN")]));
    write("infinite.gltf", &scene_with(&[("HEIGHT", "1e999")]));
    write("large.gltf", &scene_with(&[("HEIGHT", "1e300")]));
    write("mass.gltf", &scene_with(&[("MASS", "-1.0")]));
    write("shape.gltf", &scene_with(&[("GEOMETRY", r#"{"shape": 7}"#)]));
    write("hull.gltf", &scene_with(&[("GEOMETRY", r#"{"mesh": 0, "convexHull": true}"#)]));
    write("required.gltf", &scene_with(&[("REQUIRED", r#""extensionsRequired": ["EXT_magic"],"#)]));
    for name in [
        "missing.gltf",
        "missing.glb",
        "no/such/folder.gltf",
        "directory.gltf",
        ".",
        "empty.gltf",
        "empty.glb",
        "broken.gltf",
        "text.glb",
        "array.gltf",
        "unknown.step",
        "nan.gltf",
        "infinite.gltf",
        "large.gltf",
        "mass.gltf",
        "shape.gltf",
        "hull.gltf",
        "required.gltf",
    ] {
        for command in ["simulate", "info"] {
            let line = fail(&folder, &[command, name]);
            assert!(line.contains(name), "{name}: {line}");
        }
    }
    assert!(fail(&folder, &["simulate", "mass.gltf"]).contains("mass"));
    assert!(fail(&folder, &["simulate", "required.gltf"]).contains("EXT_magic"));
}

#[test]
fn a_gigabyte_of_zeros_is_refused_at_once() {
    let folder = folder("zeros");
    for name in ["zeros.glb", "zeros.gltf"] {
        File::create(folder.join(name)).unwrap().set_len(1 << 30).unwrap();
        assert!(fail(&folder, &["simulate", name]).contains(name));
    }
}

#[test]
fn unknown_scenes_and_parameters_are_refused_in_one_line() {
    let folder = folder("unknown");
    for scene in ["nosuch", "pyramid:magic=1", "pyramid:base", "pyramid:base=x", "pyramid:base=-1"]
    {
        fail(&folder, &["simulate", scene]);
    }
}

#[test]
fn outputs_that_cannot_be_written_are_found_before_the_run() {
    let folder = folder("unwritable");
    for flag in ["--trace", "--events", "--report", "--bake"] {
        let start = Instant::now();
        let line = fail(&folder, &["simulate", "hello", "--steps", "100000000", flag, "no/x.glb"]);
        assert!(line.contains("x.glb"), "{line}");
        assert!(start.elapsed() < Duration::from_secs(5));
    }
    fs::create_dir(folder.join("folder.glb")).unwrap();
    fail(&folder, &["simulate", "hello", "--bake", "folder.glb"]);
}

#[test]
fn the_scene_itself_is_not_overwritten() {
    let folder = folder("overwrite");
    let content = scene_with(&[]);
    fs::write(folder.join("in.gltf"), &content).unwrap();
    let output = drystone(&folder, &["simulate", "in.gltf", "--bake", "./in.gltf"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(fs::read_to_string(folder.join("in.gltf")).unwrap(), content);
}
