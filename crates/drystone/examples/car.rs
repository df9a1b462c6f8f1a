//! A car on four sprung wheels: the rear ones drive, the front ones steer.

use drystone::joint::Wheel;
use drystone::{Axis, BodyDef, DefError, JointDef, JointSpring, ShapeDef, World};

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), DefError> {
    let mut world = World::default();
    let ground = ShapeDef::box_half([100.0, 1.0, 100.0]).with_friction(0.9);
    world.add_body(BodyDef::fixed().with_position([0.0, -1.0, 0.0]).with_shape(ground))?;
    // It faces x; y is up, so that -z is its left.
    let chassis = BodyDef::dynamic().with_position([0.0, 0.75, 0.0]).with_mass(1000.0);
    let chassis = world.add_body(chassis.with_shape(ShapeDef::box_half([1.8, 0.25, 0.7])))?;

    // Each spring bears a quarter of the chassis: at 1.5 Hz it sinks by 11 cm.
    let spring = JointSpring::for_load(1.5, 0.5, 250.0);
    let steering = JointSpring::hertz(6.0, 1.0);
    let mut front = Vec::new();
    for (x, z) in [(1.3, -0.8), (1.3, 0.8), (-1.3, -0.8), (-1.3, 0.8)] {
        let tire = ShapeDef::sphere(0.35).with_friction(0.9);
        let hub = [x, 0.35, z];
        let wheel = BodyDef::dynamic().with_position(hub).with_mass(25.0).with_shape(tire);
        let wheel = world.add_body(wheel)?;
        let kind = Wheel::new(spring).with_travel(-0.2, 0.2);
        let kind = if x > 0.0 {
            kind.with_steering(0.0, steering, 2000.0)
        } else {
            kind.with_motor(20.0, 300.0)
        };
        let joint = JointDef::new(chassis, wheel, kind).at(hub);
        let joint = world.add_joint(joint.with_axes([0.0, 1.0, 0.0], [0.0, 0.0, -1.0]))?;
        if x > 0.0 {
            front.push(joint);
        }
    }
    for step in 0..480 {
        if step == 240 {
            // To the left: by the right hand about up.
            for joint in &front {
                let Some(mut joint) = world.joint_mut(*joint) else { continue };
                if let Some(mut turn) = joint.axis(Axis::TurnX) {
                    turn.set_servo(0.1, steering, 2000.0)?;
                }
            }
        }
        world.step(1.0 / 60.0);
        if step % 60 == 59 {
            let Some(car) = world.body(chassis) else { break };
            let (at, speed) = (car.position(), car.linear_velocity().length());
            println!("x {:6.2} m  z {:6.2} m  {speed:5.2} m/s", at.x, at.z);
        }
    }
    let at = world.body(chassis).map(|car| car.position());
    assert!(at.is_some_and(|at| at.x > 10.0 && at.z < -0.5), "it drives forward, then left");
    Ok(())
}
