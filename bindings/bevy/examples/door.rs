//! A door with a motor opens, and closes when a button is pressed.

use bevy_app::{App, Startup};
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, Query};
use bevy_ecs::system::RunSystemOnce;
use bevy_math::{Quat, Vec3};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

fn setup(mut commands: Commands<'_, '_>) {
    let wall = commands.spawn(RigidBody::Static).id();
    let door = (RigidBody::Dynamic, Collider::cuboid(1.0, 2.0, 0.06), Mass(30.0));
    let door = commands.spawn((door, Transform::from_xyz(0.5, 1.0, 0.0))).id();
    let open = JointMotor::Speed { target: 1.0, max_force: 400.0 };
    let hinge = RevoluteJoint::new(wall, door).at(Vec3::Y).with_axis(Vec3::Y);
    commands.spawn(hinge.with_angle_limits(0.0, 1.5).with_motor(open));
}

fn press(mut hinges: Query<'_, '_, &mut RevoluteJoint>) {
    for mut hinge in &mut hinges {
        hinge.motor = Some(JointMotor::Speed { target: -1.0, max_force: 400.0 });
    }
}

fn angle(doors: Query<'_, '_, (&Transform, &Mass)>) -> f32 {
    doors.iter().map(|(door, _)| door.rotation.angle_between(Quat::IDENTITY)).sum()
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
#[expect(clippy::expect_used, reason = "the systems of the example have valid parameters")]
fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugin::default())).add_systems(Startup, setup);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    let run = |app: &mut App, frames: u32| {
        (0..frames).for_each(|_| app.update());
        app.world_mut().run_system_once(angle).expect("a query alone")
    };
    let half_open = run(&mut app, 64);
    let open = run(&mut app, 64);
    app.world_mut().run_system_once(press).expect("a query alone");
    let closed = run(&mut app, 128);
    println!("after 1 s {half_open:.2} rad, after 2 s {open:.2} rad, at the end {closed:.2} rad");
    // 1 rad/s; the picture is up to two steps behind.
    assert!((half_open - 1.0).abs() < 0.05 && (open - 1.5).abs() < 0.02 && closed < 0.02);
}
