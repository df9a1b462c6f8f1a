//! Bullets of 1 cm at 300 m/s meet thin plates at 60 steps per second: none passes through.

use drystone::{BodyDef, DefError, Quat, ShapeDef, Vec3, World, WorldConfig, vec3};

/// A plate about 7.3 m ahead of the bullet.
#[derive(Clone, Copy)]
struct Plate {
    thick: f32,
    mass: f32,
    velocity: Vec3,
    spin: Vec3,
    degrees: f32,
}

/// Shoots from `start`; returns whether the plate was hit, and the fraction of momentum lost.
fn shoot(plate: Plate, start: f32) -> Result<(bool, f32), DefError> {
    let config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
    let mut world = World::new(config)?;
    // The plate starts farther back by its displacement during the bullet's flight.
    let lead = plate.velocity * ((7.3 - start) / 300.0);
    let turn = Quat::from_axis_angle(Vec3::Z, plate.degrees.to_radians());
    let body = BodyDef::dynamic().with_position(vec3(7.3, 0.0, 0.0) - lead).with_rotation(turn);
    let body = body.with_linear_velocity(plate.velocity).with_angular_velocity(plate.spin);
    let shape = ShapeDef::box_half([plate.thick / 2.0, 0.15, 0.15]);
    world.add_body(body.with_mass(plate.mass).with_shape(shape))?;
    let bullet = BodyDef::dynamic().with_position([start, 0.02, 0.03]).with_mass(0.008);
    let bullet = bullet.with_linear_velocity([300.0, 0.0, 0.0]).with_shape(ShapeDef::sphere(0.005));
    world.add_body(bullet)?;
    let (before, mut met) = (world.momentum(), false);
    for _ in 0..12 {
        world.step(1.0 / 60.0);
        met |= !world.events().contact_begin.is_empty();
    }
    Ok((met, (world.momentum() - before).length() / before.length()))
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), DefError> {
    let (mut passed, mut shots, mut lost) = (0, 0, 0.0_f32);
    for thick in [0.02, 0.005, 0.001, 0.0005] {
        for (velocity, spin) in [
            (Vec3::ZERO, Vec3::ZERO),
            (vec3(0.0, 20.0, 0.0), Vec3::ZERO),
            (vec3(50.0, 0.0, 0.0), Vec3::ZERO),
            (vec3(-50.0, 0.0, 0.0), Vec3::ZERO),
            (Vec3::ZERO, vec3(0.0, 3.0, 0.0)),
        ] {
            for k in 0..40_u8 {
                let (degrees, mass) = (30.0 * f32::from(k % 3), [0.05, 1.0][usize::from(k % 2)]);
                let plate = Plate { thick, mass, velocity, spin, degrees };
                let (met, loss) = shoot(plate, 0.13 * f32::from(k))?;
                (passed, shots) = (passed + u32::from(!met), shots + 1);
                lost = lost.max(loss);
            }
        }
    }
    println!("{passed} of {shots} bullets pass through; {lost:.1e} of the momentum is lost");
    assert!(passed == 0 && lost < 1e-3);
    Ok(())
}
