//! A car on four wheels with motors drives over a hump.

use bevy_app::{App, Startup};
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, Component, With};
use bevy_math::{Quat, Vec3};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

/// Radius of a wheel [m], and the speed of its motor [rad/s].
const RADIUS: f32 = 0.35;
const SPEED: f32 = 10.0;

#[derive(Component)]
struct Car;

fn setup(mut commands: Commands<'_, '_>) {
    commands.spawn((Collider::half_space(Vec3::Y), Friction::new(1.0)));
    let ramp = Quat::from_rotation_z(0.1);
    let hump = Transform { rotation: ramp, ..Transform::from_xyz(8.0, -0.3, 0.0) };
    commands.spawn((Collider::cuboid(6.0, 1.0, 6.0), hump, Friction::new(1.0)));
    let chassis = (RigidBody::Dynamic, Collider::cuboid(2.4, 0.4, 1.2), Mass(800.0), Car);
    let chassis = commands.spawn((chassis, Transform::from_xyz(0.0, 0.6, 0.0))).id();
    // The axis of a cylinder is y; a wheel turns about z.
    let turn = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    for (x, z) in [(-0.9, -0.8), (-0.9, 0.8), (0.9, -0.8), (0.9, 0.8)] {
        let hub = Vec3::new(x, RADIUS, z);
        let place = Transform::from_translation(hub).with_rotation(turn);
        let wheel = (RigidBody::Dynamic, Collider::cylinder(RADIUS, 0.25), Mass(20.0));
        let wheel = commands.spawn((wheel, place, Friction::new(1.0))).id();
        let motor = JointMotor::Speed { target: -SPEED, max_force: 300.0 };
        let axle = RevoluteJoint::new(chassis, wheel).at(hub).with_axis(Vec3::Z);
        commands.spawn(axle.with_motor(motor));
    }
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugin::default())).add_systems(Startup, setup);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    let mut highest = 0.0_f32;
    for _ in 0..384 {
        app.update();
        let mut cars = app.world_mut().query_filtered::<&Transform, With<Car>>();
        highest = cars.iter(app.world()).fold(highest, |top, car| top.max(car.translation.y));
    }
    let mut cars = app.world_mut().query_filtered::<(&Transform, &LinearVelocity), With<Car>>();
    for (car, speed) in cars.iter(app.world()) {
        println!("at {:.2}, highest {highest:.2} m, {:.2} m/s", car.translation, speed.0.x);
        // Wheels that roll move at ω r. The top of the hump is 0.5 m high; it takes 6 s.
        assert!((speed.0.x - SPEED * RADIUS).abs() < 0.1 && highest > 0.9);
        assert!(car.translation.x > 12.0 && car.translation.y > 0.4);
    }
}
