//! A ball jumps up through a platform and lands on it.

use bevy_app::{App, Startup};
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, With};
use bevy_math::Vec3;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

fn setup(mut commands: Commands<'_, '_>) {
    commands.spawn(Collider::half_space(Vec3::Y));
    let platform = (Collider::cuboid(4.0, 0.2, 4.0), OneWay(Vec3::Y));
    commands.spawn((platform, Transform::from_xyz(0.0, 2.0, 0.0)));
    let ball = (RigidBody::Dynamic, Collider::sphere(0.25), Transform::from_xyz(0.0, 0.25, 0.0));
    commands.spawn((ball, LinearVelocity(Vec3::Y * 8.0)));
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugin::default())).add_systems(Startup, setup);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    let mut ball = app.world_mut().query_filtered::<&Transform, With<RigidBody>>();
    let (mut highest, mut height) = (0.0_f32, 0.0);
    for _ in 0..192 {
        app.update();
        height = ball.iter(app.world()).map(|place| place.translation.y).sum();
        highest = highest.max(height);
    }
    println!("it rose to {highest:.2} m and came to rest at {height:.2} m");
    // It starts at 0.25 m and rises by v² / (2 g) = 3.26 m; the platform's top is at 2.1 m.
    assert!((highest - 3.51).abs() < 0.02 && (height - 2.35).abs() < 0.01);
}
