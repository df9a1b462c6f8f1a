//! Ropes and cloths.

use bevy_drystone::{
    Cloth, Collider, InWorld, ParticlePositions, PhysicsStrand, PhysicsWorld, RigidBody, Rope,
    RopeEnd,
};
use bevy_math::Vec3;
use bevy_transform::components::Transform;

use crate::game::{Game, near};

/// A lamp of 1 m³ hangs on a rope of 2 m, and stays there.
#[test]
fn a_rope_holds_a_lamp_until_it_goes() {
    let mut game = Game::new();
    let lamp = game.cube([0.0, -2.5, 0.0]);
    let rope = Rope::between(Vec3::ZERO, Vec3::Y * -2.0, 8).with_mass(10.0);
    let rope = game.spawn(rope.with_ends(RopeEnd::Pinned, RopeEnd::Attached(lamp)));
    game.run(192);
    assert!(near(game.place(lamp).y, -2.5, 0.02), "{}", game.place(lamp));
    let points = &game.get::<ParticlePositions>(rope).0;
    assert_eq!(points.len(), 9);
    assert!(near(points[4].y, -1.0, 0.02) && points[0] == Vec3::ZERO);
    game.despawn(rope);
    game.run(64);
    assert!(game.place(lamp).y < -6.0, "it falls");
    assert_eq!(game.world().counts().particles, 0);
}

#[test]
fn a_rope_waits_for_its_body_and_is_made_anew_when_inserted_again() {
    let mut game = Game::new();
    let lamp = game.spawn(Transform::from_xyz(0.0, -1.0, 0.0));
    let made = Rope::between(Vec3::ZERO, Vec3::NEG_Y, 4);
    let made = made.with_ends(RopeEnd::Pinned, RopeEnd::Attached(lamp));
    let rope = game.spawn(made);
    game.run(1);
    assert_eq!(game.world().counts().particles, 0);
    game.insert(lamp, (RigidBody::Dynamic, Collider::sphere(0.1)));
    game.run(1);
    assert_eq!(game.world().counts().particles, 5);
    game.insert(rope, Rope { links: 9, ..made });
    game.run(1);
    assert_eq!(game.get::<PhysicsStrand>(rope).particles().len(), 10);
    assert_eq!(game.world().counts().particles, 10);
    game.insert(rope, Rope { links: 0, ..made });
    game.run(1);
    assert!(game.faults()[0].contains("links"));
    let other = game.spawn(PhysicsWorld::default());
    let there = game.spawn((Rope::between(Vec3::ZERO, Vec3::X, 3), InWorld(other)));
    game.run(1);
    assert_eq!(game.get::<ParticlePositions>(there).0.len(), 4);
    game.remove::<Rope>(there);
    game.despawn(other);
    game.run(1);
    assert_eq!(game.world().counts().particles, 0);
}

/// A cloth held at two corners hangs down from them, and a ball falls into one held at four.
#[test]
fn cloths_hang_from_their_corners() {
    let mut game = Game::new();
    let sides = [Vec3::X * 2.0, Vec3::Z * 2.0];
    let flag = Cloth::new(Vec3::ZERO, sides, [8, 8]).with_pinned([true, true, false, false]);
    let flag = game.spawn(flag);
    let net = Cloth::new(Vec3::new(9.0, 0.0, 0.0), sides, [16, 16]).with_pinned([true; 4]);
    game.spawn(net);
    let ball = Transform::from_xyz(10.0, 0.6, 1.0);
    let ball =
        game.spawn((RigidBody::Dynamic, Collider::sphere(0.3), ball, bevy_drystone::Mass(0.5)));
    game.run(320);
    let points = &game.get::<ParticlePositions>(flag).0;
    assert_eq!(points.len(), 81);
    assert_eq!([points[0], points[8]], [Vec3::ZERO, Vec3::X * 2.0]);
    // Its far side swings about the held one, at its length: threads stretch by 1 % at most, and a
    // fold takes a part of it.
    let far = |p: &Vec3| (p.y * p.y + p.z * p.z).sqrt();
    let is_taut = |p: &Vec3| p.y < 0.0 && far(p) > 1.8 && far(p) < 2.02;
    assert!(points[72..].iter().all(is_taut), "{:?}", &points[72..]);
    assert!(game.place(ball).y > -2.0, "the net holds it: {}", game.place(ball));
}
