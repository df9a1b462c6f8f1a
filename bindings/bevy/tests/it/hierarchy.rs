//! Parents, children, scale, despawns.

use bevy_drystone::{
    Collider, ColliderDensity, LinearVelocity, PhysicsBody, PhysicsCollider, RigidBody,
};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::Entity;
use bevy_math::{Quat, Vec3};
use bevy_transform::components::Transform;

use crate::game::{Game, near};

fn child(game: &mut Game, of: Entity, at: [f32; 3]) -> Entity {
    let place = Transform::from_translation(Vec3::from_array(at));
    game.spawn((Collider::cuboid(1.0, 1.0, 1.0), place, ChildOf(of)))
}

/// A dumbbell: two cubes 2 m apart on a bare body. Its mass is that of both.
#[test]
fn colliders_of_descendants_are_shapes_of_the_body() {
    let mut game = Game::on_ground();
    let body = game.spawn((RigidBody::Dynamic, Transform::from_xyz(0.0, 3.0, 0.0)));
    let arm = game.spawn((Transform::from_xyz(1.0, 0.0, 0.0), ChildOf(body)));
    let right = child(&mut game, arm, [0.0; 3]);
    let left = child(&mut game, body, [-1.0, 0.0, 0.0]);
    game.run(1);
    assert_eq!(game.world().counts().dynamic, 1);
    assert!(near(game.body(body).mass(), 2000.0, 0.01));
    assert_eq!(game.get::<PhysicsCollider>(right).body(), Some(body));
    assert!(game.get::<PhysicsBody>(right).body().is_none());
    game.run(192);
    assert!(near(game.place(body).y, 0.5, 0.005));
    // An arm that is moved moves its collider.
    game.change::<Transform>(arm, |place| place.translation.x = 4.0);
    game.run(1);
    let x = |game: &Game, entity: Entity| {
        let shape = game.get::<PhysicsCollider>(entity).shapes()[0];
        game.world().shape(shape).expect("a shape").pose().position.x
    };
    assert!(near(x(&game, right), 4.0, 1e-3) && near(x(&game, left), -1.0, 1e-3));
    // A collider that leaves is static; a body that loses it is lighter.
    game.remove::<ChildOf>(left);
    game.run(1);
    assert!(near(game.body(body).mass(), 1000.0, 0.01));
    assert_eq!(game.world().counts().fixed, 2);
    game.check();
}

/// A body under a parent that is turned by a half turn about y and is twice as large: its place in
/// the world is the body's.
#[test]
fn a_body_below_a_parent_is_written_in_the_frame_of_the_parent() {
    let mut game = Game::new();
    let frame = Transform {
        translation: Vec3::new(10.0, 0.0, 0.0),
        rotation: Quat::from_xyzw(0.0, 1.0, 0.0, 0.0),
        scale: Vec3::splat(2.0),
    };
    let parent = game.spawn(frame);
    let ball = (RigidBody::Dynamic, Collider::sphere(0.5), Transform::from_xyz(1.0, 0.0, 0.0));
    let ball = game.spawn((ball, ChildOf(parent)));
    game.run(1);
    assert!(near(game.body(ball).position().x, 8.0, 1e-5));
    // The scale doubles the ball: 4/3 π 1³ at 1000 kg/m³.
    assert!(near(game.body(ball).mass(), 4188.79, 0.1));
    game.run(63);
    assert!(near(game.body(ball).position().y, -4.905, 1e-3));
    assert!(near(game.place(ball).y, -2.4525, 1e-3) && near(game.place(ball).x, 1.0, 1e-5));
    // The parent moves; the body does not, and its transform follows from both.
    game.change::<Transform>(parent, |place| place.translation = Vec3::new(0.0, 100.0, 0.0));
    game.run(1);
    assert!(near(game.body(ball).position().x, 8.0, 1e-4));
    assert!(near(game.place(ball).x, -4.0, 1e-4), "{}", game.place(ball));
}

/// Static and kinematic bodies go with their parents.
#[test]
fn bodies_that_nothing_pushes_follow_their_parents() {
    let mut game = Game::new();
    let ship = game.spawn(Transform::IDENTITY);
    let wall = child(&mut game, ship, [0.0, 0.0, 5.0]);
    let oar = child(&mut game, ship, [2.0, 0.0, 0.0]);
    game.insert(oar, RigidBody::Kinematic);
    game.run(1);
    game.change::<Transform>(ship, |place| place.translation.x = 3.0);
    game.run(1);
    assert_eq!(game.body(wall).position(), drystone::vec3(3.0, 0.0, 5.0));
    assert!(near(game.body(oar).position().x, 5.0, 1e-5));
    assert_eq!(game.place(wall), Vec3::new(0.0, 0.0, 5.0));
    game.run(4);
    assert!(near(game.body(oar).position().x, 5.0, 1e-5), "it stays there");
}

/// A turret on a falling hull: the turret is a body of its own and keeps its own place; a static
/// sail on it goes along.
#[test]
fn bodies_below_moving_bodies_keep_their_own_motion() {
    let mut game = Game::new();
    let hull = game.cube([0.0; 3]);
    game.change::<LinearVelocity>(hull, |v| v.0.x = 1.0);
    let drone = (RigidBody::Dynamic, Collider::sphere(0.2), bevy_drystone::GravityScale(0.0));
    let drone = game.spawn((drone, Transform::from_xyz(0.0, 5.0, 0.0), ChildOf(hull)));
    let sail = game.spawn((RigidBody::Static, Collider::sphere(0.2), ChildOf(hull)));
    game.change::<Transform>(sail, |place| place.translation.y = 3.0);
    game.run(64);
    let sum = game.place(hull) + game.place(drone);
    assert!((sum - Vec3::new(0.0, 5.0, 0.0)).length() < 1e-4, "{sum}");
    // The sail is a step behind.
    let behind = game.body(sail).position().x;
    assert!(near(behind, 1.0 - 1.0 / 64.0, 1e-4), "{behind}");
}

#[test]
fn scales_reach_shapes_and_masses() {
    let mut game = Game::new();
    let cube = game.cube([0.0; 3]);
    let knob = child(&mut game, cube, [1.0, 0.0, 0.0]);
    game.insert(knob, ColliderDensity(0.0));
    game.run(1);
    game.change::<Transform>(cube, |place| place.scale = Vec3::new(1.0, 2.0, 3.0));
    game.run(1);
    assert!(near(game.body(cube).mass(), 6000.0, 0.1));
    game.change::<Transform>(cube, |place| place.scale = Vec3::splat(0.0));
    game.run(1);
    assert!(game.faults().iter().all(|fault| fault.contains("scale")));
    game.change::<Transform>(cube, |place| place.scale = Vec3::ONE);
    game.run(1);
    assert!(near(game.body(cube).mass(), 1000.0, 0.1));
    assert!(game.faults().is_empty());
    game.check();
}

#[test]
fn despawns_and_removals_in_any_order_leave_nothing() {
    let mut game = Game::on_ground();
    let (a, b, c) = (game.cube([0.0; 3]), game.cube([3.0, 0.0, 0.0]), game.cube([6.0, 0.0, 0.0]));
    let on_b = child(&mut game, b, [0.0, 1.0, 0.0]);
    game.run(1);
    game.despawn(a);
    game.remove::<RigidBody>(b);
    game.remove::<(RigidBody, Collider)>(c);
    game.run(1);
    // The ground, b as a static collider, and its child as another one.
    assert_eq!((game.world().counts().fixed, game.world().counts().dynamic), (3, 0));
    game.check();
    game.insert(b, RigidBody::Dynamic);
    game.insert(on_b, RigidBody::Dynamic);
    game.run(1);
    assert_eq!((game.world().counts().fixed, game.world().counts().dynamic), (1, 2));
    game.check();
    game.despawn(b);
    game.run(1);
    assert_eq!((game.world().counts().fixed, game.world().counts().dynamic), (1, 0));
    // Spawned and despawned within a frame; the record taken away by hand.
    let brief = game.cube([0.0; 3]);
    game.despawn(brief);
    let odd = game.cube([0.0; 3]);
    game.run(1);
    game.remove::<PhysicsBody>(odd);
    game.remove::<PhysicsCollider>(odd);
    game.run(1);
    assert_eq!(game.world().counts().dynamic, 0);
    game.check();
}

#[test]
fn a_cloned_entity_has_its_own_body() {
    let mut game = Game::new();
    let cube = game.cube([0.0; 3]);
    game.run(1);
    let twin = game.app.world_mut().entity_mut(cube).clone_and_spawn();
    game.run(1);
    game.check();
    assert_ne!(game.get::<PhysicsBody>(cube).body(), game.get::<PhysicsBody>(twin).body());
}

#[test]
fn a_reparented_body_keeps_its_place_and_a_collider_changes_its_body() {
    let mut game = Game::new();
    let (a, b) = (game.cube([0.0; 3]), game.cube([5.0, 0.0, 0.0]));
    let arm = child(&mut game, a, [0.0, 1.0, 0.0]);
    game.run(1);
    game.insert(arm, ChildOf(b));
    game.run(1);
    assert_eq!(game.get::<PhysicsCollider>(arm).body(), Some(b));
    assert_eq!(game.body(a).shapes().count(), 1);
    let before = game.body(a).position();
    game.insert(a, ChildOf(b));
    game.run(1);
    assert!((game.body(a).position() - before).length() < 0.01, "it falls on, 5 m away");
    assert!(near(game.place(a).x, -5.0, 1e-4));
    game.check();
}
