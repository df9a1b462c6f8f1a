//! Files that are written play what happened.

use drystone::{BodyDef, BodyKind, Hull, Material, Pose, Quat, Shape, ShapeDef, Vec3, vec3};
use drystone_scene::Scene;
use drystone_scene::bake;
use drystone_scene::gltf::{self, Options};
use serde_json::json;

use crate::documents::{load, physics, read, scratch, with};
use crate::motion::{assert_poses, flight, sampled};

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
