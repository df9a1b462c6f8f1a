//! A glued beam breaks under a load, and the falling block breaks into pieces.

use drystone::breakage::{BondStrength, Fracture, Glue};
use drystone::{BodyDef, ShapeDef, World};

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), drystone::DefError> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    for x in [-1.5, 1.5] {
        let post = BodyDef::fixed().with_position([x, 0.5, 0.0]);
        world.add_body(post.with_shape(ShapeDef::box_full([0.4, 1.0, 1.0])))?;
    }
    // Seven blocks in a row, glued at their common faces.
    let block =
        |i: u8| ShapeDef::box_full([0.5, 0.2, 0.5]).with_position([f32::from(i) * 0.5, 0.0, 0.0]);
    let shapes: Vec<ShapeDef> = (0..7).map(block).collect();
    let glue = Glue::touching(&shapes, 1.0e-3, BondStrength::both(4.0e5))?;
    let beam = BodyDef { shapes, ..BodyDef::dynamic() }.with_position([-1.5, 1.1, 0.0]);
    world.add_body(beam.with_glue(glue))?;
    // The load exceeds the beam's strength, and itself breaks at an impact of 3 kJ.
    let how = Fracture::by_energy(3000.0).with_pieces(20);
    let load = BodyDef::dynamic().with_position([0.0, 3.0, 0.0]).with_fracture(how);
    world.add_body(load.with_shape(ShapeDef::box_full([0.6; 3]).with_density(2500.0)))?;

    for step in 1..=120 {
        world.step(1.0 / 60.0);
        for e in &world.events().bond_break {
            println!("step {step}: a bond broke at {:.0} kPa of tension", e.tension / 1000.0);
        }
        for e in &world.events().fractures {
            let pieces = world.events().pieces_of(e).len();
            println!("step {step}: {:?}, {:.0} of {:.0}, {pieces} new", e.cause, e.value, e.limit);
        }
    }
    println!("{} bodies", world.bodies().count());
    Ok(())
}
