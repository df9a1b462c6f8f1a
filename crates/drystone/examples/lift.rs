//! A lift carries three crates, slowly and fast. They keep their places, and sleep while it stops.

use drystone::math::trig;
use drystone::{BodyDef, BodyId, DefError, Pose, ShapeDef, World};

const DT: f32 = 1.0 / 60.0;

/// Moves the lift to a height in one step, and returns the maximum displacement of a crate from its
/// place [m].
fn step_to(world: &mut World, lift: BodyId, crates: &[BodyId], y: f32) -> Result<f32, DefError> {
    if let Some(mut lift) = world.body_mut(lift) {
        lift.move_to(Pose::at([0.0, y, 0.0]), DT);
    }
    world.step(DT);
    let height = |id: &BodyId| world.body(*id).map_or(f32::INFINITY, |body| body.position().y);
    let off = crates.iter().zip([0.35, 0.85, 1.35]).map(|(id, on)| (height(id) - y - on).abs());
    Ok(off.fold(0.0, f32::max))
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), DefError> {
    let mut world = World::default();
    let (mut crates, mut y, mut worst) = (Vec::new(), 0.0, 0.0_f32);
    let plate = ShapeDef::box_half([1.5, 0.1, 1.5]);
    let lift = world.add_body(BodyDef::kinematic().with_shape(plate))?;
    for i in 0..3_u8 {
        let at = BodyDef::dynamic().with_position([0.2, 0.35 + 0.5 * f32::from(i), 0.0]);
        crates.push(world.add_body(at.with_shape(ShapeDef::box_half([0.25; 3])))?);
    }
    for (speed, seconds) in [(0.0, 2), (0.02, 10), (0.0, 3), (-0.02, 10), (0.0, 3), (1e-4, 10)] {
        for _ in 0..60 * seconds {
            y += speed * DT;
            worst = worst.max(step_to(&mut world, lift, &crates, y)?);
        }
        let asleep = world.counts().asleep;
        println!("{speed} m/s: {:.2} mm off their places, {asleep} asleep", worst * 1e3);
        assert!(worst < 0.002 && asleep == if speed == 0.0 { 3 } else { 0 });
    }
    for k in 1..=480_u16 {
        let (_, cos) = trig::sin_cos(core::f32::consts::TAU * f32::from(k) / 240.0);
        worst = worst.max(step_to(&mut world, lift, &crates, y + 3.0 * (1.0 - cos))?);
    }
    assert!(worst < 0.01, "6 m up and down in 4 s: {:.2} mm off their places", worst * 1e3);
    Ok(())
}
