//! A door with stops, a closer and a latch that breaks: pushed, slammed open, closed, and held half open.

use drystone::joint::{Fixed, Hinge};
use drystone::{BodyDef, BodyId, JointDef, JointSpring, ShapeDef, World, vec3};

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Pushes the handle for some steps; gives the angles [degrees] and how many joints broke.
fn push(world: &mut World, door: BodyId, force: f32, steps: u32) -> Outcome<(Vec<f32>, usize)> {
    let (mut angles, mut broken) = (Vec::new(), 0);
    for _ in 0..steps {
        let mut leaf = world.body_mut(door).ok_or("no door")?;
        let at = leaf.get().pose();
        let force = at.direction(vec3(0.0, 0.0, -force));
        leaf.add_step_force_at(force, at.point(vec3(0.4, 0.0, 0.0)))?;
        world.step(1.0 / 60.0);
        broken += world.events().joint_break.len();
        let turn = world.body(door).ok_or("no door")?.rotation().to_rotation_vector();
        angles.push(turn.y.to_degrees());
    }
    Ok((angles, broken))
}

fn main() -> Outcome<()> {
    let mut world = World::default();
    let frame = world.add_body(BodyDef::fixed())?;
    let leaf = ShapeDef::box_half([0.45, 1.0, 0.02]);
    let leaf = BodyDef::dynamic().with_position([0.45, 1.0, 0.0]).with_mass(25.0).with_shape(leaf);
    let door = world.add_body(leaf)?;
    let hinge = Hinge::new().with_limits(0.0, 110_f32.to_radians()).with_motor(-0.5, 6.0);
    let hinge = JointDef::new(frame, door, hinge).at([0.0, 1.0, 0.0]).with_axis([0.0, 1.0, 0.0]);
    let hinge = world.add_joint(hinge)?;
    let latch = JointDef::new(frame, door, Fixed::new()).at([0.9, 1.0, 0.0]);
    let latch = world.add_joint(latch.with_strength(800.0, f32::INFINITY))?;
    let (angles, broken) = push(&mut world, door, 200.0, 120)?;
    println!("200 N on the latched door: {:.4} degrees", angles[119]);
    assert!(broken == 0 && angles[119].abs() < 0.2);
    let (_, broken) = push(&mut world, door, 1200.0, 12)?;
    assert!(broken == 1 && world.joint(latch).is_none(), "the latch breaks, and is gone");
    let (angles, _) = push(&mut world, door, 0.0, 90)?;
    let most = angles.into_iter().fold(0.0, f32::max);
    println!("slammed open to {most:.2} degrees");
    assert!(most > 109.0 && most < 112.0);
    push(&mut world, door, 0.0, 150)?;
    let speed =
        world.joint(hinge).and_then(|joint| Some(joint.hinge()?.speed())).ok_or("no hinge")?;
    let (angles, _) = push(&mut world, door, 0.0, 150)?;
    println!("closes at {speed:.3} rad/s, to {:.3} degrees", angles[149]);
    assert!((speed + 0.5).abs() < 0.01 && angles[149] < 0.5);
    let half = (55_f32.to_radians(), JointSpring::hertz(1.0, 1.0), f32::INFINITY);
    world.joint_mut(hinge).ok_or("no hinge")?.set_servo(half.0, half.1, half.2)?;
    let (angles, _) = push(&mut world, door, 0.0, 240)?;
    println!("held at {:.2} degrees", angles[239]);
    assert!((angles[239] - 55.0).abs() < 0.5);
    Ok(())
}
