//! Characters, and hooks of contacts.

use bevy_drystone::{
    ActiveCollisionHooks, CharacterMover, CharacterSettings, Collider, LinearVelocity,
    PhysicsWorld, RigidBody, SpatialQueryFilter,
};
use bevy_ecs::prelude::{Component, Entity, Query, Res};
use bevy_math::Vec3;
use bevy_time::Time;
use bevy_transform::components::Transform;
use drystone::contact::{ContactHooks, HookedContact};
use drystone::query::BodyKinds;
use std::sync::Arc;

use crate::game::{Game, near};

/// Walks by this velocity [m/s], and falls.
#[derive(Component)]
struct Hero {
    walk: Vec3,
    fall: f32,
}

fn walk(
    mover: CharacterMover<'_, '_>,
    mut heroes: Query<'_, '_, (Entity, &mut Transform, &Collider, &mut Hero)>,
    time: Res<'_, Time>,
) {
    let dt = time.delta_secs();
    for (entity, mut place, collider, mut hero) in &mut heroes {
        let filter = SpatialQueryFilter::from_excluded_entities([entity])
            .with_kinds(BodyKinds::STATIC | BodyKinds::KINEMATIC);
        let delta = (hero.walk + Vec3::Y * hero.fall) * dt;
        let (at, turn) = (place.translation, place.rotation);
        let settings = CharacterSettings::default();
        let moved = mover.move_by(collider, at, turn, delta, &settings, &filter).expect("numbers");
        hero.fall = if moved.is_grounded { 0.0 } else { hero.fall - 9.81 * dt };
        place.translation = moved.position + moved.ground_velocity * dt;
    }
}

fn hero(game: &mut Game, at: Vec3, walk: Vec3) -> Entity {
    let body = (RigidBody::Kinematic, Collider::capsule(0.3, 1.0), Transform::from_translation(at));
    game.spawn((body, Hero { walk, fall: 0.0 }))
}

/// Five stairs of 0.3 m, with the middle of the capsule 0.8 m and a skin of 0.01 m over the ground.
#[test]
fn a_character_climbs_stairs_and_pushes_crates() {
    let mut game = Game::on_ground();
    game.each_step(walk);
    for k in 0..5_u8 {
        let k = f32::from(k);
        let stair = Transform::from_xyz(4.0 + 0.4 * k, 0.15 + 0.3 * k, 0.0);
        game.spawn((Collider::cuboid(2.0, 0.3, 2.0), stair));
    }
    let climber = hero(&mut game, Vec3::new(0.0, 0.81, 0.0), Vec3::X * 2.0);
    let pusher = hero(&mut game, Vec3::new(0.0, 0.81, 9.0), Vec3::X);
    let load = game.cube([2.0, 0.5, 9.0]);
    game.run(150);
    assert!(near(game.place(climber).y, 2.31, 0.05), "{}", game.place(climber));
    // It walked 2.34 m; its radius and half of the crate are between the middles.
    assert!(near(game.place(load).x - game.place(pusher).x, 0.8, 0.02));
    assert!(game.faults().is_empty());
}

#[test]
fn a_character_rides_a_lift() {
    let mut game = Game::new();
    game.each_step(walk);
    let lift = (RigidBody::Kinematic, Collider::cuboid(2.0, 0.2, 2.0));
    let lift = game.spawn((lift, LinearVelocity(Vec3::new(0.1, 1.0, 0.0))));
    let rider = hero(&mut game, Vec3::Y * 0.91, Vec3::ZERO);
    for speed in [1.0, -1.0] {
        game.change::<LinearVelocity>(lift, |v| v.0.y = speed);
        game.run(64);
        let off = game.place(rider) - game.place(lift);
        assert!((off - Vec3::Y * 0.91).length() < 0.03, "{off}");
    }
}

/// Lets everything fall through.
struct Holes;

impl ContactHooks for Holes {
    fn contact(&self, contact: &mut HookedContact<'_>) {
        contact.drop_contact();
    }
}

#[test]
fn each_world_has_its_own_hooks_for_the_colliders_that_ask() {
    let mut game = Game::on_ground();
    let (ghost, solid) = (game.cube([0.0, 0.5, 0.0]), game.cube([3.0, 0.5, 0.0]));
    game.insert(ghost, ActiveCollisionHooks);
    game.run(16);
    assert!(game.place(ghost).y > 0.4, "no hooks yet");
    let world = game.default_world();
    game.change::<PhysicsWorld>(world, |physics| physics.set_hooks(Some(Arc::new(Holes))));
    game.change::<LinearVelocity>(ghost, |v| v.0 = Vec3::NEG_Y);
    game.run(32);
    assert!(game.place(ghost).y < -1.0 && game.place(solid).y > 0.4);
}
