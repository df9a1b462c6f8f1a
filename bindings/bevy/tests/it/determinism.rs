//! The same bits for any number of threads and any order of spawns, and after a rollback.

use bevy_drystone::{
    AngularVelocity, Collider, DrystonePlugin, Friction, LinearVelocity, PhysicsOrder,
    PhysicsWorld, Restitution, RigidBody,
};
use bevy_ecs::prelude::{Component, Entity, Query, With};
use bevy_math::Vec3;
use bevy_transform::components::Transform;

use crate::game::Game;

/// Components of a game, which put bodies into different archetypes.
#[derive(Component)]
struct Red;
#[derive(Component)]
struct Blue(#[expect(dead_code, reason = "it is there for its size")] u64);

const BODIES: u64 = 160;

/// A heap of boxes and balls that fall into each other, the bodies spawned in the order of `order`.
fn heap(threads: usize, order: impl Iterator<Item = u64>) -> Game {
    let plugin = DrystonePlugin::default().with_threads(threads).without_interpolation();
    let mut game = Game::with(plugin);
    game.spawn((Collider::half_space(Vec3::Y), PhysicsOrder(0)));
    for k in order {
        #[expect(clippy::cast_precision_loss, reason = "small whole numbers")]
        let [x, y, z] = [k % 4, k / 16, k / 4 % 4].map(|n| n as f32);
        let place = Transform::from_xyz(1.1 * x + 0.07 * y, 1.0 + 1.3 * y, 1.1 * z - 0.03 * y);
        let body = (RigidBody::Dynamic, PhysicsOrder(k + 1), place);
        let entity = if k % 3 == 0 {
            game.spawn((body, Collider::sphere(0.5), Red))
        } else {
            game.spawn((body, Collider::cuboid(0.9, 0.9, 0.9)))
        };
        if k % 5 == 0 {
            game.insert(entity, (Blue(k), Friction::new(0.3)));
        }
        if k % 7 == 0 {
            game.insert(entity, Restitution::new(0.5));
        }
    }
    game
}

fn mixed() -> impl Iterator<Item = u64> {
    // 63 is coprime to the number of bodies.
    (0..BODIES).map(|k| k * 63 % BODIES)
}

#[test]
fn threads_and_spawn_orders_do_not_change_a_bit() {
    let hash = |mut game: Game| {
        game.run(120);
        game.world().state_hash()
    };
    let first = hash(heap(1, 0..BODIES));
    for threads in [2, 4] {
        assert_eq!(hash(heap(threads, 0..BODIES)), first, "{threads} threads");
    }
    assert_eq!(hash(heap(1, (0..BODIES).rev())), first, "spawned backward");
    assert_eq!(hash(heap(2, mixed())), first, "spawned in a mixed order");
}

/// Changes of many bodies in one frame reach the engine in its own order, not that of queries.
#[test]
fn changes_of_many_bodies_do_not_depend_on_archetypes() {
    let run = |mut game: Game| {
        game.run(30);
        game.ask(|mut all: Query<'_, '_, (&mut LinearVelocity, &mut Transform, &PhysicsOrder)>| {
            for (mut velocity, mut place, order) in &mut all {
                if order.0 % 4 == 1 {
                    velocity.0.y += 3.0;
                }
                if order.0 % 6 == 1 {
                    place.translation.x += 0.25;
                }
            }
        });
        let gone: Vec<Entity> = game.ask(|all: Query<'_, '_, (Entity, &PhysicsOrder)>| {
            all.iter()
                .filter(|(_, order)| order.0 % 9 == 2)
                .map(|(entity, _)| entity)
                .collect::<Vec<_>>()
        });
        gone.into_iter().for_each(|entity| game.despawn(entity));
        game.run(10);
        // Bodies become static, lose their bodies or their colliders, and get them back.
        let all: Vec<(Entity, u64)> = game.ask(|all: Query<'_, '_, (Entity, &PhysicsOrder)>| {
            all.iter().map(|(entity, order)| (entity, order.0)).collect::<Vec<_>>()
        });
        for (entity, order) in &all {
            match order % 10 {
                4 => game.remove::<RigidBody>(*entity),
                5 => game.remove::<Collider>(*entity),
                6 => game.remove::<(RigidBody, Collider)>(*entity),
                7 => game.insert(*entity, RigidBody::Kinematic),
                _ => {}
            }
        }
        game.run(10);
        for (entity, order) in &all {
            match order % 10 {
                4 | 7 => game.insert(*entity, RigidBody::Dynamic),
                5 => game.insert(*entity, Collider::sphere(0.4)),
                6 => game.insert(*entity, (RigidBody::Dynamic, Collider::sphere(0.4))),
                _ => {}
            }
        }
        game.run(60);
        game.world().state_hash()
    };
    assert_eq!(run(heap(1, 0..BODIES)), run(heap(1, mixed())));
}

/// A world and the components of a moment are put back: the second run has the bits of the first,
/// and nothing wakes or counts as a teleport.
#[test]
fn a_rollback_repeats_the_same_bits() {
    type State = (Entity, Transform, LinearVelocity, AngularVelocity);
    let mut game = heap(1, 0..BODIES);
    game.run(60);
    let saved = game.world().clone();
    let states: Vec<State> = game.ask(
        |all: Query<
            '_,
            '_,
            (Entity, &Transform, &LinearVelocity, &AngularVelocity),
            With<RigidBody>,
        >| { all.iter().map(|(e, t, v, w)| (e, *t, *v, *w)).collect::<Vec<_>>() },
    );
    game.run(30);
    let hash = game.world().state_hash();
    let world = game.default_world();
    game.change::<PhysicsWorld>(world, |physics| physics.restore(&saved));
    for (entity, place, linear, angular) in states {
        game.insert(entity, (place, linear, angular));
    }
    game.run(30);
    assert_eq!(game.world().state_hash(), hash);
}

/// A body was added after the moment, another despawned: both follow the entities.
#[test]
fn a_rollback_over_spawns_and_despawns_leaves_nothing_behind() {
    let mut game = heap(1, 0..20);
    game.run(10);
    let saved = game.world().clone();
    let lost = game.cube([50.0, 0.0, 0.0]);
    let gone: Vec<Entity> =
        game.ask(|all: Query<'_, '_, Entity, With<RigidBody>>| all.iter().collect::<Vec<_>>());
    game.run(5);
    game.despawn(gone[0]);
    game.run(5);
    let world = game.default_world();
    game.change::<PhysicsWorld>(world, |physics| physics.restore(&saved));
    game.run(1);
    game.check();
    assert_eq!(game.world().counts().dynamic, 20);
    assert!((game.body(lost).position() - drystone::vec3(50.0, 0.0, 0.0)).length() < 1.0);
}
