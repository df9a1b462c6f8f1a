//! The own format: files that are written read back to the same bits, and errors name their place.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests say what they found")]

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

/// Writes a scene, reads it, and steps both: they hold the same bits at the start and after every
/// step.
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

/// Errors in a file with one body, by the field where they are.
#[test]
fn what_is_wrong_is_told_with_line_field_and_what_is_allowed() {
    let body = |inner: &str| format!("{{\"drystone\": 1,\n\"bodies\": [\n  {{{inner}}}]}}");
    let table = [
        (
            "{\"drystone\": 2}".to_owned(),
            "line 1 column 14: drystone: is 2, expected 1, the version of the format",
        ),
        ("{\"bodies\": []}".to_owned(), "drystone: the version is missing"),
        ("{\"drystone\": 1,\n \"bodies\": [}".to_owned(), "line 2 column 13: broken JSON"),
        (body("\"colour\": 1"), "line 3 column 11: bodies[0].colour: unknown field `colour`, expected one of `name`"),
        (body("\"kind\": \"statik\""), "expected one of `static`, `kinematic`, `dynamic`"),
        (body("\"position\": [1, 2]"), "bodies[0].position: is a list of 2, expected a list of 3"),
        (
            body("\"shapes\": [{\"box\": {\"half_extents\": [1, 1, -1]}}]"),
            "bodies[0].shapes[0].box.half_extents.z: is -1, expected a length",
        ),
        (
            body("\"shapes\": [{\"sphere\": {\"radius\": 0}, \"density\": 2}]"),
            "line 3 column 37: bodies[0].shapes[0].sphere.radius: is 0",
        ),
        (
            body("\"shapes\": [{\"sphere\": {\"radius\": 1}, \"density\": -2}]"),
            "line 3 column 52: bodies[0].shapes[0].density: is -2",
        ),
        (body("\"shapes\": [{\"density\": 2}]"), "expected one of shape, sphere, capsule"),
        (
            body("\"shapes\": [{\"sphere\": {\"radius\": 1}, \"material\": \"ice\"}]"),
            "bodies[0].shapes[0].material: is \"ice\", which no material is called, expected none",
        ),
        (body("\"rotation\": [1, 1, 1, 1]"), "bodies[0].rotation: is [1, 1, 1, 1], expected a unit"),
        (body("\"name\": \"a\"}, {\"name\": \"a\""), "bodies[1].name: another body is called \"a\""),
        (
            "{\"drystone\": 1, \"world\": {\"contact\": {\"margin\": -1}}}".to_owned(),
            "line 1 column 49: world.contact.margin: is -1",
        ),
        (
            "{\"drystone\": 1, \"world\": {\"method\": \"magic\"}}".to_owned(),
            "world.method: is \"magic\", expected soft-step",
        ),
        (
            "{\"drystone\": 1, \"bodies\": [{}, {\"name\": \"b\"}], \"joints\": [{\"body_a\": 0, \"body_b\": \"c\", \"ball\": {}}]}"
                .to_owned(),
            "joints[0].body_b: is \"c\", which none of the bodies is, expected \"#0\", \"b\"",
        ),
        (
            "{\"drystone\": 1, \"bodies\": [{}, {}], \"joints\": [{\"body_a\": 0, \"body_b\": 1, \"hinge\": {\"limits\": [1, 0]}}]}"
                .to_owned(),
            "joints[0].hinge.limits: is [1, 0]",
        ),
        (body("\"shapes\": [{\"sphere\": 0.5}]"), "sphere: is 0.5, expected an object"),
        (body("\"shapes\": {}"), "bodies[0].shapes: is an object, expected a list"),
        (body("\"gravity_scale\": \"1\""), "gravity_scale: is \"1\", expected a number"),
        ("{\"drystone\": 1.5}".to_owned(), "is 1.5, expected a whole number"),
        (
            "{\"drystone\": 1, \"strands\": [{\"cloud\": {\"points\": [[0, 0, 0]]}, \"pins\": [0, 1]}]}"
                .to_owned(),
            "strands[0].pins[1]: is 1, expected below 1",
        ),
        (body("\"user_data\": 18446744073709551615, \"mass\": 1e39"), "line 3 column 47: a number is too large"),
        (
            "{\"drystone\": 1, \"materials\": {\"a\": {}, \"a\": {}}}".to_owned(),
            "the name `a` is there twice",
        ),
        (
            "{\"drystone\": 1, \"strands\": [{\"rope\": {\"from\": [0,0,0], \"to\": [1,0,0], \"links\": 0}}]}".to_owned(),
            "strands[0].rope.links: is 0, expected a number from 1 to 1,000,000",
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

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn second_of(scene: &Scene) -> usize {
    let mut running = scene.build().unwrap();
    let mut steps = 0.0;
    while steps < scene.hz {
        running.step(scene.hz.recip()).unwrap();
        assert!(running.world.events().faults.is_empty());
        steps += 1.0;
    }
    running.bodies.len()
}

#[test]
fn every_example_of_the_page_runs() {
    let page = std::fs::read_to_string(root().join("docs/format.md")).unwrap();
    let blocks: Vec<&str> = page
        .split("```json\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap_or_default())
        .collect();
    assert!(blocks.len() >= 8, "{} examples", blocks.len());
    for (i, block) in blocks.iter().enumerate() {
        let scene = own::from_text(block, "example", Path::new(""));
        let scene = scene.unwrap_or_else(|e| panic!("example {i}: {e}\n{block}"));
        assert!(second_of(&scene) > 1, "example {i}");
        goes_round(&scene, 10);
    }
}

#[test]
fn every_example_scene_runs_and_does_what_it_says() {
    let folder = root().join("examples/scenes");
    for path in files(&folder, "json") {
        let scene = own::load(&path, &own::Options::default()).unwrap_or_else(|e| panic!("{e}"));
        second_of(&scene);
        goes_round(&scene, 10);
    }
    // The rovers are still on the hills, of which the lowest point is 0.7 m below the origin.
    let rover = own::load(&folder.join("rover.json"), &own::Options::default()).unwrap();
    let mut running = rover.build().unwrap();
    for _ in 0..240 {
        running.step(1.0 / 60.0).unwrap();
    }
    for (name, id) in running.names.iter().zip(&running.bodies) {
        let at = running.world.body(*id).unwrap().position();
        assert!(at.y > -0.75, "{name} is at {at:?}");
    }
    // The door reaches its stop at 1.745 rad, within the give of a hard stop under 120 N m.
    let door = own::load(&folder.join("door.json"), &own::Options::default()).unwrap();
    let mut running = door.build().unwrap();
    for _ in 0..360 {
        running.step(1.0 / 60.0).unwrap();
    }
    let angle = running.world.joint(running.joints[0]).unwrap().angle().unwrap();
    assert!((angle - 1.745).abs() < 0.01, "{angle}");
    // All marbles end in the cup.
    let run = own::load(&folder.join("marble_run.json"), &own::Options::default()).unwrap();
    let mut running = run.build().unwrap();
    for _ in 0..600 {
        running.step(1.0 / 60.0).unwrap();
    }
    let marbles =
        running.names.iter().zip(&running.bodies).filter(|(n, _)| n.starts_with("marble"));
    for (name, id) in marbles {
        let at = running.world.body(*id).unwrap().position();
        let in_cup = (at.x - 0.85).abs() < 0.25 && at.z.abs() < 0.2 && at.y < 0.3;
        assert!(in_cup, "{name} is at {at:?}");
    }
}

/// `drystone convert --schema > docs/scene.schema.json` writes it.
#[test]
fn the_schema_in_docs_is_what_the_definitions_say() {
    let written = std::fs::read_to_string(root().join("docs/scene.schema.json")).unwrap();
    assert!(written == own::schema(), "docs/scene.schema.json is old: drystone convert --schema");
    assert!(written.contains("Radius [m]; above 0."), "descriptions are the doc comments");
}

fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("drystone-own-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

/// A pendulum of two bodies and a joint, in a frame of its own.
const PENDULUM: &str = r#"{"drystone": 1, "bodies": [
    {"name": "post", "kind": "static", "shapes": [{"box": {"half_extents": [0.1, 0.1, 0.1]}}]},
    {"name": "bob", "position": [1, 0, 0], "shapes": [{"sphere": {"radius": 0.2}}]}],
  "joints": [{"name": "pivot", "body_a": "post", "body_b": "bob", "at": [0, 0, 0], "axis": [0, 0, 1], "hinge": {}}],
  "frames": [{"name": "tip", "body": "bob", "position": [0.2, 0, 0]}]}"#;

#[test]
fn a_part_stands_where_it_is_put_and_moves_as_it_would_alone() {
    let folder = folder("parts");
    std::fs::write(folder.join("pendulum.json"), PENDULUM).unwrap();
    let whole = r#"{"drystone": 1,
      "bodies": [{"name": "here", "position": [0, 0, 8], "shapes": [{"sphere": {"radius": 0.1}}]}],
      "parts": [{"file": "pendulum.json", "name": "left", "position": [-4, 2, 0]},
                {"file": "pendulum.json", "name": "right", "position": [4, 2, 0], "rotation": {"axis": [0, 1, 0], "degrees": 90}}],
      "joints": [{"body_a": "here", "body_b": "left/post", "rope": {"length": 50}}]}"#;
    std::fs::write(folder.join("whole.json"), whole).unwrap();
    let scene = own::load(&folder.join("whole.json"), &own::Options::default()).unwrap();
    let names: Vec<&str> = scene.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["here", "left/post", "left/bob", "right/post", "right/bob"]);
    let joints: Vec<&str> = scene.joints.iter().map(|j| j.name.as_str()).collect();
    assert_eq!(joints, ["", "left/pivot", "right/pivot"]);
    assert_eq!((scene.joints[2].body_a, scene.joints[2].body_b), (3, 4));
    assert_eq!(scene.frames[1].name, "right/tip");
    let alone = own::from_text(PENDULUM, "", Path::new("")).unwrap();
    let (mut whole, mut alone) = (scene.build().unwrap(), alone.build().unwrap());
    for _ in 0..60 {
        whole.step(1.0 / 60.0).unwrap();
        alone.step(1.0 / 60.0).unwrap();
    }
    let at = |running: &drystone_scene::Running, n: usize| {
        running.world.body(running.bodies[n]).unwrap().position()
    };
    let bob = at(&alone, 1);
    // x of the part is -z of the world after a quarter turn about y. Rounding of a second of
    // swinging, at 4 m: 1e-4.
    let left = at(&whole, 2) - drystone::vec3(-4.0, 2.0, 0.0);
    let right = at(&whole, 4) - drystone::vec3(4.0, 2.0, 0.0);
    assert!((left - bob).length() < 1.0e-4, "{left:?} {bob:?}");
    assert!((right - drystone::vec3(bob.z, bob.y, -bob.x)).length() < 1.0e-4, "{right:?} {bob:?}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn parts_that_cannot_be_are_refused_at_their_place() {
    let folder = folder("bad-parts");
    std::fs::write(folder.join("pendulum.json"), PENDULUM).unwrap();
    let circle = r#"{"drystone": 1, "parts": [{"file": "circle.json", "name": "again"}]}"#;
    std::fs::write(folder.join("circle.json"), circle).unwrap();
    let wrong = r#"{"drystone": 1, "bodies": [{"kind": 3}]}"#;
    std::fs::write(folder.join("wrong.json"), wrong).unwrap();
    let error = |part: &str| {
        let text = format!("{{\"drystone\": 1,\n \"parts\": [{part}]}}");
        own::from_text(&text, "x", &folder).unwrap_err().to_string()
    };
    let circle = own::load(&folder.join("circle.json"), &own::Options::default()).unwrap_err();
    assert!(circle.to_string().contains("circle.json is a part of itself"), "{circle}");
    let table = [
        (r#"{"file": "none.json", "name": "a"}"#, "parts[0].file"),
        (r#"{"file": "/etc/passwd", "name": "a"}"#, "expected a path relative to this file"),
        (r#"{"file": "a.txt", "name": "a"}"#, "its name has no known ending"),
        (r#"{"file": "pendulum.json", "name": ""}"#, "parts[0].name: is empty"),
        (r#"{"file": "pendulum.json", "name": "a", "base": "fixed"}"#, "it is no .urdf file"),
        (
            r#"{"file": "wrong.json", "name": "a"}"#,
            "bodies[0].kind: is of another kind, expected a word",
        ),
        (
            r#"{"file": "pendulum.json", "name": "a"}, {"file": "pendulum.json", "name": "a"}"#,
            "another body is called \"a/post\" too",
        ),
    ];
    for (part, expected) in table {
        let found = error(part);
        assert!(found.contains(expected), "{part}\n{found}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}
