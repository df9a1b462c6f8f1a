//! Bodies and colliders from components.

use bevy_drystone::{
    AngularVelocity, Collider, ColliderDensity, ColliderDisabled, CollisionLayers, ConstantForce,
    Forces, Friction, Gravity, GravityScale, InWorld, KineticFriction, LinearDamping,
    LinearVelocity, LockedAxes, Mass, PhysicsBody, PhysicsCollider, PhysicsTime, PhysicsWorld,
    Restitution, RigidBody, RigidBodyDisabled, Sleeping, SleepingDisabled, SurfaceVelocity,
};
use bevy_ecs::prelude::{Query, With};
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use drystone::MassDef;

use crate::game::{Game, HERTZ, near};

/// Free fall: after t the speed is g t exactly, and the engine's parabola is exact.
#[test]
fn a_ball_falls_by_its_parabola() {
    let mut game = Game::new();
    let ball = game.spawn((RigidBody::Dynamic, Collider::sphere(0.5)));
    game.run(64);
    // Half g, by 64 roundings of numbers of size 5.
    assert!(near(game.place(ball).y, -4.905, 64.0 * 5.0 * f32::EPSILON));
    assert!(near(game.get::<LinearVelocity>(ball).0.y, -9.81, 64.0 * 10.0 * f32::EPSILON));
}

/// A box on the ground rests on it, and sleeps after a while: the component says so.
#[test]
fn a_box_comes_to_rest_and_sleeps() {
    let mut game = Game::on_ground();
    let cube = game.cube([0.0, 1.0, 0.0]);
    game.run(256);
    assert!(game.app.world().get::<Sleeping>(cube).is_some());
    // The engine's contacts sink in by millimeters at most.
    assert!(near(game.place(cube).y, 0.5, 0.005), "{}", game.place(cube));
    assert_eq!(game.get::<LinearVelocity>(cube).0, Vec3::ZERO);
    assert_eq!(game.get::<AngularVelocity>(cube).0, Vec3::ZERO);
    game.check();
}

#[test]
fn masses_follow_from_colliders_and_components() {
    let mut game = Game::new();
    let cube = game.cube([0.0; 3]);
    game.run(1);
    let mass = |game: &Game| game.body(cube).mass();
    assert!(near(mass(&game), 1000.0, 1e-3));
    game.insert(cube, ColliderDensity(500.0));
    game.run(1);
    assert!(near(mass(&game), 500.0, 1e-3));
    game.insert(cube, Mass(3.0));
    game.run(1);
    assert!(near(mass(&game), 3.0, 1e-5));
    game.remove::<(Mass, ColliderDensity)>(cube);
    game.run(1);
    assert!(near(mass(&game), 1000.0, 1e-3));
    // Without a collider a body keeps moving, with 1 kg.
    game.remove::<Collider>(cube);
    game.run(1);
    assert_eq!(game.body(cube).mass_def(), MassDef::Mass(1.0));
    assert_eq!(game.body(cube).shapes().count(), 0);
    assert!(game.faults().is_empty());
}

#[test]
fn a_kind_can_change_in_any_direction() {
    let mut game = Game::on_ground();
    let cube = game.cube([0.0, 3.0, 0.0]);
    game.run(8);
    game.insert(cube, RigidBody::Static);
    game.run(1);
    let stopped = game.place(cube);
    game.run(32);
    assert_eq!(game.place(cube), stopped);
    game.insert(cube, (RigidBody::Kinematic, LinearVelocity(Vec3::X), AngularVelocity::default()));
    game.run(64);
    assert!(near(game.place(cube).x, stopped.x + 1.0, 64.0 * f32::EPSILON), "1 m/s for 1 s");
    game.insert(cube, (RigidBody::Dynamic, LinearVelocity::default()));
    game.run(256);
    assert!(near(game.place(cube).y, 0.5, 0.005), "it fell on the ground");
    game.check();
}

/// A mesh cannot be dynamic, a half-space not even kinematic. The body lives on without it, and
/// has it again once the kind suits.
#[test]
fn a_shape_that_does_not_suit_its_kind_is_refused_by_name() {
    let mut game = Game::new();
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Z];
    let mesh = Collider::trimesh(&corners, vec![[0, 1, 2]]).expect("a triangle");
    let body = game.spawn((RigidBody::Static, mesh));
    game.run(1);
    assert_eq!(game.body(body).shapes().count(), 1);
    game.insert(body, RigidBody::Dynamic);
    game.run(1);
    assert_eq!(game.body(body).shapes().count(), 0);
    assert!(game.faults()[0].contains("mesh"));
    game.insert(body, RigidBody::Kinematic);
    game.run(1);
    assert_eq!(game.body(body).shapes().count(), 1);
    assert!(game.faults().is_empty());
    let ground = game.spawn((RigidBody::Kinematic, Collider::half_space(Vec3::Y)));
    game.run(1);
    assert!(game.faults()[0].contains("half-space"));
    // Kind and collider change together.
    game.insert(body, (RigidBody::Dynamic, Collider::sphere(0.5)));
    game.insert(ground, RigidBody::Static);
    game.run(1);
    assert!(game.faults().is_empty());
    assert_eq!(game.body(body).shapes().count() + game.body(ground).shapes().count(), 2);
}

#[test]
fn bad_numbers_are_refused_and_named() {
    let mut game = Game::new();
    let bad = game.spawn((RigidBody::Dynamic, Collider::sphere(-1.0)));
    game.run(1);
    assert!(game.faults()[0].contains("radius"));
    game.insert(bad, Collider::sphere(1.0));
    game.change::<LinearVelocity>(bad, |v| v.0.x = f32::NAN);
    game.run(1);
    assert!(game.faults()[0].contains("set_linear_velocity"));
    game.change::<Transform>(bad, |place| place.translation.x = f32::INFINITY);
    game.run(1);
    assert!(game.faults()[0].contains("set_pose"));
    let far = game.spawn((RigidBody::Dynamic, Transform::from_xyz(f32::NAN, 0.0, 0.0)));
    game.run(1);
    assert!(game.faults()[0].contains("position"));
    assert!(game.get::<PhysicsBody>(far).body().is_none());
    game.insert(far, (Transform::IDENTITY, Mass(1.0)));
    game.run(1);
    assert!(game.get::<PhysicsBody>(far).body().is_some());
    assert!(Collider::convex_hull(&[Vec3::ZERO]).is_err());
    assert!(Collider::trimesh(&[], vec![[0, 1, 2]]).is_err());
    game.app.world_mut().resource_mut::<PhysicsTime>().scale = f32::NAN;
    game.app.update();
    assert!(game.faults()[0].contains("step"));
}

#[test]
fn materials_reach_the_engine_and_children_take_those_of_their_body() {
    let mut game = Game::new();
    let body = game.spawn((RigidBody::Dynamic, Collider::sphere(0.5), Friction::new(0.1)));
    let own = (Collider::sphere(0.5), Friction::new(0.7), Transform::from_xyz(2.0, 0.0, 0.0));
    let own = game.app.world_mut().spawn((own, bevy_ecs::hierarchy::ChildOf(body))).id();
    let heir = (Collider::sphere(0.5), Transform::from_xyz(4.0, 0.0, 0.0));
    let heir = game.app.world_mut().spawn((heir, bevy_ecs::hierarchy::ChildOf(body))).id();
    game.run(1);
    let friction = |game: &Game, entity| {
        let shape = game.get::<PhysicsCollider>(entity).shapes()[0];
        game.world().shape(shape).expect("a shape").material().friction.to_bits()
    };
    assert_eq!([body, own, heir].map(|e| friction(&game, e)), [0.1, 0.7, 0.1].map(f32::to_bits));
    game.change::<Friction>(body, |friction| friction.coefficient = 0.2);
    game.remove::<Friction>(own);
    game.insert(heir, (Restitution::new(0.5), KineticFriction(0.05), CollisionLayers::new(2, 4)));
    game.run(1);
    assert_eq!([body, own, heir].map(|e| friction(&game, e)), [0.2_f32.to_bits(); 3]);
    let shape = game.get::<PhysicsCollider>(heir).shapes()[0];
    let shape = game.world().shape(shape).expect("a shape");
    assert_eq!((shape.material().restitution, shape.filter().layers), (0.5, 2));
    assert_eq!(shape.material().kinetic_friction, Some(0.05));
}

/// A belt at 2 m/s carries a box to its own speed.
#[test]
fn a_belt_carries_what_lies_on_it() {
    let mut game = Game::new();
    let belt = SurfaceVelocity { linear: Vec3::X * 2.0, ..SurfaceVelocity::default() };
    game.spawn((Collider::cuboid(100.0, 1.0, 4.0), belt));
    let cube = game.cube([0.0, 1.0, 0.0]);
    game.run(128);
    // Friction 0.6 g reaches 2 m/s within 0.34 s.
    assert!(near(game.get::<LinearVelocity>(cube).0.x, 2.0, 0.01));
}

/// A force of twice the weight lifts with g; an impulse of m v gives v. Both act once.
#[test]
fn forces_and_impulses_act_in_the_next_step() {
    let mut game = Game::new();
    let cube = game.cube([0.0; 3]);
    game.run(1);
    let before = game.get::<LinearVelocity>(cube).0;
    game.ask(move |mut bodies: Query<'_, '_, Forces, With<RigidBody>>| {
        for mut body in &mut bodies {
            body.apply_force(Vec3::Y * 2.0 * 9.81 * 1000.0);
            body.apply_linear_impulse(Vec3::X * 1000.0);
        }
    });
    game.run(1);
    let change = game.get::<LinearVelocity>(cube).0 - before;
    assert!((change - Vec3::new(1.0, 9.81 / HERTZ, 0.0)).length() < 1e-4, "{change}");
    game.run(1);
    let next = game.get::<LinearVelocity>(cube).0 - before - change;
    assert!((next - Vec3::new(0.0, -9.81 / HERTZ, 0.0)).length() < 1e-4, "{next}");
}

/// A force of 2 g lifts a box that sleeps on the ground.
#[test]
fn forces_wake_what_sleeps() {
    let mut game = Game::on_ground();
    let cube = game.cube([0.0, 0.5, 0.0]);
    game.run(256);
    assert!(game.body(cube).is_asleep());
    game.each_step(|mut bodies: Query<'_, '_, Forces>| {
        for mut body in &mut bodies {
            body.apply_force(Vec3::Y * 2.0 * 9.81 * 1000.0);
        }
    });
    game.run(64);
    // g upward for 1 s.
    assert!(near(game.place(cube).y, 0.5 + 4.905, 0.1), "{}", game.place(cube));
    assert!(game.app.world().get::<Sleeping>(cube).is_none());
}

#[test]
fn settings_of_a_body_reach_the_engine_and_leave_it_again() {
    let mut game = Game::new();
    let cube = game.cube([0.0; 3]);
    let settings = (GravityScale(0.0), LinearDamping(0.5), LockedAxes::ROTATION_LOCKED);
    game.insert(cube, (settings, ConstantForce(Vec3::X * 1000.0), SleepingDisabled));
    game.run(1);
    let body = game.body(cube);
    assert_eq!((body.gravity_scale(), body.damping(), body.can_sleep()), (0.0, [0.5, 0.0], false));
    assert_eq!(body.locks().angular, [true; 3]);
    game.remove::<LinearDamping>(cube);
    game.change::<LinearVelocity>(cube, |v| v.0 = Vec3::ZERO);
    game.run(64);
    // 1 m/s² for 1 s.
    assert!(near(game.get::<LinearVelocity>(cube).0.x, 1.0, 1e-4));
    game.remove::<(GravityScale, LockedAxes, ConstantForce, SleepingDisabled)>(cube);
    game.run(64);
    let v = game.get::<LinearVelocity>(cube).0;
    assert!(near(v.x, 1.0, 1e-4) && near(v.y, -9.81, 1e-3), "{v}");
    assert!(game.body(cube).can_sleep());
}

#[test]
fn disabled_bodies_and_colliders_are_out_of_the_world() {
    let mut game = Game::on_ground();
    let cube = game.cube([0.0, 0.5, 0.0]);
    game.run(1);
    game.insert(cube, RigidBodyDisabled);
    game.run(64);
    assert_eq!(game.place(cube), Vec3::new(0.0, 0.5, 0.0));
    game.remove::<RigidBodyDisabled>(cube);
    game.insert(cube, ColliderDisabled);
    game.run(64);
    assert!(game.place(cube).y < -3.0, "it falls through the ground");
}

#[test]
fn sleep_follows_the_component() {
    let mut game = Game::new();
    let cube = game.cube([0.0; 3]);
    game.run(1);
    game.insert(cube, Sleeping);
    game.run(64);
    assert!(game.body(cube).is_asleep() && game.place(cube).y > -0.1);
    game.remove::<Sleeping>(cube);
    game.run(64);
    assert!(game.place(cube).y < -4.0);
    game.insert(cube, Sleeping);
    game.run(1);
    // A velocity wakes it, and the component follows.
    game.change::<LinearVelocity>(cube, |v| v.0.x = 1.0);
    game.run(1);
    assert!(game.app.world().get::<Sleeping>(cube).is_none());
}

#[test]
fn worlds_are_apart_and_bodies_can_change_between_them() {
    let mut game = Game::on_ground();
    let moon = game.spawn(PhysicsWorld::default());
    game.change::<PhysicsWorld>(moon, |moon| moon.world_mut().set_gravity([0.0, -1.62, 0.0]));
    let here = game.cube([0.0, 5.0, 0.0]);
    let there = game.cube([0.0, 5.0, 0.0]);
    game.insert(there, InWorld(moon));
    game.run(64);
    assert!(near(game.place(there).y, 5.0 - 0.81, 1e-4), "half of 1.62 m/s²");
    assert!(near(game.place(here).y, 5.0 - 4.905, 0.5), "{}", game.place(here).y);
    game.insert(here, InWorld(moon));
    game.run(1);
    game.check();
    assert_eq!(game.world().counts().dynamic, 0);
    // Without their world, bodies wait.
    game.despawn(moon);
    game.run(1);
    assert!(game.get::<PhysicsBody>(here).body().is_none());
    assert!(!game.faults().is_empty());
    game.remove::<InWorld>(here);
    game.run(1);
    game.check();
    assert_eq!(game.world().counts().dynamic, 1);
    // The default world comes back if it is lost; its bodies go on from where they are.
    let default = game.default_world();
    game.despawn(default);
    game.app.update();
    game.run(1);
    game.check();
    assert_eq!(game.world().counts().dynamic, 1);
}

#[test]
fn gravity_is_a_resource_and_time_can_pause() {
    let mut game = Game::new();
    game.app.insert_resource(Gravity(Vec3::X));
    let cube = game.cube([0.0; 3]);
    game.run(64);
    assert!(near(game.get::<LinearVelocity>(cube).0.x, 1.0, 1e-4));
    game.app.world_mut().resource_mut::<PhysicsTime>().paused = true;
    let place = game.place(cube);
    game.app.update();
    game.app.update();
    assert_eq!(game.place(cube), place);
    game.app.world_mut().resource_mut::<PhysicsTime>().paused = false;
    *game.app.world_mut().resource_mut::<Gravity>() = Gravity::ZERO;
    game.run(64);
    assert!(near(game.get::<LinearVelocity>(cube).0.x, 1.0, 1e-4));
}
