//! Tumbling bodies on joints: a body that rotates far in a step is solved in rounds, with its
//! current inertia in each.

use std::sync::Arc;

use drystone::joint::Ball;
use drystone::threads::{SimdLevel, Team};
use drystone::{BodyDef, Filter, JointDef, ShapeDef, Vec3, World, vec3};

use super::scenario_whirl::weightless;

const DT: f32 = 1.0 / 60.0;

/// Three bricks on ball joints at their corners, in empty space. The outer ones rotate at half and
/// at one and a half `speed` [rad/s], the middle one at `speed`, about an axis that is not a
/// principal one. They do not collide.
fn add_chain(world: &mut World, middle: Vec3, speed: f32) {
    let half = vec3(0.1, 0.05, 0.02);
    let bricks = [-1.0_f32, 0.0, 1.0].map(|at| {
        let mut shape = ShapeDef::box_half(half);
        shape.filter = Filter::layers(1, 2);
        let mut brick = BodyDef::dynamic()
            .with_position(middle + half * (2.0 * at))
            .with_shape(shape)
            .with_mass(1.0);
        brick.angular_velocity = vec3(0.6, 0.0, 0.8) * (speed * (1.0 + 0.5 * at));
        world.add_body(brick).unwrap()
    });
    for [a, b] in [[0, 1], [1, 2]] {
        world
            .add_joint(
                JointDef::new(bricks[a], bricks[b], Ball::new()).with_anchors(half, half * -1.0),
            )
            .unwrap();
    }
}

fn chain(parts: u16, speed: f32) -> World {
    let mut world = weightless(parts);
    add_chain(&mut world, Vec3::ZERO, speed);
    world
}

/// Relative changes of energy and angular momentum in ten seconds.
fn drift(mut world: World) -> [f64; 2] {
    // The joints first remove velocities that violate them.
    world.step(DT);
    let start = world.audit();
    let (energy, spin) = (start.energy.total(), start.momentum.about_center);
    let mut most = [0.0_f64; 2];
    for _ in 0..600 {
        world.step(DT);
        let now = world.audit();
        let turned = (now.momentum.about_center - spin).length() / spin.length();
        most[0] = most[0].max((now.energy.total() / energy - 1.0).abs());
        most[1] = most[1].max(f64::from(turned));
    }
    most
}

/// Rows with the inertia of one moment have a first-order error in the time they are kept: a round,
/// an eighth of a step. The remaining error is first-order too. The paths diverge, so the test
/// requires only half of that gain.
#[test]
fn a_chain_that_tumbles_keeps_energy_and_spin() {
    for speed in [20.0, 30.0, 40.0] {
        let (rounds, whole) = (drift(chain(4, speed)), drift(chain(1, speed)));
        for (rounds, whole) in rounds.into_iter().zip(whole) {
            assert!(rounds < whole / 4.0, "{speed} rad/s: {rounds} in rounds, {whole} without");
        }
    }
}

#[test]
fn a_chain_that_hardly_turns_keeps_its_bits() {
    let end = |parts| {
        let mut world = chain(parts, 4.0);
        (0..120).for_each(|_| world.step(DT));
        world.state_hash()
    };
    assert_eq!(end(1), end(4));
}

/// Some of them tumble, some only rotate fast, some rotate slowly.
#[test]
fn chains_have_the_same_bits_whoever_takes_them() {
    let end = |threads, level| {
        let mut world = weightless(4);
        for i in 0..24_u8 {
            let i = f32::from(i);
            add_chain(&mut world, vec3(2.0 * i, 0.0, 0.0), 1.5 * i);
        }
        world.set_executor(Arc::new(Team::with_threads(threads)));
        world.set_simd_level(level);
        (0..120).for_each(|_| world.step(DT));
        world.state_hash()
    };
    let expected = end(1, SimdLevel::best());
    for threads in [2, 5] {
        assert_eq!(end(threads, SimdLevel::best()), expected, "{threads} threads");
    }
    for level in SimdLevel::available() {
        assert_eq!(end(1, level), expected, "{level:?}");
    }
}
