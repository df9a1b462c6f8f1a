//! A scene that tests run, and the command run on it.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::command::{drystone, text};
use serde_json::Value;

/// A box above a floor; parts in capitals are replaced to make it wrong.
pub(crate) const SCENE: &str = r#"{
  "asset": {"version": "2.0"},
  "extensionsUsed": ["KHR_implicit_shapes", "KHR_physics_rigid_bodies"],
  REQUIRED
  "extensions": {"KHR_implicit_shapes": {"shapes": [
    {"type": "box", "box": {"size": [40.0, 1.0, 40.0]}},
    {"type": "box", "box": {"size": [1.0, 1.0, 1.0]}}
  ]}},
  "buffers": [{"byteLength": 36,
    "uri": "data:application/octet-stream;base64,POINTS"}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
    "min": [0, 0, 0], "max": [1, 1, 0]}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}]}],
  "nodes": [
    {"name": "floor", "translation": [0, -0.5, 0],
      "extensions": {"KHR_physics_rigid_bodies": {"collider": {"geometry": {"shape": 0}}}}},
    {"name": "a \"box\", falling", "translation": [0, HEIGHT, 0], "extensions":
      {"KHR_physics_rigid_bodies": {"motion": {"mass": MASS}, "collider": {"geometry": GEOMETRY}}}}
  ],
  "scene": 0, "scenes": [{"nodes": [0, 1]}]
}"#;

/// Three points in the plane z = 0.
pub(crate) const POINTS: &str = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";

/// [`SCENE`] with some of its parts replaced.
pub(crate) fn scene_with(changes: &[(&str, &str)]) -> String {
    let mut text = SCENE.replace("POINTS", POINTS);
    for &(part, value) in changes {
        text = text.replace(part, value);
    }
    for (part, value) in
        [("REQUIRED", ""), ("HEIGHT", "1.0"), ("MASS", "1.0"), ("GEOMETRY", r#"{"shape": 1}"#)]
    {
        text = text.replace(part, value);
    }
    text
}

/// Runs the command, which must succeed; returns what it printed.
pub(crate) fn succeed(folder: &Path, args: &[&str]) -> String {
    let output = drystone(folder, args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "", "{args:?}: nothing but errors belongs on stderr");
    text(&output.stdout)
}

/// Runs the command, which must fail with status 1 and one line; returns the line.
pub(crate) fn fail(folder: &Path, args: &[&str]) -> String {
    let start = Instant::now();
    let output = drystone(folder, args);
    let line = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{args:?}: {line}");
    assert!(line.starts_with("error: ") && line.ends_with('\n'), "{args:?}: {line}");
    assert_eq!(line.lines().count(), 1, "{args:?}: {line}");
    assert!(line.len() < 1000, "{args:?}: {line}");
    assert_eq!(text(&output.stdout), "", "{args:?}");
    assert!(start.elapsed() < Duration::from_secs(5), "{args:?} took {:?}", start.elapsed());
    line
}

pub(crate) fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}
