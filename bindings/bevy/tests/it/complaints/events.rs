//! Events of sensors, and their masses.

use bevy_drystone::{
    Collider, CollidingEntities, Gravity, LinearVelocity, RigidBody, Sensor, SensorEnter,
    SensorExit, SensorSenses,
};
use bevy_ecs::hierarchy::ChildOf;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

use crate::game::{Game, near};

/// bevy_rapier#634: two sensors without a dynamic body meet.
#[test]
fn sensors_can_detect_sensors() {
    let mut game = Game::new();
    let senses = SensorSenses { sensors: true, ..SensorSenses::default() };
    let still = game.spawn((Collider::cuboid(1.0, 1.0, 1.0), Sensor, senses));
    let start = Transform::from_xyz(-2.0, 0.0, 0.0);
    let moving = (RigidBody::Kinematic, LinearVelocity(Vec3::X * 4.0), start);
    let moving = game.spawn((moving, Collider::cuboid(1.0, 1.0, 1.0), Sensor));
    let mut enters = Vec::new();
    for _ in 0..64 {
        game.run(1);
        enters.extend(game.messages::<SensorEnter>());
    }
    assert_eq!(enters.len(), 1);
    assert_eq!((enters[0].sensor, enters[0].visitor), (still, moving));
}

/// bevy_rapier#107: each of several sensors of a body reports that a ball comes and leaves.
#[test]
fn each_sensor_of_a_body_reports_its_own_visitors() {
    let mut game = Game::new();
    game.app.insert_resource(Gravity::ZERO);
    let player = game.spawn((RigidBody::Kinematic, Collider::cuboid(1.0, 1.0, 1.0)));
    let sensors = [1.0, 2.0, 3.0].map(|x| {
        let place = Transform::from_xyz(x, 0.0, 0.0);
        game.spawn((Collider::cuboid(0.8, 0.8, 0.8), Sensor, place, ChildOf(player)))
    });
    for x in [1.0, 2.0, 3.0] {
        let place = Transform::from_xyz(x, 4.0, 0.0);
        let speed = LinearVelocity(Vec3::NEG_Y * 8.0);
        game.spawn((RigidBody::Dynamic, Collider::sphere(0.05), place, speed));
    }
    let (mut enters, mut exits) = (Vec::new(), Vec::new());
    for _ in 0..64 {
        game.run(1);
        enters.extend(game.messages::<SensorEnter>().into_iter().map(|e| e.sensor));
        exits.extend(game.messages::<SensorExit>().into_iter().map(|e| e.sensor));
    }
    enters.sort_unstable();
    exits.sort_unstable();
    let mut all = sensors.to_vec();
    all.sort_unstable();
    assert_eq!((enters, exits), (all.clone(), all));
}

/// bevy_rapier#334: when the visitor is despawned, the end still names it.
#[test]
fn the_end_of_a_visit_names_a_visitor_that_is_gone() {
    let mut game = Game::new();
    let grass = (Collider::cuboid(2.0, 2.0, 2.0), Sensor, CollidingEntities::default());
    let grass = game.spawn(grass);
    let hero = game.spawn((RigidBody::Kinematic, Collider::sphere(0.5)));
    game.run(2);
    assert!(game.get::<CollidingEntities>(grass).contains(hero));
    game.messages::<SensorExit>();
    game.despawn(hero);
    let mut exits = Vec::new();
    for _ in 0..3 {
        game.run(1);
        exits.extend(game.messages::<SensorExit>());
    }
    assert_eq!(exits.len(), 1);
    assert_eq!((exits[0].sensor, exits[0].visitor), (grass, hero));
    assert!(game.get::<CollidingEntities>(grass).entities().is_empty());
}

/// avian#381: a sensor adds no mass, and gives its mass back when it becomes solid.
#[test]
fn sensors_have_no_mass() {
    let mut game = Game::new();
    let body = game.cube([0.0; 3]);
    let place = Transform::from_xyz(3.0, 0.0, 0.0);
    let part = game.spawn((Collider::cuboid(1.0, 1.0, 1.0), Sensor, place, ChildOf(body)));
    game.run(1);
    // 1 m³ of 1000 kg/m³.
    let rounding = 4.0 * 2000.0 * f32::EPSILON;
    assert!(near(game.body(body).mass(), 1000.0, rounding));
    game.remove::<Sensor>(part);
    game.run(1);
    assert!(near(game.body(body).mass(), 2000.0, rounding));
}
