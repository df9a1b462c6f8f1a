//! Messages and observed events.

use bevy_drystone::{
    Collider, ColliderDisabled, CollidingEntities, CollisionEnd, CollisionHit, CollisionStart,
    HitSpeed, RigidBody, Sensor, SensorEnter, SensorExit,
};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::observer::On;
use bevy_ecs::prelude::{Entity, ResMut, Resource};
use bevy_math::Vec3;
use bevy_transform::components::Transform;

use crate::game::{Game, HERTZ, near};

fn ball(game: &mut Game, at: [f32; 3]) -> Entity {
    let place = Transform::from_translation(Vec3::from_array(at));
    game.spawn((RigidBody::Dynamic, Collider::sphere(0.5), place))
}

/// Frames one by one, so that no message is lost.
fn watch<T: bevy_ecs::message::Message>(game: &mut Game, steps: u64) -> Vec<T> {
    let mut all = Vec::new();
    for _ in 0..steps {
        game.run(1);
        all.extend(game.messages::<T>());
    }
    all
}

/// A ball of 1 m falls by 1 m on the ground: one start, one hit of √(2 g h) and m v.
#[test]
fn a_landing_is_a_start_and_a_hit() {
    let mut game = Game::new();
    let ground = game.spawn(Collider::half_space(Vec3::Y));
    let ball = ball(&mut game, [0.0, 1.5, 0.0]);
    let (mut starts, mut hits) = (Vec::new(), Vec::new());
    for _ in 0..64 {
        game.run(1);
        starts.extend(game.messages::<CollisionStart>());
        hits.extend(game.messages::<CollisionHit>());
    }
    assert_eq!((starts.len(), hits.len()), (1, 1));
    let start = starts[0];
    assert!([start.collider1, start.collider2].contains(&ball));
    assert!([start.body1, start.body2].contains(&ground));
    // The step adds at most g dt to the speed.
    let (speed, step) = ((2.0_f32 * 9.81).sqrt(), 9.81 / HERTZ);
    assert!(near(hits[0].speed, speed, step), "{}", hits[0].speed);
    let mass = game.body(ball).mass();
    assert!(near(hits[0].impulse, mass * speed, mass * 2.0 * step));
    // The point lies between the surfaces as they were at the beginning of the step.
    assert!(near(hits[0].point.y, 0.0, 0.5 * speed / HERTZ), "{:?}", hits[0]);
    assert!(near(hits[0].normal.y.abs(), 1.0, 1e-3));
}

/// Events end however a touch ends: by a despawn, by being disabled, by a change of the collider.
#[test]
fn every_start_has_its_end() {
    let mut game = Game::on_ground();
    let balls: Vec<Entity> =
        [0.0, 3.0, 6.0].into_iter().map(|x| ball(&mut game, [x, 0.5, 0.0])).collect();
    assert_eq!(watch::<CollisionStart>(&mut game, 16).len(), 3);
    game.messages::<CollisionEnd>();
    game.despawn(balls[0]);
    game.insert(balls[1], ColliderDisabled);
    game.change::<Transform>(balls[2], |place| place.translation.y = 9.0);
    let ends = watch::<CollisionEnd>(&mut game, 4);
    let of = |entity: Entity| {
        ends.iter().filter(|e| e.collider1 == entity || e.collider2 == entity).count()
    };
    assert_eq!(balls.iter().map(|ball| of(*ball)).collect::<Vec<_>>(), [1, 1, 1]);
}

/// The flag of a game library that must be there from the start does not exist: an observer that is
/// added late hears of everything after it.
#[derive(Default, Resource)]
struct Heard(Vec<(Entity, Entity)>);

#[test]
fn observers_hear_from_the_side_of_their_entity() {
    let mut game = Game::on_ground();
    game.app.init_resource::<Heard>();
    let ball = ball(&mut game, [0.0, 3.0, 0.0]);
    game.run(8);
    game.app.world_mut().entity_mut(ball).observe(
        |start: On<'_, '_, CollisionStart>, mut heard: ResMut<'_, Heard>| {
            heard.0.push((start.collider1, start.body1));
        },
    );
    game.run(64);
    assert_eq!(game.app.world().resource::<Heard>().0, [(ball, ball)]);
}

/// A body of two cubes lands with both: one pair of shapes each, but a compound is one collider.
#[test]
fn a_compound_starts_and_ends_once() {
    let mut game = Game::on_ground();
    let cube = || Collider::cuboid(1.0, 1.0, 1.0);
    let apart = [-1.0, 1.0].map(|x| (Vec3::X * x, bevy_math::Quat::IDENTITY, cube()));
    let body = game.spawn((
        RigidBody::Dynamic,
        Collider::compound(apart),
        Transform::from_xyz(0.0, 1.0, 0.0),
    ));
    assert_eq!(watch::<CollisionStart>(&mut game, 32).len(), 1);
    game.messages::<CollisionEnd>();
    game.change::<Transform>(body, |place| place.translation.y = 9.0);
    assert_eq!(watch::<CollisionEnd>(&mut game, 2).len(), 1);
}

#[test]
fn events_name_the_collider_and_the_body() {
    let mut game = Game::on_ground();
    let body = game.spawn((RigidBody::Dynamic, Transform::from_xyz(0.0, 1.0, 0.0)));
    let foot = game.spawn((Collider::sphere(0.5), ChildOf(body), HitSpeed(0.1)));
    let starts = watch::<CollisionStart>(&mut game, 32);
    let sides = [(starts[0].collider1, starts[0].body1), (starts[0].collider2, starts[0].body2)];
    assert!(sides.contains(&(foot, body)));
}

/// A ball falls through a sensor: it enters and leaves.
#[test]
fn sensors_report_visitors() {
    let mut game = Game::new();
    let gate = (Collider::cuboid(4.0, 1.0, 4.0), Sensor, CollidingEntities::default());
    let gate = game.spawn(gate);
    let ball = ball(&mut game, [0.0, 2.0, 0.0]);
    let (mut enters, mut exits, mut listed) = (Vec::new(), Vec::new(), 0);
    for _ in 0..64 {
        game.run(1);
        enters.extend(game.messages::<SensorEnter>());
        exits.extend(game.messages::<SensorExit>());
        listed += usize::from(game.get::<CollidingEntities>(gate).contains(ball));
    }
    assert_eq!((enters.len(), exits.len()), (1, 1));
    assert_eq!((enters[0].sensor, enters[0].visitor), (gate, ball));
    // It overlaps from 1 m to 3 m of its fall: √(2 h / g) from 0.45 s to 0.78 s, 21 steps.
    assert!((20..=22).contains(&listed), "{listed}");
}

#[test]
fn lists_of_touching_colliders_follow_and_can_come_late() {
    let mut game = Game::new();
    let ground = game.spawn((Collider::half_space(Vec3::Y), CollidingEntities::default()));
    let (a, b) = (ball(&mut game, [0.0, 0.5, 0.0]), ball(&mut game, [3.0, 0.5, 0.0]));
    game.run(16);
    let mut both = [a, b];
    both.sort_unstable();
    assert_eq!(game.get::<CollidingEntities>(ground).entities(), both);
    game.insert(a, CollidingEntities::default());
    game.run(1);
    assert_eq!(game.get::<CollidingEntities>(a).entities(), [ground]);
    game.despawn(b);
    game.run(1);
    assert_eq!(game.get::<CollidingEntities>(ground).entities(), [a]);
}
