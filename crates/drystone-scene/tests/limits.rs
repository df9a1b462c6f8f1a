//! Files that ask for more than they say, and the inputs that fuzzing begins with: each is read or
//! refused, soon.
//!
//! No test reads a clock: what grows with a product of two counts of a file takes minutes or all
//! memory here, not seconds.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine;
use drystone_scene::gltf::{self, AutoColliders, Options};
use drystone_scene::{SceneError, mjcf, obj, rigid_ipc, stl, urdf};

const NOWHERE: &str = "/nonexistent";

fn mjcf_of(text: &str) -> Result<drystone_scene::Scene, SceneError> {
    mjcf::from_text(text, Path::new(NOWHERE))
}

fn refused<T: std::fmt::Debug>(result: Result<T, SceneError>, part: &str) {
    let e = result.unwrap_err().to_string();
    assert!(e.contains(part), "{e}");
}

/// A ball on two strings, copied so often.
fn cradle(count: usize) -> String {
    format!(
        r#"<mujoco><default><geom size="0.02"/><tendon limited="true" range="0 0.2"/></default><worldbody>
        <replicate count="{count}" offset="-0.04 0 0"><site name="a" pos="0 -0.04 0.2"/><site name="c" pos="0 0.04 0.2"/>
        <body name="ball" pos="0 0 0.04"><freejoint/><geom/><site name="b"/><site name="d"/></body></replicate>
        </worldbody><tendon><spatial><site site="a"/><site site="b"/></spatial>
        <spatial><site site="c"/><site site="d"/></spatial></tendon>
        <contact><exclude body1="ball" body2="ball"/></contact></mujoco>"#
    )
}

#[test]
fn names_of_many_copies_are_found_at_once() {
    let scene = mjcf_of(&cradle(65_536)).unwrap();
    assert_eq!((scene.bodies.len(), scene.joints.len()), (65_537, 131_072));
    // Each string holds its own copy.
    let few = mjcf_of(&cradle(3)).unwrap();
    let held: Vec<usize> = few.joints.iter().map(|j| j.body_a.max(j.body_b)).collect();
    assert_eq!(held, [1, 2, 3, 1, 2, 3]);
}

#[test]
fn copies_without_end_are_refused() {
    let inside = |open: &str, close: &str, deep: usize| {
        let (open, close) = (open.repeat(deep), close.repeat(deep));
        mjcf_of(&format!(
            r#"<mujoco><worldbody>{open}<site name="s"/>{close}<geom size="1"/></worldbody></mujoco>"#
        ))
    };
    refused(inside(r#"<replicate count="199999">"#, "</replicate>", 2), "more than 200000 bodies");
    refused(inside(r#"<replicate count="1">"#, "</replicate>", 17), "expected 16 deep");
    // Sites are no bodies.
    let sites = r#"<site name="s"/>"#.repeat(1000);
    let many = format!(
        r#"<mujoco><worldbody><replicate count="100000">{sites}</replicate></worldbody></mujoco>"#
    );
    refused(mjcf_of(&many), "more than 4000000 elements");
    let sep = "x".repeat(10_000);
    let long = format!(
        r#"<mujoco><worldbody><replicate count="100000" sep="{sep}"><body/></replicate></worldbody></mujoco>"#
    );
    refused(mjcf_of(&long), "its name is too long");
}

#[test]
fn includes_that_multiply_are_refused() {
    let folder = std::env::temp_dir().join(format!("drystone-limits-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    for level in 0..15 {
        let include = format!(r#"<include file="{}.xml"/>"#, level + 1).repeat(10);
        fs::write(folder.join(format!("{level}.xml")), format!("<mujoco>{include}</mujoco>"))
            .unwrap();
    }
    fs::write(folder.join("15.xml"), "<mujoco/>").unwrap();
    let text = r#"<mujoco><include file="0.xml"/></mujoco>"#;
    refused(mjcf::from_text(text, &folder), "more than 4000000 elements");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn default_classes_have_a_size() {
    let geoms = r#"<geom density="1"/>"#.repeat(300);
    refused(mjcf_of(&format!("<mujoco><default>{geoms}</default></mujoco>")), "up to 256 elements");
    let mut text = String::new();
    for class in 0..70 {
        let _ = write!(text, r#"<default class="c{class}">"#);
    }
    text.push_str(&"</default>".repeat(70));
    refused(mjcf_of(&format!("<mujoco>{text}</mujoco>")), "up to 64 classes");
}

#[test]
fn a_robot_of_many_links_is_read() {
    let mut text = String::from(r#"<robot name="r"><link name="l0"/>"#);
    let inertia = r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"#;
    for i in 1..20_000 {
        let _ = write!(
            text,
            r#"<link name="l{i}">{inertia}<collision><geometry><sphere radius="1"/></geometry></collision></link>
            <joint name="j{i}" type="continuous"><parent link="l0"/><child link="l{i}"/><axis xyz="0 0 1"/></joint>"#
        );
    }
    text.push_str("</robot>");
    // All in one place: every two of them overlap.
    let options = urdf::Options { base: urdf::Base::Fixed, ground: None };
    let scene = urdf::from_text(&text, Path::new(NOWHERE), &options).unwrap();
    assert!(scene.notes.iter().any(|n| n.contains("more than 1000 links")), "{:?}", scene.notes);
}

#[test]
fn many_parts_of_many_vertices_are_read() {
    let mut text = String::new();
    for i in 0..60_000 {
        let _ = writeln!(text, "v {i} 0 0\nv {i} 1 0\nv {i} 0 1\nv {i}.5 0 0");
    }
    for i in 0..60_000 {
        let at = 4 * i;
        let [a, b, c, d] = [at + 1, at + 2, at + 3, at + 4];
        let _ = writeln!(text, "o {i}\nf {a} {b} {c}\nf {a} {b} {d}\nf {a} {c} {d}\nf {b} {c} {d}");
    }
    let options = Options { auto_colliders: Some(AutoColliders::Box), ..Options::default() };
    let loaded = obj::from_slice(text.as_bytes(), "parts", &options).unwrap();
    assert_eq!(loaded.scene.bodies.len(), 60_000);
}

/// Found by the search for what breaks: the library that decomposes meshes panics on a cylinder
/// with one corner out of place.
#[test]
fn a_mesh_that_cannot_be_decomposed_is_taken_as_its_hull() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/rigid-ipc/meshes/cylinder.obj");
    let text = fs::read_to_string(path).unwrap();
    let (right, wrong) = ("v 0.634393 1.500000 0.773011", "v 0.634393 1.500000 1.500000 0.773011");
    assert!(text.contains(right));
    let options = Options { auto_colliders: Some(AutoColliders::Hull), ..Options::default() };
    let text = text.replace(right, wrong);
    let loaded = obj::from_slice(text.as_bytes(), "cylinder", &options).unwrap();
    assert!(loaded.scene.bodies[0].def.validate().is_ok());
}

/// A document whose meshes are the same `vertices` points, corners of a cube, in all nodes.
fn document(vertices: usize, nodes: &str) -> String {
    let side = |i: usize, axis: usize| if (i >> axis) % 2 == 1 { 1.0_f32 } else { 0.0 };
    let corner = |i: usize| [0, 1, 2].map(|axis| side(i, axis).to_le_bytes());
    let bytes: Vec<u8> = (0..vertices).flat_map(|i| corner(i).into_iter().flatten()).collect();
    let bytes = base64::engine::general_purpose::STANDARD.encode(bytes);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{0},"uri":"data:application/octet-stream;base64,{bytes}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{0}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{vertices},"type":"VEC3"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{nodes}]}}"#,
        12 * vertices
    )
}

fn gltf_of(text: &str) -> Result<gltf::LoadedGltf, SceneError> {
    let options = Options { auto_colliders: Some(AutoColliders::Box), ..Options::default() };
    gltf::from_slice(text.as_bytes(), "a.gltf", Path::new(NOWHERE), &options)
}

#[test]
fn a_mesh_that_is_named_without_end_is_refused() {
    let nodes = [r#"{"mesh":0}"#; 2_100].join(",");
    refused(gltf_of(&document(100_000, &nodes)), "more than 200000000 vertices");
}

#[test]
fn nodes_without_end_in_one_another_are_refused() {
    let node = |i: usize| format!(r#"{{"mesh":0,"children":[{}]}}"#, i + 1);
    let mut nodes: Vec<String> = (0..1500).map(node).collect();
    nodes.push("{}".to_owned());
    refused(gltf_of(&document(3, &nodes.join(","))), "expected up to 1024 nodes");
}

#[test]
fn files_beside_a_scene_must_be_regular() {
    for uri in ["../../../../../../../../dev/zero", "../../../../../../../../dev"] {
        let text = format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":4,"uri":"{uri}"}}]}}"#
        );
        let folder = std::env::temp_dir();
        let read = gltf::from_slice(text.as_bytes(), "a.gltf", &folder, &Options::default());
        let e = read.unwrap_err().to_string();
        assert!(e.contains("not a regular file") || e.contains("is a directory"), "{e}");
    }
    refused(mjcf_of(r#"<mujoco><include file="/etc/passwd"/></mujoco>"#), "relative to the file");
}

/// The inputs that fuzzing of a reader begins with.
fn inputs(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(name);
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "{name}");
    paths.into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}

#[test]
fn what_fuzzing_begins_with_is_read_or_refused() {
    let folder = Path::new(NOWHERE);
    let auto = |kind| Options { auto_colliders: Some(kind), ..Options::default() };
    for (path, bytes) in inputs("gltf") {
        for kind in [AutoColliders::Box, AutoColliders::Hull, AutoColliders::Mesh] {
            match gltf::from_slice(&bytes, "fuzz", folder, &auto(kind)) {
                Ok(mut loaded) => {
                    loaded.read_visuals();
                    let _ = loaded.scene.build();
                    let _ = gltf::film(loaded);
                }
                Err(e) => assert!(
                    ["cut", "outside", "counts"]
                        .iter()
                        .any(|n| path.ends_with(format!("{n}.gltf"))
                            || path.ends_with(format!("{n}.glb"))),
                    "{path:?}: {e}"
                ),
            }
        }
    }
    for (_, bytes) in inputs("image") {
        let image = base64::engine::general_purpose::STANDARD.encode(bytes);
        let text = document(3, r#"{"mesh":0}"#)
            .replace(r#""POSITION":0}"#, r#""POSITION":0},"material":0"#);
        let text = text.replacen(
            '{',
            &format!(
                r#"{{"images":[{{"uri":"data:image/png;base64,{image}"}}],"textures":[{{"source":0}}],
                "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],"#
            ),
            1,
        );
        gltf_of(&text).unwrap().read_visuals();
    }
    for (_, bytes) in inputs("obj") {
        let _ =
            obj::from_slice(&bytes, "fuzz", &auto(AutoColliders::Mesh)).map(|l| l.scene.build());
    }
    for (_, bytes) in inputs("stl") {
        let _ = stl::corners(&bytes);
    }
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    for (_, bytes) in inputs("mjcf") {
        let _ = mjcf_of(&text(bytes)).map(|scene| scene.build());
    }
    for (_, bytes) in inputs("urdf") {
        let options = urdf::Options { ground: Some(0.0), ..urdf::Options::default() };
        let _ = urdf::from_text(&text(bytes), folder, &options).map(|scene| scene.build());
    }
    for (_, bytes) in inputs("rigid_ipc") {
        let _ = rigid_ipc::from_text(&text(bytes), "fuzz", folder).map(|scene| scene.build());
    }
}
