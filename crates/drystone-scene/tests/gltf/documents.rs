//! Documents that tests read, and where files are.

use std::fs;
use std::path::{Path, PathBuf};

use drystone_scene::SceneError;
use drystone_scene::gltf::{self, LoadedGltf, Options};
use serde_json::{Value, json};

pub(crate) fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf-khr-own")
}

pub(crate) fn load(name: &str) -> LoadedGltf {
    gltf::load(&data().join(name), &Options::default()).unwrap()
}

/// A folder for files of this test run.
pub(crate) fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

pub(crate) fn samples() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(data())
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "gltf"))
        .collect();
    files.sort();
    files
}

pub(crate) fn read(value: &Value, options: &Options) -> Result<LoadedGltf, SceneError> {
    gltf::from_slice(value.to_string().as_bytes(), "test", Path::new(""), options)
}

/// A document with one shape list and these nodes, all in the scene.
pub(crate) fn physics(shapes: Value, nodes: Value) -> Value {
    json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_implicit_shapes", "KHR_physics_rigid_bodies"],
        "extensions": {"KHR_implicit_shapes": {"shapes": shapes}},
        "nodes": nodes,
    })
}

pub(crate) fn with(physics: Value) -> Value {
    json!({"KHR_physics_rigid_bodies": physics})
}

/// The next number of a simple generator.
pub(crate) fn next(state: &mut u64) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    usize::try_from(*state >> 33).unwrap()
}
