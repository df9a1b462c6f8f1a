//! `drystone convert` as its users meet it: what is written, what is named, exit statuses.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod command;
mod common;

use std::fs;
use std::path::Path;

use command::{drystone, text};
use common::folder;

/// Its output, and the lines it printed on stderr.
fn succeed(folder: &Path, args: &[&str]) -> (String, String) {
    let output = drystone(folder, args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", text(&output.stderr));
    (text(&output.stdout), text(&output.stderr))
}

/// The hash at the end of a simulation.
fn hash(folder: &Path, scene: &str) -> String {
    let (shown, _) = succeed(folder, &["simulate", scene, "--steps", "60", "--threads", "1"]);
    let line = shown.lines().find(|line| line.starts_with("hash")).unwrap().to_owned();
    line.split_whitespace().last().unwrap().to_owned()
}

#[test]
fn a_scene_that_is_converted_is_simulated_to_the_same_hash() {
    let folder = folder("convert-hash");
    for scene in ["wall:width=4,height=4,ball=1", "ragdolls:n=2", "rope:links=10"] {
        let (_, named) = succeed(&folder, &["convert", scene, "scene.json"]);
        assert_eq!(named, "", "the own format says all");
        assert_eq!(hash(&folder, scene), hash(&folder, "scene.json"), "{scene}");
    }
    // Through glTF, where that says all of it.
    succeed(&folder, &["convert", "pyramid:base=4", "pyramid.glb", "--strict"]);
    assert_eq!(hash(&folder, "pyramid:base=4"), hash(&folder, "pyramid.glb"));
    succeed(&folder, &["convert", "pyramid.glb", "pyramid.json", "--strict"]);
    assert_eq!(hash(&folder, "pyramid.glb"), hash(&folder, "pyramid.json"));
}

#[test]
fn what_gltf_cannot_say_is_named_and_refused_with_strict() {
    let folder = folder("convert-strict");
    let (_, named) = succeed(&folder, &["convert", "rope:links=5", "rope.gltf"]);
    assert!(named.contains("rope.gltf: left out: a rope, cloth or cloud, 1 time"), "{named}");
    fs::write(folder.join("kept.glb"), "as it was").unwrap();
    let output = drystone(&folder, &["convert", "rope:links=5", "kept.glb", "--strict"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("--strict allows none"));
    assert_eq!(fs::read_to_string(folder.join("kept.glb")).unwrap(), "as it was");
}

#[test]
fn a_file_with_physics_that_is_not_read_is_refused_with_strict() {
    let folder = folder("read-strict");
    let body = |joint: &str| {
        format!(
            "<mujoco><worldbody><body><joint {joint}/><geom size=\".1\"/></body></worldbody></mujoco>"
        )
    };
    fs::write(folder.join("plain.xml"), body("damping=\"1\"")).unwrap();
    fs::write(folder.join("rich.xml"), body("springdamper=\".1 1\"")).unwrap();
    for command in ["info", "simulate"] {
        succeed(&folder, &[command, "plain.xml", "--strict"]);
        succeed(&folder, &[command, "rich.xml"]);
        let output = drystone(&folder, &[command, "rich.xml", "--strict"]);
        assert_eq!(output.status.code(), Some(1), "{command}");
        let said = text(&output.stderr);
        assert!(said.contains("rich.xml: 1 kind of physics not read"), "{said}");
        assert!(said.contains("<joint springdamper>"), "{said}");
    }
}

#[test]
fn wrong_endings_are_wrong_usage_and_wrong_files_are_told_by_line() {
    let folder = folder("convert-wrong");
    let output = drystone(&folder, &["convert", "hello", "hello.urdf"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains(".json (the own format), .glb or .gltf"));
    assert_eq!(drystone(&folder, &["convert", "hello"]).status.code(), Some(2));
    let wrong = "{\"drystone\": 1,\n \"bodies\": [{\"mass\": -1}]}";
    fs::write(folder.join("wrong.json"), wrong).unwrap();
    let output = drystone(&folder, &["simulate", "wrong.json"]);
    assert_eq!(output.status.code(), Some(1));
    let told = text(&output.stderr);
    assert!(
        told.starts_with("error: wrong.json: line 2 column 22: bodies[0].mass: is -1"),
        "{told}"
    );
    fs::write(folder.join("neither.json"), "{\"a\": 1}").unwrap();
    let output = drystone(&folder, &["info", "neither.json"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("\"drystone\": 1 at its top"));
}

#[test]
fn a_run_of_the_own_format_is_saved_resumed_recorded_and_baked() {
    let folder = folder("convert-run");
    succeed(&folder, &["convert", "wall:width=4,height=4,ball=1", "wall.json"]);
    let half = ["simulate", "wall.json", "--steps", "30", "--snapshot", "half.run"];
    succeed(&folder, &half);
    let (shown, _) =
        succeed(&folder, &["simulate", "--resume", "half.run", "--steps", "30", "--bake", "b.glb"]);
    assert!(shown.contains(&hash(&folder, "wall.json")), "{shown}");
    let record = ["simulate", "wall.json", "--steps", "20", "--record", "run.log"];
    succeed(&folder, &record);
    let (shown, _) = succeed(&folder, &["replay", "run.log"]);
    assert!(shown.contains("every bit the same"), "{shown}");
    // Another scene is refused.
    succeed(&folder, &["convert", "hello", "wall.json"]);
    let other = drystone(&folder, &["simulate", "--resume", "half.run", "--steps", "1"]);
    assert_eq!(other.status.code(), Some(1));
    assert!(text(&other.stderr).contains("another scene"));
}

#[test]
fn looks_of_a_gltf_file_are_named_where_it_is_beside() {
    let folder = folder("convert-looks");
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    succeed(&folder, &["convert", "hello", "made.gltf"]);
    // Meshes that drystone itself made show nothing but the shapes.
    succeed(&folder, &["convert", "made.gltf", "made.json", "--strict"]);
    assert!(!read("made.json").contains("visuals"));
    let other = "\"generator\":\"another\"";
    let other = read("made.gltf").replace("\"generator\":\"drystone\"", other);
    fs::write(folder.join("hello.gltf"), other).unwrap();
    succeed(&folder, &["convert", "hello.gltf", "beside.json", "--strict"]);
    assert!(read("beside.json").contains("\"visuals\": \"hello.gltf\""));
    let (shown, _) = succeed(&folder, &["info", "beside.json"]);
    assert!(shown.contains("visible part"), "{shown}");
    fs::create_dir(folder.join("away")).unwrap();
    let (_, named) = succeed(&folder, &["convert", "hello.gltf", "away/hello.json"]);
    assert!(named.contains("left out: a mesh to look at"), "{named}");
}

#[test]
fn a_robot_is_an_articulation_on_request() {
    let folder = folder("reduced");
    let arm = "<mujoco><worldbody><body pos=\"0 0 1\"><joint axis=\"0 1 0\" armature=\".1\"/>\
               <geom size=\".1\" pos=\".3 0 0\"/></body></worldbody></mujoco>";
    fs::write(folder.join("arm.xml"), arm).unwrap();
    succeed(&folder, &["simulate", "arm.xml", "--reduced", "--strict", "--steps", "30"]);
    let output = drystone(&folder, &["simulate", "arm.xml", "--strict", "--steps", "30"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("armature counts only with --reduced"));
    for scene in ["wall", "empty.xml"] {
        fs::write(folder.join("empty.xml"), "<mujoco/>").unwrap();
        let output = drystone(&folder, &["simulate", scene, "--reduced", "--steps", "1"]);
        assert_eq!(output.status.code(), Some(2), "{scene}");
        assert!(text(&output.stderr).contains("--reduced is for .urdf and MJCF files"), "{scene}");
    }
}
