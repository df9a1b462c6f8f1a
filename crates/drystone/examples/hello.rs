//! A ball falls on the ground.

use drystone::{BodyDef, ShapeDef, World};

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), drystone::DefError> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    let ball = BodyDef::dynamic().with_position([0.0, 4.0, 0.0]);
    let ball = world.add_body(ball.with_shape(ShapeDef::sphere(0.5)))?;
    for _ in 0..120 {
        world.step(1.0 / 60.0);
    }
    println!("{:?}", world.body(ball).map(|b| b.position()));
    Ok(())
}
