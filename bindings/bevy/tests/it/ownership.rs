//! Ownership: writes of the user, and writes of the plugin.

use bevy_drystone::{Collider, DrystonePlugin, LinearVelocity, NoInterpolation, RigidBody};
use bevy_ecs::change_detection::DetectChangesMut;
use bevy_ecs::prelude::{Changed, Entity, Query, ResMut, Resource};
use bevy_math::{Quat, Vec3};
use bevy_time::TimeUpdateStrategy;
use bevy_transform::components::Transform;

use crate::game::{Game, HERTZ, near};

#[test]
fn a_write_to_a_dynamic_body_is_a_teleport_that_keeps_its_velocity() {
    let mut game = Game::new();
    let cube = game.cube([0.0; 3]);
    game.run(64);
    let speed = game.get::<LinearVelocity>(cube).0.y;
    game.change::<Transform>(cube, |place| place.translation = Vec3::new(7.0, 100.0, 0.0));
    game.run(1);
    let fall = (speed - 9.81 / (2.0 * HERTZ)) / HERTZ;
    assert!((game.place(cube) - Vec3::new(7.0, 100.0 + fall, 0.0)).length() < 1e-4);
    assert!(near(game.get::<LinearVelocity>(cube).0.y, speed - 9.81 / HERTZ, 1e-4));
}

/// A change of the smallest number counts: there is no tolerance.
#[test]
fn the_smallest_write_moves_a_body() {
    let mut game = Game::new();
    game.app.insert_resource(bevy_drystone::Gravity::ZERO);
    let cube = game.cube([1.0, 0.0, 0.0]);
    game.run(2);
    let next = f32::from_bits(1.0_f32.to_bits() + 1);
    game.change::<Transform>(cube, |place| place.translation.x = next);
    game.run(1);
    assert_eq!(game.body(cube).position().x.to_bits(), next.to_bits());
}

/// A change tick without a change of bits moves nothing, and wakes nothing.
#[test]
fn a_touched_but_equal_transform_means_nothing() {
    let mut game = Game::on_ground();
    let cube = game.cube([0.0, 0.5, 0.0]);
    game.run(256);
    assert!(game.body(cube).is_asleep());
    game.each_step(|mut all: Query<'_, '_, &mut Transform>| {
        for mut place in &mut all {
            place.set_changed();
        }
    });
    game.run(8);
    assert!(game.body(cube).is_asleep());
}

/// A lift that rises by writes to its transform carries a box: it has a velocity, and is there at
/// the end of the step.
#[test]
fn a_write_to_a_kinematic_body_is_a_target() {
    let mut game = Game::new();
    let lift =
        game.spawn((RigidBody::Kinematic, Collider::cuboid(4.0, 1.0, 4.0), Transform::IDENTITY));
    let cube = game.cube([0.0, 1.0, 0.0]);
    game.run(32);
    for k in 1..=64_u8 {
        let height = f32::from(k) / HERTZ;
        game.change::<Transform>(lift, |place| place.translation.y = height);
        game.run(1);
        assert!(near(game.place(lift).y, height, 4.0 * f32::EPSILON));
    }
    assert!(near(game.get::<LinearVelocity>(cube).0.y, 1.0, 0.05), "carried at 1 m/s");
    assert_eq!(game.get::<LinearVelocity>(lift).0, Vec3::ZERO, "its own velocity is the user's");
    // Without another write it stays.
    game.run(16);
    assert!(near(game.place(lift).y, 1.0, 4.0 * f32::EPSILON));
}

#[test]
fn a_kinematic_body_moves_at_its_velocity() {
    let mut game = Game::new();
    let turn = bevy_drystone::AngularVelocity(Vec3::Y);
    let door = game.spawn((RigidBody::Kinematic, Collider::cuboid(1.0, 1.0, 1.0), turn));
    game.run(64);
    let angle = game.get::<Transform>(door).rotation.angle_between(Quat::IDENTITY);
    assert!(near(angle, 1.0, 1e-4), "1 rad/s for 1 s: {angle}");
}

/// A box falls when the ground is moved away under it, although it slept.
#[test]
fn a_write_to_a_static_body_moves_it_and_wakes_what_lay_on_it() {
    let mut game = Game::new();
    let ground = game.spawn(Collider::cuboid(4.0, 1.0, 4.0));
    let cube = game.cube([0.0, 1.0, 0.0]);
    game.run(256);
    assert!(game.body(cube).is_asleep());
    game.change::<Transform>(ground, |place| place.translation.x = 50.0);
    game.run(64);
    assert!(game.place(cube).y < -2.0);
}

#[derive(Default, Resource)]
struct Touched(Vec<Entity>);

/// Sleeping and static bodies are never written: no change tick, so that nothing that reacts to
/// changes runs for them.
#[test]
fn bodies_at_rest_are_not_written() {
    let mut game = Game::on_ground();
    let cube = game.cube([0.0, 0.5, 0.0]);
    game.run(256);
    assert!(game.body(cube).is_asleep());
    game.app.init_resource::<Touched>();
    let note = |changed: Query<'_, '_, Entity, Changed<Transform>>,
                mut list: ResMut<'_, Touched>| {
        list.0.extend(&changed);
    };
    game.app.add_systems(bevy_app::Last, note);
    // The first run of a system sees every change since the beginning.
    game.run(1);
    game.app.world_mut().resource_mut::<Touched>().0.clear();
    game.run(16);
    assert!(game.app.world().resource::<Touched>().0.is_empty());
}

/// Two frames a step: the first shows a body half way between its last two poses. Physics sees the
/// true pose.
#[test]
fn bodies_are_shown_between_their_poses() {
    let mut game = Game::with(DrystonePlugin::default().with_threads(1));
    game.app.insert_resource(bevy_drystone::Gravity::ZERO);
    let fast = |game: &mut Game| {
        let cube = game.cube([0.0; 3]);
        game.change::<LinearVelocity>(cube, |v| v.0.x = HERTZ);
        cube
    };
    let (shown, raw) = (fast(&mut game), fast(&mut game));
    game.insert(raw, NoInterpolation);
    game.change::<Transform>(raw, |place| place.translation.y = 5.0);
    game.run(4);
    let half = core::time::Duration::from_secs_f32(0.5 / HERTZ);
    game.app.insert_resource(TimeUpdateStrategy::ManualDuration(half));
    let x = |game: &Game, entity| f64::from(game.body(entity).position().x);
    let mut seen = Vec::new();
    for _ in 0..6 {
        game.app.update();
        let (body, place) = (x(&game, shown), f64::from(game.place(shown).x));
        seen.push(body - place);
        assert_eq!(game.place(raw).x.to_bits(), game.body(raw).position().x.to_bits());
    }
    // A meter a step: shown half a meter or a whole meter behind the true pose, in turns.
    let [half, whole] =
        [0.5, 1.0].map(|part: f64| move |behind: &f64| (behind - part).abs() < 1e-4);
    assert!(seen.iter().all(|behind| half(behind) || whole(behind)), "{seen:?}");
    assert!(seen.windows(2).all(|two| half(&two[0]) != half(&two[1])), "{seen:?}");
    // A teleport from `Update` is no interpolated motion: it is shown at once, and reaches physics.
    game.change::<Transform>(shown, |place| place.translation = Vec3::new(-100.0, 0.0, 0.0));
    game.app.update();
    game.app.update();
    let (body, place) = (x(&game, shown), f64::from(game.place(shown).x));
    assert!(body < -98.0 && place < -98.0, "{body} {place}");
}

#[test]
fn a_turn_alone_keeps_the_true_place() {
    let mut game = Game::with(DrystonePlugin::default().with_threads(1));
    game.app.insert_resource(bevy_drystone::Gravity::ZERO);
    let cube = game.cube([0.0; 3]);
    game.change::<LinearVelocity>(cube, |v| v.0.x = HERTZ);
    game.run(4);
    let before = game.body(cube).position().x;
    game.change::<Transform>(cube, |place| place.rotation = Quat::from_xyzw(0.0, 1.0, 0.0, 0.0));
    game.run(1);
    assert_eq!(game.body(cube).position().x.to_bits(), (before + 1.0).to_bits());
    assert!(game.body(cube).rotation().angle() > 3.0);
}
