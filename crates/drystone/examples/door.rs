//! A door with stops, a closer and a latch that breaks: pushed, slammed open, closed, half open.

use drystone::{BodyDef, BodyId, JointDef, ShapeDef, World, joint, joint::JointSpring, vec3};

/// Pushes the handle [N]; returns the angle of each step [degrees] and the number of broken joints.
fn push(world: &mut World, door: BodyId, force: f32, steps: u32) -> Option<(Vec<f32>, usize)> {
    let (mut angles, mut broken) = (Vec::new(), 0);
    for _ in 0..steps {
        let at = world.body(door)?.pose();
        let (force, handle) = (at.direction(vec3(0.0, 0.0, -force)), at.point(vec3(0.4, 0.0, 0.0)));
        world.body_mut(door)?.add_step_force_at(force, handle);
        world.step(1.0 / 60.0);
        broken += world.events().joint_break.len();
        angles.push(world.body(door)?.rotation().to_rotation_vector().y.to_degrees());
    }
    Some((angles, broken))
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::default();
    let frame = world.add_body(BodyDef::fixed())?;
    let leaf = BodyDef::dynamic().with_position([0.45, 1.0, 0.0]).with_mass(25.0);
    let door = world.add_body(leaf.with_shape(ShapeDef::box_half([0.45, 1.0, 0.02])))?;
    let hinge = joint::Hinge::new().with_limits(0.0, 110_f32.to_radians()).with_motor(-0.5, 6.0);
    let hinge = JointDef::new(frame, door, hinge).at([0.0, 1.0, 0.0]).with_axis([0.0, 1.0, 0.0]);
    let hinge = world.add_joint(hinge)?;
    let latch = JointDef::new(frame, door, joint::Fixed::new()).at([0.9, 1.0, 0.0]);
    let latch = world.add_joint(latch.with_strength(800.0, f32::INFINITY))?;
    let (angles, broken) = push(&mut world, door, 200.0, 120).ok_or("no door")?;
    assert!(angles[119].abs() < 0.2 && broken == 0, "the latch holds 200 N");
    let (_, broken) = push(&mut world, door, 1200.0, 12).ok_or("no door")?;
    assert!(broken == 1 && world.joint(latch).is_none(), "it breaks at 1200 N, and is gone");
    let most = push(&mut world, door, 0.0, 90).ok_or("no door")?.0.into_iter().fold(0.0, f32::max);
    println!("slammed open to {most:.2} degrees");
    assert!((109.0..112.0).contains(&most));
    let (angles, _) = push(&mut world, door, 0.0, 300).ok_or("no door")?;
    let speed = (angles[149] - angles[148]).to_radians() * 60.0;
    assert!((speed + 0.5).abs() < 0.01 && angles[299] < 0.5, "it closes at {speed} rad/s");
    let (half, spring) = (55_f32.to_radians(), JointSpring::hertz(1.0, 1.0));
    world.joint_mut(hinge).ok_or("no hinge")?.set_servo(half, spring, f32::INFINITY);
    let (angles, _) = push(&mut world, door, 0.0, 240).ok_or("no door")?;
    assert!((angles[239] - 55.0).abs() < 0.5, "held at {} degrees", angles[239]);
    Ok(())
}
