//! Turns time back: the state before each step of the last second is kept, and the world from half a second ago goes on with
//! another input, as a game does that learns late what another player did.
//!
//! `cargo run --release --example rollback`

use drystone::{BodyDef, ShapeDef, World};

const DT: f32 = 1.0 / 60.0;

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    let mut boxes = Vec::new();
    for i in 0..10_u8 {
        let at = BodyDef::dynamic().with_position([0.0, 0.5 + f32::from(i), 0.0]);
        boxes.push(world.add_body(at.with_shape(ShapeDef::box_half([0.5; 3])))?);
    }

    // In the loop of a game these are a ring: `clone_from` takes no new memory.
    let mut past = vec![World::default(); 60];
    for kept in &mut past {
        kept.clone_from(&world);
        world.step(DT);
    }

    // What was not known then: half a second ago something hit the box in the middle. Ids are what they were.
    let mut other = past[30].clone();
    if let Some(mut hit) = other.body_mut(boxes[5]) {
        hit.apply_impulse([3000.0, 0.0, 0.0])?;
    }
    // And what is not changed comes out as it did, to the last bit.
    let mut same = past[30].clone();
    for _ in 30..60 {
        other.step(DT);
        same.step(DT);
    }
    assert_eq!(same.state_hash(), world.state_hash());
    for (name, world) in [("as it was", &world), ("with the hit", &other)] {
        println!("{name:>12}: the box is at {:?}", world.body(boxes[5]).map(|b| b.position()));
    }
    Ok(())
}
