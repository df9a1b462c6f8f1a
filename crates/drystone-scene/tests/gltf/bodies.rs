//! Bodies, shapes and masses of what a file says.

use std::fs;

use drystone::contact::Combine;
use drystone::{MassDef, Shape, Vec3, vec3};
use drystone_scene::gltf::{self, LoadedGltf, Options};
use serde_json::{Value, json};

use crate::documents::{data, load, physics, read, samples, with};

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
