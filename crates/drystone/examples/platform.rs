//! A one-way platform, a scale under it, and what they report.

use drystone::{BodyDef, ContactReports, DefError, ShapeDef, Vec3, World};

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), DefError> {
    let mut world = World::default();
    // The plate of a scale reports what presses on it.
    let plate = ShapeDef::box_half([2.0, 0.1, 2.0]).with_reports(ContactReports::with_forces());
    let scale =
        world.add_body(BodyDef::fixed().with_position([0.0, -0.1, 0.0]).with_shape(plate))?;
    // One and a half meters above hangs a platform that can be jumped through from below.
    let board = ShapeDef::box_half([1.0, 0.05, 1.0]).with_one_way(Vec3::Y);
    world.add_body(BodyDef::fixed().with_position([0.0, 1.5, 0.0]).with_shape(board))?;

    let body = BodyDef::dynamic().with_position([0.0, 0.5, 0.0]).with_mass(70.0);
    let jumper = world.add_body(body.with_shape(ShapeDef::capsule(0.25, 0.25)))?;
    step(&mut world, 60);
    println!("it weighs {:.1} N", -world.events().contact_force_on(scale).y);

    if let Some(mut jumper) = world.body_mut(jumper) {
        jumper.set_linear_velocity([0.0, 6.5, 0.0])?;
    }
    for _ in 0..120 {
        world.step(1.0 / 60.0);
        for hit in &world.events().hits {
            println!("it lands at {:.2} m/s with {:.0} N s", hit.speed, hit.impulse);
        }
    }
    let height = world.body(jumper).map_or(f32::NAN, |jumper| jumper.position().y);
    println!("it stands {height:.2} m high");
    assert!((height - 2.05).abs() < 0.01, "on the platform");
    Ok(())
}

fn step(world: &mut World, count: u32) {
    for _ in 0..count {
        world.step(1.0 / 60.0);
    }
}
