//! Files that are wrong or damaged.

use std::fs;
use std::path::Path;

use drystone::Pose;
use drystone_scene::bake::{self, Motion};
use drystone_scene::gltf::{self, AutoColliders, Options};
use serde_json::{Value, json};

use crate::documents::{data, next, read, samples, scratch};

#[test]
fn what_is_wrong_is_said_in_one_line() {
    let folder = scratch("wrong");
    let sample = fs::read_to_string(data().join("rest_convexhull_on_meshfloor.gltf")).unwrap();
    let base: Value = serde_json::from_str(&sample).unwrap();
    let edit = |pointer: &str, value: Value| {
        let mut v = base.clone();
        *v.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer}")) = value;
        v.to_string()
    };
    let body = "/nodes/1/extensions/KHR_physics_rigid_bodies";
    let mut required = base.clone();
    required["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    let mut cycle = base.clone();
    cycle["nodes"][0]["children"] = json!([1]);
    cycle["nodes"][1]["children"] = json!([0]);
    let mut three = base.clone();
    three["accessors"][0]["count"] = json!(3);
    three["accessors"][1]["count"] = json!(3);
    let table: Vec<(&str, String, &str)> = vec![
        ("broken", "{\"asset\": {".to_owned(), "broken JSON"),
        ("text", "hello".to_owned(), "not a glTF file"),
        ("empty", String::new(), "it is empty"),
        ("zeros", "\0".repeat(100_000), "not a glTF file"),
        ("cut", "glTF".to_owned(), "cut short"),
        ("list", "  {\"asset\": []}".to_owned(), "asset"),
        ("overflow", sample.replace("\"mass\": 1.0", "\"mass\": 1e999"), "number out of range"),
        (
            "nan",
            edit("/nodes/1/translation/1", json!("NaN")),
            "nodes[1].translation[1]: is \"NaN\"",
        ),
        ("huge", edit("/nodes/1/translation/1", json!(1e300)), "nodes[1].translation[1]"),
        (
            "null",
            edit("/nodes/1/translation", json!([0, null, 0])),
            "nodes[1].translation[1]: is null",
        ),
        ("mass", edit(&format!("{body}/motion/mass"), json!(-1)), "motion.mass: is -1, expected"),
        (
            "shape",
            edit(&format!("{body}/collider/geometry"), json!({"shape": 7})),
            "geometry.shape: is 7",
        ),
        (
            "node",
            edit(&format!("{body}/collider/geometry/node"), json!(9)),
            "geometry.node: is 9, expected 0 to 1",
        ),
        ("none", edit(&format!("{body}/collider/geometry"), json!({})), "no geometry"),
        ("three", three.to_string(), "at least 4 points"),
        ("required", required.to_string(), "extensionsRequired[0]"),
        ("cycle", cycle.to_string(), "cycle"),
        ("range", edit("/accessors/0/count", json!(1_000_000_000_000_u64)), "accessors[0].count"),
        ("accessor", edit("/meshes/0/primitives/0/indices", json!(99)), "indices: is 99"),
        ("view", edit("/bufferViews/0/byteOffset", json!(999_999)), "bufferViews[0]"),
        ("index", edit("/accessors/1/bufferView", json!(0)), "names vertex"),
        ("buffer", edit("/buffers/0/byteLength", json!(999_999)), "buffers[0].byteLength"),
        ("base64", edit("/buffers/0/uri", json!("data:;base64,%%%")), "base64"),
        ("beside", edit("/buffers/0/uri", json!("no-such.bin")), "no-such.bin"),
        ("url", edit("/buffers/0/uri", json!("https://example.org/a.bin")), "relative"),
        ("version", edit("/asset/version", json!("1.0")), "asset.version"),
        ("scene", edit("/scene", json!(3)), "scene: is 3, expected 0 to 0"),
    ];
    let check = |path: &Path, part: &str| {
        let line = match gltf::load(path, &Options::default()) {
            Ok(_) => panic!("{} was read", path.display()),
            Err(e) => e.to_string(),
        };
        assert!(line.contains(part), "{line}\nhas no {part:?}");
        assert!(line.starts_with(&path.display().to_string()) && !line.contains('\n'), "{line}");
    };
    for (name, text, part) in table {
        let path = folder.join(name).with_extension("gltf");
        fs::write(&path, text).unwrap();
        check(&path, part);
    }
    // A gigabyte of zeros, which takes no room: refused by its first bytes.
    let zeros = folder.join("gigabyte.glb");
    fs::File::create(&zeros).unwrap().set_len(1 << 30).unwrap();
    check(&zeros, "not a glTF file");
    fs::File::create(&zeros).unwrap().set_len(3 << 30).unwrap();
    check(&zeros, "up to 2 GB");
    check(&folder, "directory");
    check(&folder.join("missing.gltf"), "No such file");
}

/// All places of a JSON value.
fn places(value: &Value, here: &str, out: &mut Vec<String>) {
    out.push(here.to_owned());
    match value {
        Value::Object(o) => o.iter().for_each(|(k, v)| places(v, &format!("{here}/{k}"), out)),
        Value::Array(a) => {
            for (i, v) in a.iter().enumerate() {
                places(v, &format!("{here}/{i}"), out);
            }
        }
        _ => {}
    }
}

#[test]
fn damaged_files_never_panic() {
    let texts: Vec<String> = samples().iter().map(|p| fs::read_to_string(p).unwrap()).collect();
    let odd = [
        json!(null),
        json!(-1),
        json!(0),
        json!(1),
        json!(3),
        json!(1e30),
        json!(1e-30),
        json!(u64::MAX),
        json!(5121),
        json!("x"),
        json!([]),
        json!([0, 0, 0]),
        json!([1e20, -1, 0]),
        json!({}),
        json!(true),
    ];
    let mut state = 7;
    let options = [None, Some(AutoColliders::Hull), Some(AutoColliders::Box)];
    let mut good = 0;
    for i in 0..2000 {
        let text = &texts[next(&mut state) % texts.len()];
        let options = Options { auto_colliders: options[i % 3], ..Options::default() };
        let result = if i % 2 == 0 {
            let mut bytes = text.clone().into_bytes();
            for _ in 0..1 + next(&mut state) % 4 {
                let at = next(&mut state) % bytes.len();
                bytes[at] ^= 1 << (next(&mut state) % 8);
            }
            gltf::from_slice(&bytes, "damaged", Path::new(""), &options)
        } else {
            let mut value: Value = serde_json::from_str(text).unwrap();
            for _ in 0..1 + next(&mut state) % 3 {
                let mut all = Vec::new();
                places(&value, "", &mut all);
                let at = &all[next(&mut state) % all.len()];
                *value.pointer_mut(at).unwrap() = odd[next(&mut state) % odd.len()].clone();
            }
            read(&value, &options)
        };
        match result {
            Ok(loaded) => {
                good += 1;
                // A scene that was read can be written.
                let n = loaded.scene.bodies.len();
                let pose = |i: usize| Pose::at([0.0, f32::from(u8::try_from(i % 9).unwrap()), 0.0]);
                let poses = (0..n).map(|_| (0..3).map(pose).collect()).collect();
                let path = scratch("damaged").join("out.glb");
                let times = vec![0.0, 0.1, 0.2];
                let _ = bake::write(&path, &loaded, &Motion { times, poses, ..Motion::default() });
            }
            Err(e) => assert!(!e.to_string().contains('\n'), "{e}"),
        }
    }
    assert!(good > 100, "most damage should be harmless somewhere: {good}");
}
