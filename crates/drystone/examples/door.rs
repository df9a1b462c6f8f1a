//! A door on a hinge: limits, a closer, a motor that opens it, and a latch that breaks.

use drystone::joint::{Ball, Hinge};
use drystone::{BodyDef, DefError, JointDef, JointId, JointSpring, ShapeDef, World};

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), DefError> {
    let mut world = World::default();
    let wall = world.add_body(BodyDef::fixed())?;
    let door = BodyDef::dynamic().with_position([0.45, 1.0, 0.0]).with_mass(25.0);
    let door = world.add_body(door.with_shape(ShapeDef::box_half([0.45, 1.0, 0.02])))?;

    // The pin is upright at x = 0. Seen from above, a positive angle opens counterclockwise.
    let hinge = Hinge::new().with_limits(0.0, 1.9).with_friction(0.5);
    let hinge = JointDef::new(wall, door, hinge).at([0.0, 1.0, 0.0]).with_axis([0.0, 1.0, 0.0]);
    let hinge = world.add_joint(hinge)?;
    // The latch holds the far edge until more than 300 N pull at it.
    let latch = JointDef::new(wall, door, Ball::new()).at([0.9, 1.0, 0.0]);
    world.add_joint(latch.with_strength(300.0, f32::INFINITY))?;

    if let Some(mut joint) = world.joint_mut(hinge) {
        joint.set_motor(1.0, 100.0)?;
    }
    run(&mut world, 1.0);
    println!("latched: {:.2} rad", angle(&world, hinge));

    if let Some(mut joint) = world.joint_mut(hinge) {
        joint.set_motor(1.0, 500.0)?;
    }
    run(&mut world, 3.0);
    println!("open: {:.2} rad", angle(&world, hinge));
    assert!((angle(&world, hinge) - 1.9).abs() < 0.01);

    let closer = JointSpring::hertz(0.5, 1.0);
    if let Some(mut joint) = world.joint_mut(hinge) {
        joint.set_servo(0.0, closer, 40.0)?;
    }
    run(&mut world, 6.0);
    println!("closed: {:.2} rad", angle(&world, hinge));
    assert!(angle(&world, hinge).abs() < 0.05);
    Ok(())
}

fn run(world: &mut World, seconds: f32) {
    let mut time = 0.0;
    while time < seconds {
        world.step(1.0 / 60.0);
        time += 1.0 / 60.0;
    }
}

fn angle(world: &World, hinge: JointId) -> f32 {
    world.joint(hinge).and_then(|joint| joint.angle()).unwrap_or(f32::NAN)
}
