//! A body at rest sleeps as soon as rest is detectable.

use drystone::audit::AwakeCause;
#[cfg(feature = "snapshot")]
use drystone::{BodyDef, ShapeDef};
use drystone::{Vec3, World, WorldConfig, vec3};

use super::{
    LOOK, RATES, SCALES, SLEEP, all_sleep, at, cause, cube, ground, pulled, run, sleeps,
    until_sleep,
};
use crate::floors::Floor;

#[test]
fn drift_without_forces_is_rest_by_size() {
    // A hundredth of the extent, which is √3 half sides, in ten seconds.
    for size in SCALES {
        let limit = 1.0e-3 * 3.0_f32.sqrt() * 0.5 * size;
        for (part, rests) in [(0.9_f32, true), (1.1, false)] {
            let speed = (part * limit).min(0.045);
            let mut world = pulled(Vec3::ZERO);
            let body = cube(&mut world, Vec3::ZERO, size);
            world.body_mut(body).unwrap().set_linear_velocity([speed, 0.0, 0.0]);
            run(&mut world, 60.0, 2.0);
            assert_eq!(sleeps(&world, body), rests || speed < part * limit, "{size}, {speed}");
        }
    }
    // The world's speed threshold also applies.
    let mut config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
    config.sleep.speed = 0.01;
    let mut world = World::new(config).unwrap();
    let body = cube(&mut world, Vec3::ZERO, 100.0);
    world.body_mut(body).unwrap().set_linear_velocity([0.02, 0.0, 0.0]);
    run(&mut world, 60.0, 2.0);
    assert_eq!(
        cause(&world, body),
        AwakeCause::TooFast { speed: 0.02, limit: 0.01, driven_by: None }
    );
}

#[test]
fn what_rests_sleeps_as_soon_as_it_can_be_told() {
    for size in SCALES {
        for rate in RATES {
            for floor in [Floor::Box, Floor::Mesh] {
                let mut world = World::default();
                ground(&mut world, floor, size);
                for i in 0..5_u8 {
                    cube(&mut world, vec3(0.0, f32::from(i) + 0.5, 0.0) * size, size);
                }
                // They first settle by a fraction of a millimeter. If that is much for their size,
                // contacts recover it, in a fifth of a second for the weight of five. Within two
                // such times it is a hundredth of half their thickness.
                let settles = if size < 0.1 { 0.4 } else { 0.0 };
                let slept = until_sleep(&mut world, rate, 2.0);
                let soon = slept.is_some_and(|t| t < SLEEP + 2.0 * LOOK + settles);
                assert!(soon, "{slept:?}: {size}, {rate} Hz, {floor:?}");
            }
        }
    }
}

#[test]
fn sleep_without_a_time_needs_three_steps_and_spares_what_falls() {
    let mut config = WorldConfig::default();
    config.sleep.time = 0.0;
    let mut world = World::new(config).unwrap();
    ground(&mut world, Floor::Box, 1.0);
    let rests = cube(&mut world, vec3(0.0, 0.5, 0.0), 1.0);
    let falls = cube(&mut world, vec3(5.0, 5.0, 0.0), 1.0);
    run(&mut world, 60.0, 0.5);
    assert!(sleeps(&world, rests) && !sleeps(&world, falls));
    assert!(at(&world, falls).y < 4.0);
    run(&mut world, 60.0, 3.0);
    assert!(all_sleep(&world));
}

#[cfg(feature = "snapshot")]
#[test]
fn a_world_restored_while_bodies_are_watched_goes_on_with_the_same_bits() {
    let mut world = World::default();
    ground(&mut world, Floor::Box, 1.0);
    for i in 0..8_u8 {
        let x = f32::from(i) * 1.5;
        cube(&mut world, vec3(x, 0.5 + 0.05 * f32::from(i), 0.0), 1.0);
        let ball =
            BodyDef::dynamic().with_position([x, 3.0, 5.0]).with_shape(ShapeDef::sphere(0.3));
        world.add_body(ball).unwrap();
    }
    for step in 0..180 {
        if step % 7 == 0 {
            let mut twin = World::restore(&world.snapshot()).unwrap();
            let mut other = world.clone();
            for _ in 0..40 {
                other.step(1.0 / 60.0);
                twin.step(1.0 / 60.0);
                assert_eq!(other.state_hash(), twin.state_hash(), "step {step}");
                let awake = |w: &World| w.bodies().filter(|b| b.is_asleep()).count();
                assert_eq!(awake(&other), awake(&twin), "step {step}");
            }
        }
        world.step(1.0 / 60.0);
    }
}
