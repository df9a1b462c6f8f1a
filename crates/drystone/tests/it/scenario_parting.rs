//! Overlaps that no load explains are pushed out, without residual speed.

use drystone::{BodyDef, BodyId, ShapeDef, Vec3, World, WorldConfig};

const DT: f32 = 1.0 / 60.0;

/// Residual speed of a push by velocity: the default of `contact.push_speed` [m/s].
const PUSH: f32 = 0.25;

/// The residual speed after the last push, see parting.rs.
const LEFT: f32 = PUSH / 16.0;

fn weightless() -> World {
    World::new(WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() }).unwrap()
}

fn fastest(world: &World) -> f32 {
    world.bodies().map(|body| body.linear_velocity().length()).fold(0.0, f32::max)
}

/// Twenty boxes in one place separate without flying apart. Each pair may leave with the residual
/// speed, and a body has nineteen pairs.
#[test]
fn what_is_made_in_one_place_does_not_fly_apart() {
    for count in [2_u8, 5, 20] {
        let mut world = weightless();
        for _ in 0..count {
            world.add_body(BodyDef::dynamic().with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
        }
        let mut most = 0.0_f32;
        for _ in 0..300 {
            world.step(DT);
            most = most.max(fastest(&world));
        }
        assert!(most <= PUSH, "{count}: {most} m/s");
        // The remaining overlap is at most the threshold at which parting starts; parting then
        // continues until a sixteenth.
        let deepest_of =
            |least: f32, point: drystone::contact::ContactPoint| least.min(point.separation);
        let deepest = world.contacts().fold(0.0, |d, contact| contact.points().fold(d, deepest_of));
        assert!(deepest > -0.0134, "{count}: {deepest} m");
    }
}

/// A body placed inside a wall is outside after the time that the rates need, up to the residual
/// depth, and stays there. The time is ln(depth / 4 cm) / (6/s) plus 4 cm at the push speed.
#[test]
fn what_is_put_into_a_wall_leaves_it_without_speed() {
    let shapes = [
        ("capsule", ShapeDef::capsule(0.5, 0.3)),
        ("box", ShapeDef::box_half([0.3, 0.8, 0.3])),
        ("sphere", ShapeDef::sphere(0.3)),
    ];
    for (name, shape) in shapes {
        for depth in [0.05_f32, 0.1, 0.2, 0.35, 0.45] {
            for mass in [0.7, 70.0] {
                let mut world = weightless();
                let wall = ShapeDef::box_half([1.0, 2.0, 2.0]);
                world
                    .add_body(BodyDef::fixed().with_position([1.0, 0.0, 0.0]).with_shape(wall))
                    .unwrap();
                let at = [depth - 0.3, 0.0, 0.0];
                let def = BodyDef::dynamic().with_position(at).with_mass(mass);
                let id = world.add_body(def.with_shape(shape.clone().with_friction(0.0))).unwrap();
                let mut most = 0.0_f32;
                let takes = (depth / 0.04).max(1.0).ln() / 6.0 + 0.04 / PUSH;
                let mut t = 0.0;
                while t < takes + 8.0 * DT {
                    world.step(DT);
                    t += DT;
                    most = most.max(fastest(&world));
                }
                let x = world.body(id).unwrap().position().x;
                assert!(most <= LEFT, "{name} {depth} {mass}: {most} m/s");
                assert!(x < -0.3 + 0.004, "{name} {depth} {mass}: {x} m");
            }
        }
    }
}

/// A stack whose lowest box is 0.3 m deep in the ground rises together, and nothing hops. Its
/// support rises at no more than 6/s times its depth, and no box is faster than a push.
#[test]
fn a_stack_that_stands_in_the_ground_comes_up_whole() {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space(Vec3::Y, 0.0))).unwrap();
    let ids: Vec<BodyId> = (0..3_u8)
        .map(|i| {
            let at = [0.0, 0.2 + f32::from(i), 0.0];
            world
                .add_body(
                    BodyDef::dynamic().with_position(at).with_shape(ShapeDef::box_half([0.5; 3])),
                )
                .unwrap()
        })
        .collect();
    let mut most = 0.0_f32;
    for _ in 0..240 {
        world.step(DT);
        most = most.max(world.bodies().map(|body| body.linear_velocity().y).fold(0.0, f32::max));
    }
    assert!(most <= PUSH, "{most} m/s");
    for (i, id) in (0..3_u8).zip(ids) {
        let y = world.body(id).unwrap().position().y;
        assert!((y - 0.5 - f32::from(i)).abs() < 0.005, "{i}: {y} m");
    }
}

/// Parting continues identically after a snapshot, and on any number of threads.
#[test]
fn parting_goes_on_from_a_snapshot() {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space(Vec3::Y, 0.0))).unwrap();
    for i in 0..6_u8 {
        let at = [0.1 * f32::from(i), 0.3, 0.05 * f32::from(i % 3)];
        let shape = ShapeDef::box_half([0.5, 0.4, 0.3]);
        world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap();
    }
    for _ in 0..7 {
        world.step(DT);
    }
    let mut other = World::restore(&world.snapshot()).unwrap();
    for _ in 0..60 {
        world.step(DT);
        other.step(DT);
        assert_eq!(world.state_hash(), other.state_hash());
    }
}

/// A body that is being pushed out is not at rest, although its velocity is zero.
#[test]
fn what_is_being_parted_does_not_sleep() {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space(Vec3::Y, 0.0))).unwrap();
    let at = [0.0, -1.0, 0.0];
    let shape = ShapeDef::box_half([2.0; 3]);
    let id = world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap();
    for _ in 0..300 {
        world.step(DT);
    }
    let y = world.body(id).unwrap().position().y;
    assert!((y - 2.0).abs() < 0.005, "{y} m");
}
