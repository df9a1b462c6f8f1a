//! glTF files: what they are read into, what is refused and how, and what is written.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail anywhere")]

use std::fs;
use std::path::{Path, PathBuf};

use drystone::contact::Combine;
use drystone::{
    BodyDef, BodyKind, Hull, MassDef, Material, Mesh, Pose, Quat, Shape, ShapeDef, Vec3, vec3,
};
use drystone_scene::bake::{self, Motion};
use drystone_scene::gltf::{self, AutoColliders, LoadedGltf, Options};
use drystone_scene::{Scene, SceneError};
use serde_json::{Value, json};

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf-khr-own")
}

fn load(name: &str) -> LoadedGltf {
    gltf::load(&data().join(name), &Options::default()).unwrap()
}

/// A folder for files of this test run.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn samples() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(data())
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "gltf"))
        .collect();
    files.sort();
    files
}

fn read(value: &Value, options: &Options) -> Result<LoadedGltf, SceneError> {
    gltf::from_slice(value.to_string().as_bytes(), "test", Path::new(""), options)
}

/// A document with one shape list and these nodes, all in the scene.
fn physics(shapes: Value, nodes: Value) -> Value {
    json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_implicit_shapes", "KHR_physics_rigid_bodies"],
        "extensions": {"KHR_implicit_shapes": {"shapes": shapes}},
        "nodes": nodes,
    })
}

fn with(physics: Value) -> Value {
    json!({"KHR_physics_rigid_bodies": physics})
}

#[test]
fn every_sample_has_the_bodies_and_shapes_its_text_says() {
    let expected = [
        ("compound_and_scale", "#0 static box; body dynamic box box"),
        ("filter_collide_notcollide", "#0 static box; a dynamic sphere; b dynamic sphere"),
        ("incline_25_mu05", "#0 static box; body dynamic box"),
        ("incline_30_mu05", "#0 static box; body dynamic box"),
        ("joint_ball_pendulum", "anchor static box; body dynamic box"),
        ("joint_fixed", "anchor static box; body dynamic box"),
        ("joint_hinge_velocity_drive", "anchor static box; body dynamic box"),
        ("joint_hinge_z", "anchor static box; body dynamic box"),
        ("joint_linear_position_drive", "anchor static box; body dynamic box"),
        ("joint_prismatic_y_limit", "anchor static box; body dynamic box"),
        ("motion_constant_velocity", "body dynamic box"),
        ("motion_infinite_inertia", "#0 static box; ledge static box; body dynamic box"),
        ("motion_kinematic", "#0 static box; platform kinematic box; rider dynamic box"),
        ("rest_box", "#0 static box; body dynamic box"),
        ("rest_capsule", "#0 static box; body dynamic capsule"),
        ("rest_convexhull_on_meshfloor", "#0 static mesh; body dynamic hull"),
        ("rest_cylinder", "#0 static box; body dynamic cylinder"),
        ("rest_sphere", "#0 static box; body dynamic sphere"),
        ("restitution_combine", "#0 static box; max dynamic sphere; min dynamic sphere"),
        ("slide_box_over_mesh_seams", "#0 static mesh; body dynamic box"),
        ("trigger_enter_exit", "trigger static box(sensor); body dynamic sphere"),
    ];
    let words = |l: &LoadedGltf| {
        let body = |b: &drystone_scene::SceneBody| {
            let shapes: Vec<String> = b
                .def
                .shapes
                .iter()
                .map(|s| format!("{}{}", s.shape.kind(), if s.sensor { "(sensor)" } else { "" }))
                .collect();
            format!(
                "{} {} {}",
                b.name,
                format!("{:?}", b.def.kind).to_lowercase(),
                shapes.join(" ")
            )
        };
        l.scene.bodies.iter().map(body).collect::<Vec<_>>().join("; ")
    };
    let files = samples();
    assert_eq!(files.len(), expected.len());
    for (file, (name, text)) in files.iter().zip(expected) {
        assert_eq!(file.file_stem().unwrap().to_str().unwrap(), name);
        let loaded = gltf::load(file, &Options::default()).unwrap();
        assert_eq!(words(&loaded), text, "{name}");
        assert!((loaded.scene.config.gravity - vec3(0.0, -9.81, 0.0)).length() < 1e-6);
        assert_eq!(loaded.scene.joints.len(), usize::from(name.starts_with("joint")), "{name}");
        let about = gltf::info(&loaded);
        assert!(about.contains(&format!("bodies: {}", loaded.scene.bodies.len())), "{about}");
    }
}

#[test]
fn masses_materials_filters_and_velocities_are_those_of_the_file() {
    let l = load("restitution_combine.gltf");
    let m: Vec<_> = l.scene.bodies.iter().map(|b| b.def.shapes[0].material).collect();
    assert_eq!(m[0].restitution_combine, Combine::Maximum);
    assert!((m[1].restitution - 0.8).abs() < 1e-6);
    let e = |a: usize, b: usize| {
        m[a].restitution_combine.apply(m[b].restitution_combine, m[a].restitution, m[b].restitution)
    };
    assert!((e(0, 1) - 0.8).abs() < 1e-6, "maximum against maximum");
    assert!(e(0, 2).abs() < 1e-6, "minimum is stronger than maximum");

    let l = load("filter_collide_notcollide.gltf");
    let f: Vec<_> = l.scene.bodies.iter().map(|b| b.def.shapes[0].filter).collect();
    assert!(f[0].collides_with(f[1]) && !f[0].collides_with(f[2]) && !f[1].collides_with(f[2]));

    let l = load("motion_infinite_inertia.gltf");
    assert!(matches!(l.scene.bodies[2].def.mass, MassDef::Exact { mass, inertia, .. }
        if (mass - 1.0).abs() < 1e-6 && inertia == drystone::math::Sym3::ZERO));

    let l = load("motion_constant_velocity.gltf");
    let def = &l.scene.bodies[0].def;
    assert_eq!((def.linear_velocity, def.angular_velocity), (Vec3::X, Vec3::Z));
    assert!(def.gravity_scale.abs() < 1e-9 && matches!(def.mass, MassDef::Mass(_)));

    // A velocity is given in the node's frame: a quarter turn about z takes x to y.
    let h = core::f32::consts::FRAC_1_SQRT_2;
    let node = json!([{"rotation": [0, 0, h, h], "extensions": with(json!({
        "motion": {"linearVelocity": [2, 0, 0], "mass": 2, "inertiaDiagonal": [1, 2, 3], "centerOfMass": [0, 0.5, 0]},
        "collider": {"geometry": {"shape": 0}}}))}]);
    let l = read(&physics(json!([{"type": "sphere"}]), node), &Options::default()).unwrap();
    let def = &l.scene.bodies[0].def;
    assert!((def.linear_velocity - vec3(0.0, 2.0, 0.0)).length() < 1e-6);
    let MassDef::Exact { center, inertia, .. } = def.mass else { panic!("exact mass") };
    assert!((center - vec3(0.0, 0.5, 0.0)).length() < 1e-6 && (inertia.yy - 2.0).abs() < 1e-5);
}

#[test]
fn colliders_meet_if_each_is_in_one_of_the_systems_that_the_other_collides_with() {
    let filters = json!([
        {"collisionSystems": ["a", "b"], "collideWithSystems": ["a", "b"]},
        {"collisionSystems": ["a"], "collideWithSystems": ["a"]},
        {"collisionSystems": ["b"], "collideWithSystems": ["b"]},
        {"collisionSystems": ["c"], "notCollideWithSystems": ["a"]},
        {"collisionSystems": ["c", "d"]},
        {"collideWithSystems": ["a"]},
    ]);
    let collider = |filter: Option<usize>, y: f32| {
        let mut collider = json!({"geometry": {"shape": 0}});
        if let Some(filter) = filter {
            collider["collisionFilter"] = json!(filter);
        }
        json!({"translation": [0, y, 0], "extensions": with(json!({"motion": {}, "collider": collider}))})
    };
    let kinds = [Some(0), Some(1), Some(2), Some(3), Some(4), Some(5), None];
    let heights = [0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0];
    let nodes: Vec<_> = kinds.iter().zip(heights).map(|(k, y)| collider(*k, y)).collect();
    let mut document = physics(json!([{"type": "sphere"}]), json!(nodes));
    document["extensions"]["KHR_physics_rigid_bodies"] = json!({"collisionFilters": filters});
    let loaded = read(&document, &Options::default()).unwrap();
    let found: Vec<_> = loaded.scene.bodies.iter().map(|b| b.def.shapes[0].filter).collect();
    // A collider in no system is in no list. One without lists collides with all.
    let meet = [
        [1, 1, 1, 0, 0, 0, 0],
        [1, 1, 0, 0, 0, 0, 0],
        [1, 0, 1, 0, 0, 0, 0],
        [0, 0, 0, 1, 1, 0, 1],
        [0, 0, 0, 1, 1, 0, 1],
        [0, 0, 0, 0, 0, 0, 0],
        [0, 0, 0, 1, 1, 0, 1],
    ];
    for (a, row) in meet.iter().enumerate() {
        for (b, meets) in row.iter().enumerate() {
            assert_eq!(found[a].collides_with(found[b]), *meets == 1, "{a} and {b}");
        }
    }
}

#[test]
fn a_box_takes_the_scale_of_its_node_and_of_all_above() {
    let nodes = json!([
        {"scale": [2, 2, 2], "children": [1]},
        {"name": "b", "translation": [1, 0, 0], "children": [2], "extensions": with(json!({"motion": {}}))},
        {"translation": [0, 3, 0], "scale": [1, -2, 3], "extensions": with(json!({"collider": {"geometry": {"shape": 0}}}))},
    ]);
    let l = read(
        &physics(json!([{"type": "box", "box": {"size": [1, 1, 1]}}]), nodes),
        &Options::default(),
    )
    .unwrap();
    let def = &l.scene.bodies[0].def;
    assert_eq!(def.position, vec3(2.0, 0.0, 0.0));
    let Shape::Box { half_extents } = def.shapes[0].shape else { panic!("a box") };
    assert!((half_extents - vec3(1.0, 2.0, 3.0)).length() < 1e-5, "{half_extents:?}");
    assert!((def.shapes[0].pose.position - vec3(0.0, 6.0, 0.0)).length() < 1e-5);
}

#[test]
fn both_spellings_of_mesh_geometry_and_the_old_ones_say_the_same() {
    let text = fs::read_to_string(data().join("rest_convexhull_on_meshfloor.gltf")).unwrap();
    let base: Value = serde_json::from_str(&text).unwrap();
    let reference = read(&base, &Options::default()).unwrap();
    let vertices = |l: &LoadedGltf| match &l.scene.bodies[1].def.shapes[0].shape {
        Shape::Hull(h) => h.vertices().to_vec(),
        other => panic!("{}", other.kind()),
    };
    let collider = "/nodes/1/extensions/KHR_physics_rigid_bodies/collider";
    let mut by_mesh = base.clone();
    *by_mesh.pointer_mut(collider).unwrap() = json!({"geometry": {"mesh": 0, "convexHull": true}});
    let mut by_shape = base.clone();
    *by_shape.pointer_mut(collider).unwrap() = json!({"shape": 0});
    let hull = json!({"KHR_physics_rigid_bodies": {"convexHull": true}});
    by_shape["extensions"]["KHR_implicit_shapes"] =
        json!({"shapes": [{"type": "mesh", "mesh": {"mesh": 0}, "extensions": hull}]});
    for other in [by_mesh, by_shape] {
        let other = read(&other, &Options::default()).unwrap();
        assert_eq!(vertices(&reference), vertices(&other));
    }
    // Without the flag a moving mesh is made convex, with a note.
    let mut moving = base;
    *moving.pointer_mut(collider).unwrap() = json!({"geometry": {"node": 1}});
    let moving = read(&moving, &Options::default()).unwrap();
    assert_eq!(moving.scene.bodies[1].def.shapes[0].shape.kind(), "hull");
    assert!(moving.scene.notes.iter().any(|n| n.contains("convex")), "{:?}", moving.scene.notes);
}

#[test]
fn uneven_shapes_become_hulls_and_planes_ground() {
    let shapes = json!([
        {"type": "sphere", "sphere": {"radius": 1}},
        {"type": "capsule", "capsule": {"height": 2, "radiusTop": 0.5, "radiusBottom": 1}},
        {"type": "cylinder", "cylinder": {"height": 2, "radiusTop": 0, "radiusBottom": 1}},
        {"type": "plane", "plane": {}},
    ]);
    let part = |shape: usize| with(json!({"collider": {"geometry": {"shape": shape}}}));
    let nodes = json!([
        {"scale": [1, 2, 1], "extensions": part(0)},
        {"extensions": part(1)},
        {"extensions": part(2)},
        {"extensions": part(3)},
        {"extensions": with(json!({"motion": {}, "collider": {"geometry": {"shape": 0}}}))},
    ]);
    let l = read(&physics(shapes, nodes), &Options::default()).unwrap();
    let kinds: Vec<_> = l.scene.bodies.iter().map(|b| b.def.shapes[0].shape.kind()).collect();
    assert_eq!(kinds, ["hull", "hull", "cone", "half-space", "sphere"]);
    let Shape::Hull(ball) = &l.scene.bodies[0].def.shapes[0].shape else { panic!("a hull") };
    assert!((ball.bounds().max.y - 2.0).abs() < 0.02 && (ball.bounds().max.x - 1.0).abs() < 0.02);
    let Shape::Hull(egg) = &l.scene.bodies[1].def.shapes[0].shape else { panic!("a hull") };
    assert!((egg.bounds().max.y - 1.5).abs() < 0.02 && (egg.bounds().min.y + 2.0).abs() < 0.02);
    assert_eq!(l.scene.notes.len(), 2, "{:?}", l.scene.notes);
}

#[test]
fn triggers_of_a_compound_are_one_body() {
    let nodes = json!([
        {"name": "zone", "children": [1, 2], "extensions": with(json!({"trigger": {"nodes": [1, 2]}}))},
        {"translation": [1, 0, 0], "extensions": with(json!({"trigger": {"geometry": {"shape": 0}}}))},
        {"translation": [-1, 0, 0], "extensions": with(json!({"trigger": {"geometry": {"shape": 0}}}))},
    ]);
    let l = read(&physics(json!([{"type": "sphere"}]), nodes), &Options::default()).unwrap();
    assert_eq!(l.scene.bodies.len(), 1);
    let zone = &l.scene.bodies[0];
    assert_eq!((zone.name.as_str(), zone.def.shapes.len()), ("zone", 2));
    assert!(zone.def.shapes.iter().all(|s| s.sensor));
    assert!((zone.def.shapes[1].pose.position - vec3(-1.0, 0.0, 0.0)).length() < 1e-6);
}

/// An L of two boxes as one mesh of a node without physics, and a floor.
fn decoration() -> Value {
    let mut scene = Scene::new("l", "");
    let quad = |v: &mut Vec<Vec3>, t: &mut Vec<[u32; 3]>, c: Vec3, h: Vec3| {
        let base = u32::try_from(v.len()).unwrap();
        let hull = Hull::from_points(
            &(0..8_u8)
                .map(|i| {
                    let s = |b: u8| if i >> b & 1 == 1 { 1.0 } else { -1.0 };
                    c + vec3(s(0), s(1), s(2)).mul_each(h)
                })
                .collect::<Vec<_>>(),
        )
        .unwrap();
        v.extend(hull.vertices());
        for f in 0..hull.planes().len() {
            let l: Vec<u32> = hull.face(f).iter().map(|&i| base + u32::from(i)).collect();
            for k in 1..l.len() - 1 {
                t.push([l[0], l[k], l[k + 1]]);
            }
        }
    };
    let (mut v, mut t) = (Vec::new(), Vec::new());
    quad(&mut v, &mut t, vec3(1.0, 0.25, 0.0), vec3(1.0, 0.25, 0.5));
    quad(&mut v, &mut t, vec3(0.25, 1.25, 0.0), vec3(0.25, 0.75, 0.5));
    let mesh = Shape::Mesh(std::sync::Arc::new(Mesh::new(v, t).unwrap()));
    scene.add(
        "floor",
        BodyDef::fixed()
            .with_position([0.0, -2.0, 0.0])
            .with_shape(ShapeDef::box_half([5.0, 0.5, 5.0])),
    );
    scene.add("l", BodyDef::fixed().with_shape(ShapeDef::new(mesh)));
    let path = scratch("decoration").join("l.gltf");
    let still = Motion { poses: vec![vec![]; 2], ..Motion::default() };
    bake::write_scene(&path, &scene, &[], &still).unwrap();
    let mut value: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
    let object = value.as_object_mut().unwrap();
    object.remove("extensions");
    object.remove("extensionsUsed");
    for node in object["nodes"].as_array_mut().unwrap() {
        node.as_object_mut().unwrap().remove("extensions");
    }
    value
}

#[test]
fn files_without_physics_get_bodies_on_request() {
    let value = decoration();
    let e = read(&value, &Options::default()).unwrap_err();
    assert!(e.to_string().contains("--auto-colliders"), "{e}");
    for (how, kind) in
        [(AutoColliders::Hull, "hull"), (AutoColliders::Box, "box"), (AutoColliders::Mesh, "hull")]
    {
        let l = read(&value, &Options { auto_colliders: Some(how), ..Options::default() }).unwrap();
        assert_eq!(l.scene.bodies[0].def.kind, BodyKind::Static);
        let body = &l.scene.bodies[1];
        assert_eq!((body.def.kind, body.name.as_str()), (BodyKind::Dynamic, "l"));
        assert_eq!(body.def.shapes[0].shape.kind(), kind);
        if how == AutoColliders::Mesh {
            let parts = body.def.shapes.len();
            assert!((2..8).contains(&parts), "an L is a few convex parts, not {parts}");
            // No part may fill the notch.
            let notch = vec3(1.2, 1.2, 0.0);
            for part in &body.def.shapes {
                let Shape::Hull(h) = &part.shape else { panic!("a hull") };
                assert!(h.planes().iter().any(|p| p.distance(notch) > 0.2));
            }
        }
    }
}

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

/// The next number of a simple generator.
fn next(state: &mut u64) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    usize::try_from(*state >> 33).unwrap()
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
                // What was read can be written.
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

/// The world pose of each node of a written file at a time, by the rules of viewers.
fn sampled(path: &Path, time: f32) -> (Vec<Pose>, ::gltf::Document) {
    // The other reader also validates the file.
    let (document, buffers) = {
        let bytes = fs::read(path).unwrap();
        let file = ::gltf::Gltf::from_slice(&bytes).unwrap_or_else(|e| panic!("{e}"));
        let blob = file.blob.clone().unwrap_or_else(|| {
            let json: Value = serde_json::from_slice(&bytes).unwrap();
            let uri = json["buffers"][0]["uri"].as_str().unwrap_or(",").to_owned();
            use base64::Engine as _;
            base64::engine::general_purpose::STANDARD
                .decode(uri.split(',').nth(1).unwrap())
                .unwrap()
        });
        (file.document, blob)
    };
    let mut local: Vec<Pose> = document
        .nodes()
        .map(|n| {
            let (t, r, _) = n.transform().decomposed();
            Pose::new(t, r)
        })
        .collect();
    if let Some(animation) = document.animations().next() {
        for channel in animation.channels() {
            let reader = channel.reader(|_| Some(&buffers));
            let times: Vec<f32> = reader.read_inputs().unwrap().collect();
            let after = times.iter().position(|t| *t >= time).unwrap_or(times.len() - 1);
            let before = if times[after] > time { after.saturating_sub(1) } else { after };
            let span = times[after] - times[before];
            let part = if span > 0.0 { (time - times[before]) / span } else { 0.0 };
            let pose = &mut local[channel.target().node().index()];
            use ::gltf::animation::util::ReadOutputs;
            match reader.read_outputs().unwrap() {
                ReadOutputs::Translations(keys) => {
                    let keys: Vec<Vec3> = keys.map(Vec3::from).collect();
                    pose.position = keys[before] + (keys[after] - keys[before]) * part;
                }
                ReadOutputs::Rotations(keys) => {
                    let keys: Vec<Quat> = keys.into_f32().map(Quat::from).collect();
                    let turn = keys[after] * keys[before].conjugate();
                    pose.rotation = keys[before].turned_by(turn.to_rotation_vector() * part);
                }
                _ => {}
            }
        }
    }
    let mut world = local.clone();
    let mut stack: Vec<_> = document.default_scene().unwrap().nodes().collect();
    while let Some(node) = stack.pop() {
        for child in node.children() {
            let scale = node.transform().decomposed().2[0];
            let mut inner = local[child.index()];
            inner.position *= scale;
            world[child.index()] = world[node.index()].compose(&inner);
            stack.push(child);
        }
    }
    (world, document)
}

fn assert_poses(path: &Path, nodes: &[usize], motion: &Motion) {
    for (f, &time) in motion.times.iter().enumerate() {
        let (world, _) = sampled(path, time);
        for (b, &node) in nodes.iter().enumerate() {
            let (is, should) = (world[node], motion.poses[b][f]);
            assert!(
                (is.position - should.position).length() < 3e-4,
                "body {b} at {time}: {is:?} {should:?}"
            );
            assert!(
                (is.rotation * should.rotation.conjugate()).angle() < 5e-4,
                "body {b} at {time}"
            );
        }
    }
}

/// Bodies that fly and spin, each in its own way, from where they are.
fn flight(scene: &Scene, frames: u16) -> Motion {
    let times: Vec<f32> = (0..frames).map(|f| f32::from(f) / 60.0).collect();
    let pose = |b: usize, def: &BodyDef, t: f32| {
        if def.kind == BodyKind::Static {
            return Pose::new(def.position, def.rotation);
        }
        let k = f32::from(u8::try_from(b).unwrap()) + 1.0;
        let position = def.position + vec3(k * t, 3.0 * t - 4.9 * t * t, 0.2 * t);
        Pose::new(
            position,
            Quat::from_rotation_vector(vec3(k * t, 2.0 * t, 5.0 * t * t)) * def.rotation,
        )
    };
    let poses = scene.bodies.iter().enumerate();
    let poses = poses.map(|(b, s)| times.iter().map(|&t| pose(b, &s.def, t)).collect()).collect();
    Motion { times, poses, ..Motion::default() }
}

#[test]
fn a_baked_file_plays_the_same_poses() {
    for name in
        ["motion_kinematic.gltf", "rest_convexhull_on_meshfloor.gltf", "compound_and_scale.gltf"]
    {
        let loaded = load(name);
        let motion = flight(&loaded.scene, 90);
        for extension in ["glb", "gltf"] {
            let path = scratch("bake").join(name).with_extension(extension);
            bake::write(&path, &loaded, &motion).unwrap();
            assert_poses(&path, &loaded.node_of_body, &motion);
            // Physics is still there.
            let again = gltf::load(&path, &Options::default()).unwrap();
            assert_eq!(again.scene.bodies.len(), loaded.scene.bodies.len());
            let (_, document) = sampled(&path, 0.0);
            let moving =
                loaded.scene.bodies.iter().filter(|b| b.def.kind != BodyKind::Static).count();
            let channels = document.animations().next().unwrap().channels().count();
            assert_eq!(channels, 2 * moving, "no channel for what stands still");
        }
    }
}

#[test]
fn bodies_below_moving_and_scaled_nodes_are_where_they_should_be() {
    let part = || with(json!({"motion": {}, "collider": {"geometry": {"shape": 0}}}));
    let nodes = json!([
        {"name": "car", "translation": [1, 2, 3], "rotation": [0, 0.6, 0, 0.8], "children": [1], "extensions": part()},
        {"scale": [2, 2, 2], "translation": [0, 1, 0], "children": [2]},
        {"name": "wheel", "translation": [1, 0, 0], "extensions": part()},
        {"scale": [1, 3, 1], "children": [4]},
        {"name": "askew", "translation": [0, 1, 0], "extensions": part()},
    ]);
    let mut value = physics(json!([{"type": "box"}]), nodes);
    value["scenes"] = json!([{"nodes": [0, 3]}]);
    value["scene"] = json!(0);
    let loaded = read(&value, &Options::default()).unwrap();
    assert_eq!(loaded.node_of_body, [0, 2, 4]);
    let motion = flight(&loaded.scene, 60);
    let path = scratch("bake").join("nested.glb");
    bake::write(&path, &loaded, &motion).unwrap();
    assert_poses(&path, &loaded.node_of_body, &motion);
}

#[test]
fn straight_motion_needs_two_keys_and_rest_none() {
    let loaded = load("motion_kinematic.gltf");
    let mut motion = flight(&loaded.scene, 101);
    for (b, poses) in motion.poses.iter_mut().enumerate() {
        for (t, p) in motion.times.iter().zip(poses) {
            *p = Pose::at([if b == 1 { *t } else { 0.0 }, 0.0, 0.0]);
        }
    }
    let path = scratch("bake").join("straight.glb");
    bake::write(&path, &loaded, &motion).unwrap();
    let (_, document) = sampled(&path, 0.0);
    let animation = document.animations().next().unwrap();
    let channels: Vec<_> = animation.channels().collect();
    assert_eq!(channels.len(), 1);
    assert_eq!(channels[0].sampler().input().count(), 2);
}

#[test]
fn static_and_dynamic_friction_are_both_kept() {
    let collider = |material: usize| {
        with(json!({"collider": {"geometry": {"shape": 0}, "physicsMaterial": material}}))
    };
    let nodes = json!([{"extensions": collider(0)}, {"extensions": collider(1)}, {"extensions": collider(2)}]);
    let mut file = physics(json!([{"type": "sphere", "sphere": {"radius": 1}}]), nodes);
    file["extensions"]["KHR_physics_rigid_bodies"] = json!({"physicsMaterials": [
        {"staticFriction": 0.6, "dynamicFriction": 0.25},
        {"staticFriction": 0.25, "dynamicFriction": 0.5},
        {"staticFriction": 0.5, "dynamicFriction": 0.5},
    ]});
    let l = read(&file, &Options::default()).unwrap();
    let of = |i: usize| {
        let m = l.scene.bodies[i].def.shapes[0].material;
        (m.friction, m.kinetic_friction)
    };
    assert_eq!([of(0), of(1), of(2)], [(0.6, Some(0.25)), (0.25, None), (0.5, None)]);
    // Dynamic friction above static friction is said to be left out.
    assert_eq!(l.scene.notes.len(), 1, "{:?}", l.scene.notes);
}

#[test]
fn a_built_scene_written_and_read_is_the_same_scene() {
    let hull = Hull::from_points(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]).unwrap();
    let slippery = Material { kinetic_friction: Some(0.25), ..Material::default() };
    let shapes = [
        ShapeDef::sphere(0.5).with_material(slippery),
        ShapeDef::box_full([1.0, 2.0, 3.0]),
        ShapeDef::capsule(0.5, 0.25),
        ShapeDef::cylinder(0.5, 0.3),
        ShapeDef::cone(0.5, 0.3),
        ShapeDef::new(Shape::Hull(std::sync::Arc::new(hull))),
    ];
    let mut scene = Scene::new("all", "each kind of shape");
    scene.config.gravity = vec3(0.0, -1.62, 0.0);
    let slope = vec3(0.6, 0.8, 0.0);
    scene.add("ground", BodyDef::fixed().with_shape(ShapeDef::half_space(slope, -2.0)));
    for (i, shape) in shapes.iter().enumerate() {
        let x = 3.0 * f32::from(u8::try_from(i).unwrap());
        let turn = Quat::from_axis_angle([1.0, 2.0, 3.0], 0.5);
        let def = BodyDef::dynamic().with_position([x, 3.0, 0.0]).with_rotation(turn);
        scene.add(
            shape.shape.kind(),
            def.with_shape(shape.clone().with_friction(0.3)).with_mass(2.0),
        );
    }
    let pair = BodyDef::dynamic()
        .with_shape(shapes[0].clone().with_position([1.0, 0.0, 0.0]))
        .with_shape(shapes[1].clone().with_position([-1.0, 0.0, 0.0]).with_density(500.0))
        .with_linear_velocity([1.0, 2.0, 3.0]);
    scene.add("pair", pair);
    let motion = flight(&scene, 30);
    for extension in ["glb", "gltf"] {
        let path = scratch("bake").join("all").with_extension(extension);
        bake::write_scene(&path, &scene, &[], &motion).unwrap();
        let back = gltf::load(&path, &Options::default()).unwrap();
        assert!((back.scene.config.gravity.y + 1.62).abs() < 1e-6);
        assert_poses(&path, &back.node_of_body, &motion);
        assert_eq!(back.scene.bodies.len(), scene.bodies.len());
        for (is, should) in back.scene.bodies.iter().zip(&scene.bodies) {
            assert_eq!(is.name, should.name);
            assert_eq!(is.def.kind, should.def.kind);
            assert!((is.def.position - should.def.position).length() < 1e-5);
            assert!((is.def.linear_velocity - should.def.linear_velocity).length() < 1e-5);
            for (a, b) in is.def.shapes.iter().zip(&should.def.shapes) {
                assert_eq!(a.shape.kind(), b.shape.kind());
                assert!((a.material.friction - b.material.friction).abs() < 1e-6);
                assert_eq!(a.material.kinetic_friction, b.material.kinetic_friction);
            }
        }
        let ground = &back.scene.bodies[0].def.shapes[0];
        assert!((ground.pose.direction(Vec3::Y) - slope).length() < 1e-5);
    }
}

#[test]
fn an_obj_file_gives_a_body_for_each_object() {
    let folder = scratch("obj");
    let mut text = String::new();
    let cube = |text: &mut String, name: &str, y: f32, h: f32| {
        text.push_str(&format!("o {name}\n"));
        for i in 0..8_u8 {
            let s = |b: u8| if i >> b & 1 == 1 { h } else { -h };
            text.push_str(&format!("v {} {} {}\n", s(0), y + s(1), s(2)));
        }
        for f in [
            "-8 -6 -5 -7",
            "-4 -3 -1 -2",
            "-8 -7 -3 -4",
            "-6 -2 -1 -5",
            "-8 -4 -2 -6",
            "-7 -5 -1 -3",
        ] {
            text.push_str(&format!("f {f}\n"));
        }
    };
    cube(&mut text, "floor", -5.0, 4.0);
    cube(&mut text, "crate", 2.0, 0.5);
    let path = folder.join("two.obj");
    fs::write(&path, text).unwrap();
    let options = |how| Options { auto_colliders: Some(how), ..Options::default() };
    let l = drystone_scene::obj::load(&path, &options(AutoColliders::Hull)).unwrap();
    let words: Vec<_> = l
        .scene
        .bodies
        .iter()
        .map(|b| (b.name.as_str(), b.def.kind, b.def.shapes[0].shape.kind()))
        .collect();
    assert_eq!(words, [("floor", BodyKind::Static, "mesh"), ("crate", BodyKind::Dynamic, "hull")]);
    let e = drystone_scene::obj::load(&path, &Options::default()).unwrap_err().to_string();
    assert!(e.contains("--auto-colliders") && !e.contains("KHR"), "{e}");
    let motion = flight(&l.scene, 20);
    let out = folder.join("two.glb");
    bake::write(&out, &l, &motion).unwrap();
    assert_poses(&out, &l.node_of_body, &motion);
}

#[test]
fn triangle_soups_on_moving_bodies_never_panic() {
    let mut state = 3;
    let folder = scratch("soup");
    let path = folder.join("soup.obj");
    for round in 0..8 {
        let mut number =
            |wide: usize| f32::from(u8::try_from(next(&mut state) % wide).unwrap()) / 8.0;
        // Few different coordinates: plenty of flat, equal and zero-area triangles; sizes from mm to km.
        let wide = [3, 9, 64][round % 3];
        let size = [1e-3, 1.0, 1e3, 1e6][round % 4];
        let mut text = String::new();
        for _ in 0..30 {
            let v = vec3(number(wide), number(wide), number(wide)) * size;
            text.push_str(&format!("v {} {} {}\n", v.x, v.y, v.z));
        }
        for _ in 0..4 + 5 * round {
            let mut corner = || 1 + next(&mut state) % 30;
            text.push_str(&format!("f {} {} {}\n", corner(), corner(), corner()));
        }
        fs::write(&path, text).unwrap();
        let options = Options { auto_colliders: Some(AutoColliders::Mesh), ..Options::default() };
        if let Ok(l) = drystone_scene::obj::load(&path, &options) {
            assert!(l.scene.bodies.iter().all(|b| b.def.validate().is_ok()));
        }
    }
}

#[test]
fn a_file_without_meshes_shows_its_colliders() {
    let loaded = load("compound_and_scale.gltf");
    let motion = flight(&loaded.scene, 10);
    let path = scratch("bake").join("shown.glb");
    bake::write(&path, &loaded, &motion).unwrap();
    let (world, document) = sampled(&path, 0.0);
    // Floor and two boxes; the third one is switched off.
    let shown: Vec<_> =
        document.nodes().filter(|n| n.mesh().is_some()).map(|n| n.index()).collect();
    assert_eq!(shown.len(), 3);
    for (node, x) in shown.iter().zip([0.0, -1.0, 1.0]) {
        assert!((world[*node].position.x - x).abs() < 1e-5);
    }
    assert_eq!(gltf::load(&path, &Options::default()).unwrap().scene.bodies.len(), 2);
}
