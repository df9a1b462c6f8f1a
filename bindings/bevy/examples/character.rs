//! A character walks up stairs, and rides a lift.

use bevy_app::{App, FixedUpdate, Startup};
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, Component, Entity, Query, Res};
use bevy_math::Vec3;
use bevy_time::{Time, TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

/// Walks by this velocity [m/s], and falls.
#[derive(Component)]
struct Hero {
    walk: Vec3,
    fall: f32,
}

fn setup(mut commands: Commands<'_, '_>) {
    commands.spawn(Collider::half_space(Vec3::Y));
    for k in 0..5_u8 {
        let (x, y) = (4.0 + 0.4 * f32::from(k), 0.15 + 0.3 * f32::from(k));
        commands.spawn((Collider::cuboid(2.0, 0.3, 2.0), Transform::from_xyz(x, y, 0.0)));
    }
    let hero = (RigidBody::Kinematic, Collider::capsule(0.3, 1.0));
    let walk = Hero { walk: Vec3::X * 2.0, fall: 0.0 };
    commands.spawn((hero, walk, Transform::from_xyz(0.0, 0.81, 0.0)));
    let lift = (RigidBody::Kinematic, Collider::cuboid(2.0, 0.2, 2.0));
    commands.spawn((lift, LinearVelocity(Vec3::Y), Transform::from_xyz(0.0, 0.1, 9.0)));
    let rider = (RigidBody::Kinematic, Collider::capsule(0.3, 1.0));
    let stand = Hero { walk: Vec3::ZERO, fall: 0.0 };
    commands.spawn((rider, stand, Transform::from_xyz(0.0, 1.01, 9.0)));
}

fn walk(
    mover: CharacterMover<'_, '_>,
    mut heroes: Query<'_, '_, (Entity, &mut Transform, &Collider, &mut Hero)>,
    time: Res<'_, Time>,
) {
    let (dt, settings) = (time.delta_secs(), CharacterSettings::default());
    for (entity, mut place, collider, mut hero) in &mut heroes {
        let others = SpatialQueryFilter::from_excluded_entities([entity]);
        let delta = (hero.walk + Vec3::Y * hero.fall) * dt;
        let (at, turn) = (place.translation, place.rotation);
        let Some(moved) = mover.move_by(collider, at, turn, delta, &settings, &others) else {
            continue;
        };
        hero.fall = if moved.is_grounded { 0.0 } else { hero.fall - 9.81 * dt };
        place.translation = moved.position + moved.ground_velocity * dt;
    }
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugin::default()))
        .add_systems(Startup, setup)
        .add_systems(FixedUpdate, walk)
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    (0..150).for_each(|_| app.update());
    let mut heroes = app.world_mut().query::<(&Transform, &Hero)>();
    let heights: Vec<f32> = heroes.iter(app.world()).map(|(t, _)| t.translation.y).collect();
    println!("on the stairs at {:.2} m, on the lift at {:.2} m", heights[0], heights[1]);
    // The middle of the capsule is 0.8 m over its ground, with a skin of 0.01 m. The lift rose at
    // 1 m/s for about 2.3 s.
    assert!((heights[0] - 2.31).abs() < 0.05 && (heights[1] - 3.35).abs() < 0.1);
}
