//! Scenes written as glTF with physics: what the format can say reads back, and what it cannot say
//! is named.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests say what they found")]

use std::path::PathBuf;

use drystone::contact::Combine;
use drystone::joint::{
    Ball, ConeTwist, Distance, Fixed, Hinge, JointAxis, JointSpring, Pulley, SixDof, Slider,
};
use drystone::{Axis, BodyDef, BodyKind, Filter, JointKind, Material, ShapeDef, Vec3};
use drystone_scene::bake;
use drystone_scene::{Scene, SceneJoint, catalog, gltf, named};

fn file(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("drystone-gltf-save-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn read_back(scene: &Scene, name: &str) -> Scene {
    let path = file(name);
    bake::save_scene(&path, scene).unwrap();
    let read = gltf::load(&path, &gltf::Options::default());
    let read = read.unwrap_or_else(|e| panic!("{name}: {e}")).scene;
    std::fs::remove_file(path).unwrap();
    read
}

/// A floor, a box that falls onto it, and another body with one joint between both.
fn jointed(kind: impl Into<JointKind>) -> Scene {
    let mut scene = Scene::new("jointed", "");
    scene.add("floor", BodyDef::fixed().with_shape(ShapeDef::box_half([5.0, 0.5, 5.0])));
    for (name, x) in [("a", 0.0), ("b", 1.5)] {
        let shape = ShapeDef::box_half([0.25, 0.5, 0.125]);
        scene.add(name, BodyDef::dynamic().with_position([x, 1.0, 0.0]).with_shape(shape));
    }
    let (a, b) = ((1, Vec3::from([0.75, 0.25, 0.0])), (2, Vec3::from([-0.75, 0.25, 0.0])));
    scene.joints.push(SceneJoint { name: "j".to_owned(), ..SceneJoint::new(a, b, kind) });
    scene
}

fn hashes(scene: &Scene, steps: usize) -> Vec<u64> {
    let mut running = scene.build().unwrap();
    let mut all = vec![running.world.state_hash()];
    for _ in 0..steps {
        running.step(1.0 / 60.0).unwrap();
        all.push(running.world.state_hash());
    }
    all
}

#[test]
fn joints_read_back_as_they_were_written_and_move_with_the_same_bits() {
    let soft = JointSpring::new(800.0, 20.0);
    let kinds: [JointKind; 8] = [
        Ball::new().into(),
        Hinge::new().with_limits(-0.5, 1.25).into(),
        Hinge::new().with_servo(0.7, JointSpring::hertz(4.0, 1.0), 60.0).into(),
        Slider::new().with_soft_limits(-0.25, 0.5, soft).into(),
        Slider::new().with_servo(0.125, soft, f32::INFINITY).into(),
        Fixed::soft(JointSpring::hertz(10.0, 0.3)).into(),
        ConeTwist::new(0.75, 0.75).with_twist(-0.5, 0.5).into(),
        Distance::between(0.25, 1.5).into(),
    ];
    for kind in kinds {
        let scene = jointed(kind);
        assert_eq!(bake::unsaid(&scene), [], "{kind:?}");
        let read = read_back(&scene, "joint.glb");
        let (was, is) = (&scene.joints[0], &read.joints[0]);
        assert_eq!((was.kind, was.body_a, was.body_b), (is.kind, is.body_a, is.body_b));
        assert_eq!((was.anchor_a, was.anchor_b), (is.anchor_a, is.anchor_b), "{kind:?}");
        assert_eq!(was.collide_connected, is.collide_connected);
        assert_eq!(hashes(&scene, 60), hashes(&read, 60), "{kind:?}");
    }
}

/// A motor's damping is infinite, and a file has no number for that: it is written as one that
/// takes all of the motor's force.
#[test]
fn a_motor_reads_back_as_a_drive_that_holds_its_speed_as_well() {
    let scene = jointed(Hinge::new().with_motor(2.0, 50.0));
    assert_eq!(bake::unsaid(&scene), []);
    let read = read_back(&scene, "motor.gltf");
    let speed = |scene: &Scene| {
        let mut running = scene.build().unwrap();
        (0..60).for_each(|_| running.step(1.0 / 60.0).unwrap());
        let joint = running.world.joint(running.joints[0]).unwrap();
        joint.axis(Axis::TurnX).unwrap().speed()
    };
    let (was, is) = (speed(&scene), speed(&read));
    // The same law within rounding of its softness.
    assert!((was - is).abs() < 1.0e-3, "{was} {is}");
}

#[test]
fn surfaces_filters_sensors_and_compounds_read_back() {
    let mut scene = Scene::new("surfaces", "");
    let material = Material {
        friction: 0.5,
        kinetic_friction: Some(0.25),
        restitution: 0.125,
        friction_combine: Combine::GeometricMean,
        restitution_combine: Combine::GeometricMean,
        ..Material::default()
    };
    let floor = ShapeDef::box_half([5.0, 0.5, 5.0]).with_material(material);
    scene.add("floor", BodyDef::fixed().with_shape(floor));
    let ghost = Filter { layers: 4, exclude: 1, ..Filter::default() };
    let body = BodyDef::dynamic()
        .with_position([0.0, 2.0, 0.0])
        .with_mass(3.0)
        .with_shape(ShapeDef::sphere(0.5).with_material(material))
        .with_shape(
            ShapeDef::capsule(0.25, 0.125).with_position([0.0, 0.5, 0.0]).with_filter(ghost),
        )
        .with_shape(ShapeDef::cylinder(0.5, 0.25).with_position([0.5, 0.0, 0.0]).as_sensor());
    scene.add("ball", body);
    let kinematic = BodyDef { gravity_scale: 0.5, ..BodyDef::dynamic() };
    scene.add(
        "light",
        kinematic.with_position([3.0, 2.0, 0.0]).with_shape(ShapeDef::cone(0.5, 0.5)),
    );
    assert_eq!(
        bake::unsaid(&scene).len(),
        1,
        "the mean of two frictions: {:?}",
        bake::unsaid(&scene)
    );
    let read = read_back(&scene, "surfaces.gltf");
    for (was, is) in scene.bodies.iter().zip(&read.bodies) {
        assert_eq!(was.name, is.name);
        assert_eq!((was.def.kind, was.def.mass), (is.def.kind, is.def.mass), "{}", was.name);
        for (a, b) in was.def.shapes.iter().zip(&is.def.shapes) {
            assert_eq!((a.shape.kind(), a.pose, a.sensor), (b.shape.kind(), b.pose, b.sensor));
            if !a.sensor {
                assert_eq!(a.material, b.material, "{}", was.name);
            }
            let other = |of: &Scene| of.bodies[0].def.shapes[0].filter;
            let meet = |f: Filter, with: Filter| f.collides_with(with);
            assert_eq!(meet(a.filter, other(&scene)), meet(b.filter, other(&read)));
        }
    }
    assert_eq!(hashes(&scene, 90), hashes(&read, 90));
}

/// Scenes of the catalog of which glTF can say all: they fall as they fell.
#[test]
fn scenes_of_which_all_is_said_move_with_the_same_bits() {
    let (mut same, mut candidates) = (Vec::new(), 0);
    for entry in catalog() {
        if ["large_world", "dust", "hail", "large_mesh"].contains(&entry.name) {
            continue;
        }
        let scene = entry.scene(None).unwrap();
        let unsaid = bake::unsaid(&scene);
        let is_exact = scene.bodies.iter().all(|b| {
            let plain = b.def.shapes.iter().all(|s| s.density.to_bits() == 1000.0_f32.to_bits());
            // Velocities are given in the frame of the node.
            let turns = b.def.rotation != drystone::Quat::IDENTITY;
            let still = b.def.linear_velocity == Vec3::ZERO && b.def.angular_velocity == Vec3::ZERO;
            (plain || b.def.kind != BodyKind::Dynamic) && (still || !turns)
        });
        if !unsaid.is_empty() || !is_exact || scene.bodies.len() > 700 || !scene.joints.is_empty() {
            continue;
        }
        let read = read_back(&scene, "catalog.glb");
        assert_eq!(scene.bodies.len(), read.bodies.len(), "{}", entry.name);
        assert_eq!((scene.hz, scene.seconds), (read.hz, read.seconds), "{}", entry.name);
        candidates += 1;
        if hashes(&scene, 30) == hashes(&read, 30) {
            same.push(entry.name);
        }
    }
    assert_eq!(same.len(), candidates, "{same:?}");
    for name in ["pyramid", "wall", "jenga", "arch"] {
        assert!(same.contains(&name), "{name} is not among {same:?}");
    }
}

#[test]
fn what_gltf_cannot_say_is_named_with_its_count() {
    let mut scene = jointed(JointKind::SixDof(
        SixDof::FIXED.with_axis(Axis::TurnX, JointAxis::FREE.with_friction(2.0)),
    ));
    let rope = Pulley::rope([[0.0, 4.0, 0.0], [1.0, 4.0, 0.0]], 6.0);
    scene.joints.push(SceneJoint::new((1, Vec3::ZERO), (2, Vec3::ZERO), rope));
    scene.bodies[1].def.linear_damping = 0.1;
    scene.bodies[2].def.angular_damping = 0.1;
    scene.never_collide.push([1, 2]);
    scene.config.sleep.enabled = false;
    let found: Vec<(String, usize)> =
        bake::unsaid(&scene).into_iter().map(|u| (u.what, u.count)).collect();
    let expected = [
        ("a pair of bodies that never collide", 1),
        ("a pulley", 1),
        ("damping of a body", 2),
        ("dry friction of a joint", 1),
        ("settings of the world beside gravity", 1),
    ];
    assert_eq!(found, expected.map(|(what, count)| (what.to_owned(), count)));
    // The rest is there.
    let read = read_back(&scene, "rest.glb");
    assert_eq!((read.bodies.len(), read.joints.len()), (3, 1));
    assert!(!bake::unsaid(&named("rope").unwrap()).is_empty());
}

/// Files of others, read, written and read again: the same bodies, shapes and joints, on the same
/// way. Inertia goes through its principal axes, so bits may differ by rounding, 1e-7 of each
/// number. In half a second contacts let that grow by no more than a thousand times.
#[test]
fn files_of_others_read_back_to_the_same_bodies_shapes_and_joints() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf-khr-own");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let Ok(loaded) = gltf::load(&entry.path(), &gltf::Options::default()) else { continue };
        let scene = loaded.scene;
        let read = read_back(&scene, "again.glb");
        let name = &scene.name;
        let moving = |scene: &Scene| -> Vec<(String, BodyKind, Vec<&'static str>)> {
            let bodies = scene.bodies.iter().filter(|b| b.def.kind != BodyKind::Static);
            let shapes = |def: &BodyDef| def.shapes.iter().map(|s| s.shape.kind()).collect();
            bodies.map(|b| (b.name.clone(), b.def.kind, shapes(&b.def))).collect()
        };
        assert_eq!(moving(&scene), moving(&read), "{name}");
        assert_eq!(scene.joints.len(), read.joints.len(), "{name}");
        let ways = |scene: &Scene| -> Vec<Vec3> {
            let mut running = scene.build().unwrap();
            (0..30).for_each(|_| running.step(1.0 / 60.0).unwrap());
            let bodies = running.world.bodies().filter(|b| b.kind() != BodyKind::Static);
            bodies.map(|b| b.position()).collect()
        };
        for (a, b) in ways(&scene).iter().zip(&ways(&read)) {
            assert!((*a - *b).length() < 1.0e-4, "{name}: {a:?} {b:?}");
        }
        seen += 1;
    }
    assert!(seen >= 18, "{seen} files");
}
