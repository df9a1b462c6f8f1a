//! Joints as entities.

use bevy_drystone::{
    Collider, DistanceJoint, FixedJoint, GravityScale, JointBroke, JointCollisionEnabled,
    JointDisabled, JointMotor, JointStrength, PhysicsJoint, PrismaticJoint, RevoluteJoint,
    RigidBody, RopeJoint, SphericalJoint,
};
use bevy_ecs::prelude::Entity;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

use crate::game::{Game, near};

/// A fixed frame and a cube of 1 m beside it.
fn pair(game: &mut Game) -> (Entity, Entity) {
    let frame = game.spawn((RigidBody::Static, Transform::IDENTITY));
    (frame, game.cube([1.0, 0.0, 0.0]))
}

fn joint(game: &Game, entity: Entity) -> drystone::JointRef<'_> {
    let id = game.get::<PhysicsJoint>(entity).joint().expect("a joint");
    game.world().joint(id).expect("in the world")
}

/// A motor of 0.5 rad/s turns a door by 0.5 rad in a second.
#[test]
fn a_door_turns_with_its_motor() {
    let mut game = Game::new();
    let (wall, door) = pair(&mut game);
    let motor = JointMotor::Speed { target: 0.5, max_force: 1.0e5 };
    let hinge = RevoluteJoint::new(wall, door).at(Vec3::ZERO).with_axis(Vec3::Y).with_motor(motor);
    let hinge = game.spawn(hinge);
    game.run(64);
    let angle = joint(&game, hinge).angle().expect("a hinge");
    assert!(near(angle, 0.5, 0.01), "{angle}");
    // Limits and a motor backward, changed in place.
    game.change::<RevoluteJoint>(hinge, |hinge| {
        hinge.motor = Some(JointMotor::Speed { target: -1.0, max_force: 1.0e5 });
        *hinge = hinge.with_angle_limits(-0.25, 1.0);
    });
    let before = game.get::<PhysicsJoint>(hinge).joint();
    game.run(64);
    assert_eq!(game.get::<PhysicsJoint>(hinge).joint(), before);
    let angle = joint(&game, hinge).angle().expect("a hinge");
    assert!(near(angle, -0.25, 0.01), "{angle}");
}

#[test]
fn each_kind_holds_what_it_says() {
    let mut game = Game::new();
    let (frame, a) = pair(&mut game);
    let anchor = Vec3::ZERO;
    let fixed = game.spawn(FixedJoint::new(frame, a).at(anchor));
    let b = game.cube([0.0, 0.0, 3.0]);
    game.spawn(
        PrismaticJoint::new(frame, b).at(Vec3::Z * 3.0).with_axis(Vec3::Y).with_limits(-0.5, 0.5),
    );
    let c = game.cube([0.0, -2.0, 6.0]);
    game.spawn(RopeJoint::new(frame, c, 2.0).between(Vec3::Z * 6.0, Vec3::new(0.0, -2.0, 6.0)));
    let d = game.cube([3.0, 0.0, 9.0]);
    game.spawn(DistanceJoint::new(frame, d, 3.0).between(Vec3::Z * 9.0, Vec3::new(3.0, 0.0, 9.0)));
    let e = game.cube([0.0, -1.0, 12.0]);
    game.spawn(SphericalJoint::new(frame, e).at(Vec3::Z * 12.0).with_swing_limit(0.1));
    game.run(128);
    assert!((game.place(a) - Vec3::X).length() < 0.01, "held");
    assert!((game.place(b) - Vec3::new(0.0, -0.5, 3.0)).length() < 0.01, "at its stop");
    assert!((game.place(c) - Vec3::new(0.0, -2.0, 6.0)).length() < 0.01, "on its rope");
    assert!(near((game.place(d) - Vec3::Z * 9.0).length(), 3.0, 0.01), "3 m away");
    assert!((game.place(e) - Vec3::new(0.0, -1.0, 12.0)).length() < 0.01, "hangs");
    game.insert(fixed, JointDisabled);
    game.run(64);
    assert!(game.place(a).y < -4.0, "it fell");
    assert!(game.faults().is_empty());
}

/// A joint of 1000 N under a cube of 1000 kg breaks at once, and says so once.
#[test]
fn a_weak_joint_breaks_and_can_be_mended() {
    let mut game = Game::new();
    let (frame, cube) = pair(&mut game);
    let weak = JointStrength { force: 1000.0, ..JointStrength::default() };
    let made = FixedJoint::new(frame, cube).at(Vec3::X);
    let weld = game.spawn((made, weak));
    let mut broken = Vec::new();
    for _ in 0..8 {
        game.run(1);
        broken.extend(game.messages::<JointBroke>());
    }
    assert_eq!(broken.len(), 1);
    assert_eq!((broken[0].joint, broken[0].body1, broken[0].body2), (weld, frame, cube));
    assert!(broken[0].force > 1000.0);
    assert!(game.get::<PhysicsJoint>(weld).is_broken());
    game.change::<JointStrength>(weld, |strength| strength.force = f32::INFINITY);
    game.run(1);
    assert_eq!(game.world().counts().joints, 0, "a broken joint stays broken");
    game.change::<bevy_drystone::LinearVelocity>(cube, |v| v.0 = Vec3::ZERO);
    game.insert(weld, made);
    game.run(64);
    assert_eq!(game.world().counts().joints, 1);
}

/// An end that goes takes the joint along; an end that comes back brings it back, at its old place
/// on the bodies.
#[test]
fn joints_come_and_go_with_their_ends() {
    let mut game = Game::new();
    let (frame, cube) = pair(&mut game);
    let weld = game.spawn(FixedJoint::new(frame, cube).at(Vec3::ZERO));
    game.run(1);
    game.remove::<RigidBody>(frame);
    game.run(1);
    assert_eq!(game.world().counts().joints, 0);
    assert!(game.get::<PhysicsJoint>(weld).joint().is_none());
    game.run(16);
    game.insert(frame, RigidBody::Static);
    game.run(32);
    assert_eq!(game.world().counts().joints, 1);
    assert!(near(game.place(cube).x, 1.0, 0.02) && near(game.place(cube).y, 0.0, 0.02));
    game.despawn(cube);
    game.run(1);
    assert_eq!(game.world().counts().joints, 0);
    let late = game.spawn((RigidBody::Dynamic, Collider::sphere(0.5), GravityScale(0.0)));
    game.insert(weld, FixedJoint::new(frame, late));
    game.run(1);
    assert_eq!(game.world().counts().joints, 1);
    game.despawn(weld);
    game.run(1);
    assert_eq!(game.world().counts().joints, 0);
}

/// Joined bodies overlap freely, unless the joint says otherwise.
#[test]
fn joined_bodies_collide_only_on_demand() {
    let mut game = Game::new();
    let (a, b) = (game.cube([0.0; 3]), game.cube([0.5, 0.0, 0.0]));
    let rope = game.spawn(RopeJoint::new(a, b, 5.0));
    game.run(16);
    assert_eq!(game.world().counts().contacts, 0);
    game.insert(rope, JointCollisionEnabled);
    game.run(2);
    assert_eq!(game.world().counts().contacts, 1);
}

#[test]
fn a_joint_that_cannot_be_is_named() {
    let mut game = Game::new();
    let (frame, cube) = pair(&mut game);
    game.spawn(RopeJoint::new(frame, cube, -1.0));
    game.run(1);
    assert!(game.faults()[0].contains("max"));
    let other = game.spawn((RigidBody::Static, Transform::IDENTITY));
    let weld = game.spawn(FixedJoint::new(frame, other));
    game.run(1);
    assert!(game.faults()[0].contains("dynamic"));
    // It holds once one of them moves.
    game.insert(other, RigidBody::Dynamic);
    game.run(1);
    assert!(game.get::<PhysicsJoint>(weld).joint().is_some());
}
