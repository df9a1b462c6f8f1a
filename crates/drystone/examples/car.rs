//! A car on four sprung wheels drives up a ramp, brakes there, rolls back, and steers. It faces x.

use drystone::joint::{JointDrive, JointSpring, Wheel};
use drystone::{Axis, BodyDef, BodyId, JointDef, JointId, Quat, ShapeDef, Vec3, World, math::trig};

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn drive(w: &mut World, wheels: &[JointId], axis: Axis, how: Option<JointDrive>) -> Outcome {
    for wheel in wheels {
        w.joint_mut(*wheel).ok_or("no joint")?.axis(axis).ok_or("no axis")?.set_drive(how)?;
    }
    Ok(())
}

/// Steps for some tenths of a second; returns position and velocity.
fn run(world: &mut World, car: BodyId, tenths: u32) -> (Vec3, Vec3) {
    (0..6 * tenths).for_each(|_| world.step(1.0 / 60.0));
    world.body(car).map_or_else(Default::default, |car| (car.position(), car.linear_velocity()))
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Outcome {
    let mut world = World::default();
    let (sin, cos) = trig::sin_cos(15_f32.to_radians());
    for (normal, offset) in [(Vec3::Y, 0.0), (Vec3::from([-sin, cos, 0.0]), -20.0 * sin)] {
        let ground = ShapeDef::half_space(normal, offset).with_friction(1.0);
        world.add_body(BodyDef::fixed().with_shape(ground))?;
    }
    let car = BodyDef::dynamic().with_position([0.0, 0.75, 0.0]).with_mass(1000.0);
    let car = world.add_body(car.with_shape(ShapeDef::box_half([1.9, 0.3, 0.8])))?;
    let (spring, steering) = (JointSpring::new(30_000.0, 3_000.0), JointSpring::hertz(8.0, 1.0));
    let (mut wheels, lay) = (Vec::new(), Quat::from_axis_angle(Vec3::X, 90_f32.to_radians()));
    for (x, z) in [(1.3, -0.8), (1.3, 0.8), (-1.3, -0.8), (-1.3, 0.8)] {
        let wheel = BodyDef::dynamic().with_position([x, 0.4, z]).with_rotation(lay);
        let tire = ShapeDef::cylinder(0.1, 0.33).with_friction(1.0);
        let wheel = world.add_body(wheel.with_mass(20.0).with_shape(tire))?;
        let kind = Wheel::new(spring).with_travel(-0.1, 0.2);
        let kind = if x > 0.0 { kind.with_steering(0.0, steering, 3000.0) } else { kind };
        let joint = JointDef::new(car, wheel, kind).at([x, 0.4, z]);
        wheels.push(world.add_joint(joint.with_axes(Vec3::Y, -Vec3::Z))?);
    }
    run(&mut world, car, 20);
    let sinks = world.joint(wheels[0]).and_then(|j| j.axis(Axis::X)).map(|axis| axis.position());
    assert!(sinks.is_some_and(|sinks| (sinks - 250.0 * 9.81 / 30_000.0).abs() < 0.001));
    drive(&mut world, &wheels[2..], Axis::TurnY, Some(JointDrive::motor(30.0, 800.0)))?;
    let (at, speed) = run(&mut world, car, 15);
    assert!(speed.x > 3.0 && at.z.abs() < 0.1, "it drives forward");
    assert!(run(&mut world, car, 35).0.y > 1.5, "up the ramp");
    drive(&mut world, &wheels, Axis::TurnY, Some(JointDrive::motor(0.0, 3000.0)))?;
    let creep = (run(&mut world, car, 30).0 - run(&mut world, car, 100).0).length();
    assert!(creep < 0.001, "the brakes hold");
    drive(&mut world, &wheels, Axis::TurnY, None)?;
    run(&mut world, car, 40);
    drive(&mut world, &wheels[..2], Axis::TurnX, Some(JointDrive::servo(0.3, steering, 3000.0)))?;
    let bicycle = run(&mut world, car, 5).1.length() * trig::tan(0.3) / 2.6;
    let yaw = world.body(car).ok_or("no car")?.angular_velocity().y.abs();
    println!("it creeps {creep} m, turns at {yaw:.2} rad/s, a bicycle at {bicycle:.2} rad/s");
    assert!((yaw - bicycle).abs() < 0.3 * yaw);
    Ok(())
}
