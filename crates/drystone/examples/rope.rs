//! A weight on a rope: particles, links, an attachment.

use drystone::particle::RopeDef;
use drystone::{BodyDef, DefError, ShapeDef, World};

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), DefError> {
    let mut world = World::default();
    let weight = BodyDef::dynamic().with_position([0.0, 2.9, 0.0]).with_mass(2.0);
    let weight = world.add_body(weight.with_shape(ShapeDef::box_half([0.1; 3])))?;
    let mut rope = RopeDef::between([0.0, 5.0, 0.0], [0.0, 3.0, 0.0], 10);
    rope.pinned = [true, false];
    let rope = world.add_rope(rope)?;
    let end = rope.particles[10];
    world.particle_mut(end).expect("there").attach(weight, [0.0, 0.1, 0.0])?;

    for _ in 0..600 {
        world.step(1.0 / 60.0);
    }
    let (Some(body), Some(held)) = (world.body(weight), world.particle(end)) else { return Ok(()) };
    println!("the weight hangs at {:?}", body.position());
    println!("by a force of {:?} N, 2 kg have {:.2} N", -held.attachment_force(), 2.0 * 9.81);
    for link in rope.links.iter().filter_map(|id| world.link(*id)) {
        println!("link of {:.3} m: {:.2} N", link.distance(), link.tension());
    }
    Ok(())
}
