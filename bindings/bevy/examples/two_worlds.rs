//! The same jump on the earth and on the moon, in two worlds of one app.

use bevy_app::App;
use bevy_drystone::prelude::*;
use bevy_math::Vec3;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugin::default()));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    let mut moon = PhysicsWorld::default();
    moon.world_mut().set_gravity([0.0, -1.62, 0.0]);
    let moon = app.world_mut().spawn(moon).id();
    let jump = || (RigidBody::Dynamic, Collider::capsule(0.3, 1.0), LinearVelocity(Vec3::Y * 3.0));
    let here = app.world_mut().spawn(jump()).id();
    let there = app.world_mut().spawn((jump(), InWorld(moon))).id();
    let mut highest = [0.0_f32; 2];
    for _ in 0..160 {
        app.update();
        for (height, jumper) in highest.iter_mut().zip([here, there]) {
            let place = app.world().get::<Transform>(jumper);
            *height = place.map_or(*height, |place| height.max(place.translation.y));
        }
    }
    println!("highest on the earth {:.2} m, on the moon {:.2} m", highest[0], highest[1]);
    // v² / (2 g); a step lies up to g dt² / 8 below the top.
    for (height, gravity) in highest.into_iter().zip([9.81, 1.62]) {
        assert!((height - 9.0 / (2.0 * gravity)).abs() < 0.01, "{height}");
    }
}
