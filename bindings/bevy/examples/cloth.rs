//! A net, held at its corners, catches a ball.

use bevy_app::{App, Startup};
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, With};
use bevy_math::Vec3;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

fn setup(mut commands: Commands<'_, '_>) {
    let net = Cloth::new(Vec3::new(-1.0, 2.0, -1.0), [Vec3::X * 2.0, Vec3::Z * 2.0], [16, 16]);
    commands.spawn(net.with_pinned([true; 4]));
    let ball = (RigidBody::Dynamic, Collider::sphere(0.3), Mass(0.5));
    commands.spawn((ball, Transform::from_xyz(0.0, 3.0, 0.0)));
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugin::default())).add_systems(Startup, setup);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    (0..320).for_each(|_| app.update());
    let mut ball = app.world_mut().query_filtered::<&Transform, With<RigidBody>>();
    let height: f32 = ball.iter(app.world()).map(|place| place.translation.y).sum();
    let mut net = app.world_mut().query::<&ParticlePositions>();
    let lowest = net.iter(app.world()).flat_map(|net| &net.0).map(|p| p.y).fold(9.0, f32::min);
    println!("the ball lies at {height:.2} m in a net whose lowest knot is at {lowest:.2} m");
    // A knot is 0.02 m thick; gaps are 0.125 m wide, and the ball sinks into them by millimeters.
    assert!((height - 0.3 - lowest - 0.02).abs() < 0.03);
}
