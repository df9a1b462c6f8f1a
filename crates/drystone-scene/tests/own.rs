//! The own format: what is written reads back to the same bits, and what is wrong is told where it stands.
#![expect(clippy::unwrap_used, reason = "tests say what they found")]

use std::path::{Path, PathBuf};

use drystone_scene::{Scene, catalog, gltf, mjcf, named, own, rigid_ipc, urdf};

/// Parameters under which scenes that are large by default are small.
const SMALL: [(&str, &str); 13] = [
    ("many_pyramids", "side=2"),
    ("hourglass", "cubes=100"),
    ("wall", "ball=1"),
    ("wrecking_ball", "bond=1"),
    ("rain", "rows=2"),
    ("voxels", "cells=8,boxes=20"),
    ("ragdolls", "n=4,muscles=50"),
    ("large_world", "tiles=2"),
    ("large_mesh", "n=150"),
    ("high_speed", "n=200"),
    ("cloth", "n=12,hang=1,tear=50"),
    ("dust", "n=500"),
    ("hail", "n=200,bodies=50"),
];

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// The scene with small parameters, where it has them.
fn small(name: &'static str) -> Scene {
    let parameters = SMALL.iter().find(|(n, _)| *n == name).map(|(_, parameters)| parameters);
    named(&parameters.map_or_else(|| name.to_owned(), |p| format!("{name}:{p}"))).unwrap()
}

/// Writes a scene, reads it, and steps both: they hold the same bits at the start and after every step.
fn goes_round(scene: &Scene, steps: u32) {
    let name = &scene.name;
    let text = own::to_text(scene).unwrap_or_else(|e| panic!("{name}: {e}"));
    let again = own::from_text(&text, "", Path::new("")).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!((&again.name, &again.summary), (&scene.name, &scene.summary));
    assert_eq!((again.hz, again.seconds), (scene.hz, scene.seconds), "{name}");
    assert!(own::to_text(&again).unwrap() == text, "{name}: written again it is another text");
    let (mut a, mut b) = (scene.build().unwrap(), again.build().unwrap());
    assert!(a.world.snapshot() == b.world.snapshot(), "{name}: another world at the start");
    assert_eq!(a.names, b.names, "{name}");
    assert_eq!(scene.frames, again.frames, "{name}");
    for step in 0..steps {
        a.step(scene.hz.recip()).unwrap();
        b.step(again.hz.recip()).unwrap();
        assert_eq!(a.world.state_hash(), b.world.state_hash(), "{name} after step {step}");
    }
    // The identity by which snapshots know their scene.
    assert!(again.resume(&scene.save(&a).unwrap()).is_ok(), "{name}: a snapshot of another scene");
}

#[test]
fn every_scene_of_the_catalog_reads_back_to_the_same_bits() {
    for entry in catalog() {
        let scene = small(entry.name);
        // A load, a wave or a drop comes within them where bodies are few.
        let steps = if scene.bodies.len() > 500 { 3 } else { 40 };
        goes_round(&scene, steps);
    }
}

/// Files of a folder and below with this ending, in order.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.extension().is_some_and(|e| e == ending) {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn every_file_of_other_formats_reads_back_to_the_same_bits() {
    let mut scenes = Vec::new();
    for path in files(&data(""), "gltf") {
        let loaded = gltf::load(&path, &gltf::Options::default());
        scenes.extend(loaded.map(|loaded| loaded.scene));
    }
    for path in files(&data(""), "urdf") {
        scenes.extend(urdf::load(&path, &urdf::Options::default()));
    }
    for path in files(&data("mujoco"), "xml") {
        scenes.extend(mjcf::load(&path));
    }
    for path in files(&data("rigid-ipc/fixtures"), "json") {
        scenes.extend(rigid_ipc::load(&path));
    }
    assert!(scenes.len() > 35, "{} scenes", scenes.len());
    for scene in &scenes {
        let steps = if scene.bodies.len() > 500 { 3 } else { 30 };
        goes_round(scene, steps);
    }
}

fn error_of(text: &str) -> String {
    own::from_text(text, "x", Path::new("")).err().map_or_else(String::new, |e| e.to_string())
}

/// What is wrong in a file with one body, by the field where it is.
#[test]
fn what_is_wrong_is_told_with_line_field_and_what_is_allowed() {
    let body = |inner: &str| format!("{{\"drystone\": 1,\n\"bodies\": [\n  {{{inner}}}]}}");
    let table = [
        (
            "{\"drystone\": 2}".to_owned(),
            "line 1 column 14: drystone: is 2, allowed is 1, the version of the format",
        ),
        ("{\"bodies\": []}".to_owned(), "drystone: the version is missing"),
        ("{\"drystone\": 1,\n \"bodies\": [}".to_owned(), "line 2 column 13: broken JSON"),
        (body("\"colour\": 1"), "line 3 column 11: bodies[0].colour: unknown field `colour`, allowed is one of `name`"),
        (body("\"kind\": \"statik\""), "allowed is one of `static`, `kinematic`, `dynamic`"),
        (body("\"position\": [1, 2]"), "bodies[0].position: invalid length 2, allowed is an array of length 3"),
        (
            body("\"shapes\": [{\"box\": {\"half_extents\": [1, 1, -1]}}]"),
            "bodies[0].shapes[0].box.half_extents.z: is -1, allowed is a length",
        ),
        (
            body("\"shapes\": [{\"sphere\": {\"radius\": 0}, \"density\": 2}]"),
            "line 3 column 37: bodies[0].shapes[0].sphere.radius: is 0",
        ),
        (
            body("\"shapes\": [{\"sphere\": {\"radius\": 1}, \"density\": -2}]"),
            "line 3 column 52: bodies[0].shapes[0].density: is -2",
        ),
        (body("\"shapes\": [{\"density\": 2}]"), "allowed is one of shape, sphere, capsule"),
        (
            body("\"shapes\": [{\"sphere\": {\"radius\": 1}, \"material\": \"ice\"}]"),
            "bodies[0].shapes[0].material: is \"ice\", which no material is called, allowed is none",
        ),
        (body("\"rotation\": [1, 1, 1, 1]"), "bodies[0].rotation: is [1, 1, 1, 1], allowed is a unit"),
        (body("\"name\": \"a\"}, {\"name\": \"a\""), "bodies[1].name: another body is called \"a\""),
        (
            "{\"drystone\": 1, \"world\": {\"contact\": {\"margin\": -1}}}".to_owned(),
            "line 1 column 49: world.contact.margin: is -1",
        ),
        (
            "{\"drystone\": 1, \"world\": {\"method\": \"magic\"}}".to_owned(),
            "world.method: is \"magic\", allowed is soft-step",
        ),
        (
            "{\"drystone\": 1, \"bodies\": [{}, {\"name\": \"b\"}], \"joints\": [{\"body_a\": 0, \"body_b\": \"c\", \"ball\": {}}]}"
                .to_owned(),
            "joints[0].body_b: is \"c\", which none of the bodies is, allowed is \"#0\", \"b\"",
        ),
        (
            "{\"drystone\": 1, \"bodies\": [{}, {}], \"joints\": [{\"body_a\": 0, \"body_b\": 1, \"hinge\": {\"limits\": [1, 0]}}]}"
                .to_owned(),
            "joints[0].hinge.limits: is [1, 0]",
        ),
        (
            "{\"drystone\": 1, \"materials\": {\"a\": {}, \"a\": {}}}".to_owned(),
            "the name `a` is there twice",
        ),
        (
            "{\"drystone\": 1, \"strands\": [{\"rope\": {\"from\": [0,0,0], \"to\": [1,0,0], \"links\": 0}}]}".to_owned(),
            "strands[0].rope.links: is 0, allowed is 1 to 1,000,000",
        ),
    ];
    for (text, expected) in table {
        let found = error_of(&text);
        assert!(found.contains(expected), "{text}\n{found}\n{expected}");
    }
}

/// A text that is cut off anywhere is refused, without a panic.
#[test]
fn a_text_that_is_cut_off_is_refused() {
    let text = own::to_text(&named("hello").unwrap()).unwrap();
    for end in (0..text.trim_end().len()).filter(|end| text.is_char_boundary(*end)) {
        assert!(own::from_text(&text[..end], "x", Path::new("")).is_err(), "cut at {end}");
    }
}
