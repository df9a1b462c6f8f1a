//! One-way surfaces.

use drystone::events::Senses;
use drystone::{BodyDef, BodyId, Pose, Quat, ShapeDef, Vec3, World, WorldConfig, vec3};

use crate::floors::square;

const G: f32 = 9.81;

/// A world with a platform whose top is at y = 0 and whose front faces up.
fn platform(kind: &str, scale: f32) -> (World, BodyId) {
    let gravity = vec3(0.0, -G, 0.0) * scale;
    let mut world = World::new(WorldConfig { gravity, ..WorldConfig::default() }).unwrap();
    let below = vec3(0.0, -0.1, 0.0) * scale;
    let shape = match kind {
        "mesh" => square(2.0 * scale),
        _ => ShapeDef::box_half(vec3(2.0, 0.1, 2.0) * scale).with_position(below),
    };
    let shape = shape.with_one_way(Vec3::Y * 3.0);
    let body = match kind {
        "kinematic" => BodyDef::kinematic(),
        _ => BodyDef::fixed(),
    };
    let id = world.add_body(body.with_shape(shape)).unwrap();
    (world, id)
}

fn shapes(scale: f32) -> [(&'static str, ShapeDef, f32); 3] {
    [
        ("ball", ShapeDef::sphere(0.2 * scale), 0.2),
        ("capsule", ShapeDef::capsule(0.3 * scale, 0.2 * scale), 0.5),
        ("box", ShapeDef::box_half(Vec3::splat(0.2 * scale)), 0.2),
    ]
}

#[test]
fn what_jumps_through_from_below_lands_on_top() {
    for (kind, scale, rate) in ["box", "mesh", "kinematic"]
        .into_iter()
        .flat_map(|k| [0.1, 1.0, 100.0].map(|s| (k, s)))
        .flat_map(|(k, s)| [30.0_f32, 60.0, 120.0].map(|r| (k, s, r)))
    {
        for (name, shape, half) in shapes(scale) {
            // Up to 1 m above the top, then back.
            let (mut world, _) = platform(kind, scale);
            let start = -half - 0.5;
            let rise = half + 1.0 - start;
            let speed = (2.0 * G * rise).sqrt();
            let body = BodyDef::dynamic()
                .with_position(vec3(0.0, start, 0.0) * scale)
                .with_linear_velocity(vec3(0.0, speed, 0.0) * scale)
                .with_shape(shape);
            let id = world.add_body(body).unwrap();
            let what = format!("{name} through {kind}, x{scale}, {rate} Hz");
            let (mut top, mut begins) = (f32::MIN, 0);
            let mut time = 0.0;
            while time < 4.0 {
                world.step(1.0 / rate);
                time += 1.0 / rate;
                top = top.max(world.body(id).unwrap().position().y / scale);
                begins += world.events().contact_begin.len();
            }
            // Free flight in steps of 1/8 of the rate, with an error of at most v h / 2.
            let off = (top - half - 1.0).abs();
            assert!(off < speed / rate / 8.0, "{what}: it rose to {top} m");
            let at = world.body(id).unwrap().position().y / scale;
            assert!((at - half).abs() < 0.01, "{what}: it ends at {at} m");
            assert_eq!(begins, 1, "{what}");
        }
    }
}

#[test]
fn what_turns_back_inside_falls_out_below() {
    for kind in ["box", "kinematic"] {
        for (name, shape, half) in shapes(1.0) {
            let (mut world, _) = platform(kind, 1.0);
            // Its middle reaches the middle of the plate.
            let start = -half - 0.5;
            let speed = (2.0 * G * (-0.1 - start)).sqrt();
            let body = BodyDef::dynamic()
                .with_position([0.0, start, 0.0])
                .with_linear_velocity([0.0, speed, 0.0])
                .with_shape(shape);
            let id = world.add_body(body).unwrap();
            for _ in 0..120 {
                world.step(1.0 / 60.0);
                assert!(world.events().contact_begin.is_empty(), "{name}, {kind}");
            }
            assert!(world.body(id).unwrap().position().y < -5.0, "{name}, {kind}");
        }
    }
}

#[test]
fn what_falls_fast_is_held_and_what_comes_fast_from_below_is_not() {
    for kind in ["box", "mesh", "kinematic"] {
        for (name, shape, half) in shapes(0.1) {
            for speed in [-60.0_f32, -20.0, 20.0, 60.0] {
                let (mut world, _) = platform(kind, 1.0);
                let start = -speed.signum() * 1.03;
                let body = BodyDef::dynamic()
                    .with_position([0.1, start, 0.2])
                    .with_linear_velocity([0.0, speed, 0.0])
                    .with_shape(shape.clone());
                let id = world.add_body(body).unwrap();
                for _ in 0..30 {
                    world.step(1.0 / 60.0);
                }
                let y = world.body(id).unwrap().position().y;
                let what = format!("{name} at {speed} m/s on {kind}: y {y}");
                if speed < 0.0 {
                    assert!(y > 0.0 && y < half + 0.3, "{what}");
                } else {
                    // Free flight, in steps of 1/8 of the rate.
                    let free = start + 0.5 * speed - 0.125 * G;
                    assert!((y - free).abs() < 0.5 * G / 60.0 / 8.0, "{what}, {free}");
                }
            }
        }
    }
}

#[test]
fn it_can_change_and_lives_in_snapshots() {
    let (mut world, id) = platform("box", 1.0);
    let shape = world.body(id).unwrap().shapes().next().unwrap();
    assert_eq!(world.shape(shape).unwrap().one_way(), Some(Vec3::Y));
    let ball = BodyDef::dynamic().with_position([0.0, 0.2, 0.0]).with_shape(ShapeDef::sphere(0.2));
    let ball = world.add_body(ball).unwrap();
    for _ in 0..120 {
        world.step(1.0 / 60.0);
    }
    let mut again = World::restore(&world.snapshot()).unwrap();
    for world in [&mut world, &mut again] {
        // The front faces down: it falls through.
        world.shape_mut(shape).unwrap().set_one_way(Some(-Vec3::Y)).unwrap();
        for _ in 0..120 {
            world.step(1.0 / 60.0);
        }
    }
    assert!(world.body(ball).unwrap().position().y < -2.0);
    assert_eq!(world.state_hash(), again.state_hash());
    for bad in [Vec3::ZERO, vec3(f32::NAN, 0.0, 0.0)] {
        let error = world.shape_mut(shape).unwrap().set_one_way(Some(bad)).unwrap_err();
        assert!(error.to_string().contains("one_way"), "{error}");
        let def = ShapeDef::sphere(1.0).with_one_way(bad);
        assert!(def.validate().is_err());
    }
    assert_eq!(world.shape(shape).unwrap().one_way(), Some(-Vec3::Y));
    world.shape_mut(shape).unwrap().set_one_way(None).unwrap();
    assert!(World::restore(&world.snapshot()).is_ok());
    world.remove_shape(shape);
    assert!(World::restore(&world.snapshot()).is_ok());
}

fn enters(first: ShapeDef, second: ShapeDef) -> [usize; 2] {
    let mut world = World::default();
    let a = world.add_body(BodyDef::fixed().with_shape(first)).unwrap();
    let mut counts = [0; 2];
    for _ in 0..3 {
        world.step(1.0 / 60.0);
    }
    world.add_body(BodyDef::fixed().with_position([0.5, 0.0, 0.0]).with_shape(second)).unwrap();
    for step in 0..6 {
        if step == 3 {
            world.body_mut(a).unwrap().set_pose(Pose::at([9.0, 0.0, 0.0]));
        }
        world.step(1.0 / 60.0);
        counts[0] += world.events().sensor_enter.len();
        counts[1] += world.events().sensor_exit.len();
    }
    counts
}

#[test]
fn sensors_see_static_shapes_and_each_other_if_they_are_to() {
    let ball = || ShapeDef::sphere(1.0);
    let sensor = |senses: Senses| ball().as_sensor().with_senses(senses);
    let none = Senses::default();
    let statics = Senses { statics: true, sensors: false };
    let both = Senses { statics: true, sensors: true };
    assert_eq!(enters(sensor(none), ball()), [0, 0]);
    assert_eq!(enters(sensor(statics), ball()), [1, 1]);
    assert_eq!(enters(ball(), sensor(statics)), [1, 1]);
    assert_eq!(enters(sensor(statics), sensor(none)), [0, 0]);
    assert_eq!(enters(sensor(both), sensor(none)), [1, 1]);
    assert_eq!(enters(sensor(both), sensor(both)), [2, 2], "each sees the other");
    // A moving visitor is reported by static sensors, without a request for static shapes.
    let mut world = World::default();
    let sensors = Senses { statics: false, sensors: true };
    let gate = BodyDef::fixed().with_shape(sensor(none));
    world.add_body(gate).unwrap();
    let probe = BodyDef::kinematic().with_position([-5.0, 0.0, 0.0]);
    let probe = probe.with_linear_velocity([5.0, 0.0, 0.0]).with_shape(sensor(sensors));
    world.add_body(probe).unwrap();
    let mut counts = [0; 2];
    for _ in 0..120 {
        world.step(1.0 / 60.0);
        counts[0] += world.events().sensor_enter.len();
        counts[1] += world.events().sensor_exit.len();
    }
    assert_eq!(counts, [1, 1]);
}

#[test]
fn the_list_of_what_moved_is_what_moved() {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space(Vec3::Y, 0.0))).unwrap();
    let ids: Vec<BodyId> = (0..6_u8)
        .map(|i| {
            let at = vec3(2.0 * f32::from(i), 0.5 + 0.3 * f32::from(i), 0.0);
            let body = BodyDef::dynamic().with_position(at);
            world.add_body(body.with_shape(ShapeDef::sphere(0.5))).unwrap()
        })
        .collect();
    let turned = BodyDef::kinematic().with_position([0.0, 9.0, 0.0]);
    let turned = BodyDef { rotation: Quat::IDENTITY, ..turned };
    world.add_body(turned.with_shape(ShapeDef::sphere(0.5))).unwrap();
    let mut quiet = 0;
    for _ in 0..300 {
        let before: Vec<Pose> = world.bodies().map(|b| b.pose()).collect();
        world.step(1.0 / 60.0);
        let moved: Vec<BodyId> = world.moved_bodies().map(|b| b.id()).collect();
        for (body, before) in world.bodies().zip(before) {
            let is_listed = moved.contains(&body.id());
            assert!(is_listed || body.pose() == before, "{:?}", body.id());
            quiet += usize::from(!is_listed && ids.contains(&body.id()));
        }
        let mut once = moved.clone();
        once.sort_unstable();
        once.dedup();
        assert_eq!(once.len(), moved.len());
    }
    assert!(quiet > 300, "what sleeps is not listed: {quiet}");
}
