//! Checks that every engine gets the same bodies: they start in the same state, and fall the same
//! way until they touch something.

#![cfg(any(feature = "rapier", feature = "box3d"))]

use drystone::{Vec3, vec3};
use drystone_bench::{Engine, Own};
use drystone_scene::{Script, named};

/// Scenes whose bodies fly freely at first.
const SCENES: [&str; 3] = ["trees100", "convex_vs_mesh", "rain:rows=1"];

/// Checks the start and a tenth of a second of free motion against drystone.
fn agrees<E: Engine>(spec: &str) {
    let mut scene = named(spec).unwrap();
    let (mut own, mut peer) = (Own::build(&scene, 1).unwrap(), E::build(&scene, 1).unwrap());
    if let Script::Waves(waves) = &scene.script {
        own.bring(&waves[0]).unwrap();
        peer.bring(&waves[0]).unwrap();
        scene.bodies.extend(waves[0].bodies.iter().cloned());
    }
    let name = E::NAME;
    let near = |a: Vec3, b: Vec3, tolerance: f32, what: &str| {
        assert!((b - a).length() <= tolerance, "{spec}, {name}, {what}: {a:?} and {b:?}");
    };
    let compare = |own: &Own, peer: &E, shift: f32, speed: f32, turn: f32| {
        for (number, body) in scene.bodies.iter().enumerate() {
            let (a, b) = (own.state(number), peer.state(number));
            let what = body.name.as_str();
            near(a.pose.position, b.pose.position, shift, what);
            near(a.linear_velocity, b.linear_velocity, speed, what);
            near(a.angular_velocity, b.angular_velocity, turn, what);
            // A point at a distance of 1 m reveals rotations.
            let point = vec3(0.6, 0.48, 0.64);
            near(a.pose.rotation.rotate(point), b.pose.rotation.rotate(point), turn, what);
        }
    };
    // In f32, numbers up to 300 m have steps of 3e-5 m.
    compare(&own, &peer, 5.0e-5, 1.0e-5, 1.0e-5);
    for _ in 0..6 {
        own.step(1.0 / 60.0);
        peer.step(1.0 / 60.0);
    }
    // drystone's free fall is a parabola; steps of h = 1/240 s fall g t h / 2 = 2.1 mm farther.
    // Speeds agree up to rounding and damping (their squares: 1e-5); a gravity of 10 instead of
    // 9.81 would be 19 mm/s.
    compare(&own, &peer, 2.5e-3, 2.0e-3, 2.0e-3);
}

#[cfg(feature = "rapier")]
#[test]
fn rapier_has_the_same_bodies() {
    SCENES.into_iter().for_each(agrees::<crate::rapier::Rapier>);
}

#[cfg(feature = "box3d")]
#[test]
fn box3d_has_the_same_bodies() {
    SCENES.into_iter().for_each(agrees::<crate::box3d::Box3d>);
}
