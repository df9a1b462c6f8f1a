//! Ten boxes fall and make a tower.

use bevy_app::{App, Startup};
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, With};
use bevy_math::Vec3;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

fn setup(mut commands: Commands<'_, '_>) {
    commands.spawn(Collider::half_space(Vec3::Y));
    for k in 0..10_u8 {
        let place = Transform::from_xyz(0.0, 0.5 + 1.2 * f32::from(k), 0.0);
        commands.spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), place));
    }
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugin::default())).add_systems(Startup, setup);
    // Without a window nothing paces the frames: each one advances by a fixed step of 1/64 s.
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    for _ in 0..320 {
        app.update();
    }
    let mut boxes = app.world_mut().query_filtered::<&Transform, With<RigidBody>>();
    let mut heights: Vec<f32> = boxes.iter(app.world()).map(|t| t.translation.y).collect();
    heights.sort_by(f32::total_cmp);
    println!("{heights:?}");
    // Contacts sink in by at most 5 mm each.
    for (k, height) in (0_u8..).zip(heights) {
        let (rest, layers) = (0.5 + f32::from(k), f32::from(k + 1));
        assert!((height - rest).abs() < 0.005 * layers, "box {k} at {height}");
    }
}
