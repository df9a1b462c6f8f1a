//! A character walks on stairs and slopes, rides a lift and pushes crates: a mover and a body.

use drystone::query::{BodyKinds, QueryFilter};
use drystone::{BodyDef, BodyId, DefError, Quat, Shape, ShapeDef, Vec3, World, math::trig, vec3};

/// Walks along x [m/s]; returns the position. Crates do not block the mover: its body pushes them.
fn walk(world: &mut World, body: BodyId, speed: f32, steps: u32) -> Result<Vec3, DefError> {
    let (mover, mut fall, dt) =
        (drystone::mover::Mover::new(Shape::capsule(0.5, 0.3)), 0.0, 1.0 / 60.0);
    let level = QueryFilter::default().with_kinds(BodyKinds::STATIC | BodyKinds::KINEMATIC);
    for _ in 0..steps {
        let moved = mover.move_body(world, body, vec3(speed, fall, 0.0), dt, level)?;
        fall = if moved.grounded { 0.0 } else { fall - 9.81 * dt };
        world.step(dt);
    }
    Ok(mover.move_body(world, body, Vec3::ZERO, dt, level)?.pose.position)
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::default();
    let put = |world: &mut World, def: BodyDef, x: f32, y: f32, shape: ShapeDef| {
        world.add_body(def.with_position([x, y, 0.0]).with_shape(shape))
    };
    put(&mut world, BodyDef::fixed(), 0.0, 0.0, ShapeDef::half_space(Vec3::Y, 0.0))?;
    for (i, stair) in [0.0, 1.0, 2.0, 3.0, 4.0].map(|i| (i, ShapeDef::box_half([1.0, 0.15, 1.0]))) {
        put(&mut world, BodyDef::fixed(), 4.0 + 0.4 * i, 0.15 + 0.3 * i, stair)?;
    }
    let (driven, capsule) = (BodyDef::kinematic, || ShapeDef::capsule(0.5, 0.3));
    let body = put(&mut world, driven(), 0.0, 0.9, capsule())?;
    let (up, down) = (walk(&mut world, body, 2.0, 140)?.y, walk(&mut world, body, -2.0, 150)?.y);
    println!("up five stairs to {up:.3} m, and down to {down:.3} m");
    assert!((up - 2.31).abs() < 0.05 && (down - 0.81).abs() < 0.02);
    for (degrees, stands) in [(20.0_f32, true), (44.0, true), (50.0, false)] {
        let (x, turn) = (40.0 + degrees, Quat::from_axis_angle(Vec3::Z, degrees.to_radians()));
        let slope = ShapeDef::box_half([9.0, 0.1, 1.0]);
        put(&mut world, BodyDef::fixed().with_rotation(turn), x, 30.0, slope)?;
        let body = put(&mut world, driven(), x, 31.5, capsule())?;
        let (from, stood) = (walk(&mut world, body, 0.0, 60)?, walk(&mut world, body, 0.0, 60)?);
        let way = walk(&mut world, body, 1.0, 60)? - stood;
        assert_eq!((stood - from).length() < 0.001, stands, "{degrees} degrees");
        assert!(!stands || (way.y / way.x - trig::tan(degrees.to_radians())).abs() < 0.1);
    }
    let lift = put(&mut world, driven(), -5.0, 0.1, ShapeDef::box_half([1.0, 0.1, 1.0]))?;
    let body = put(&mut world, driven(), -5.0, 1.01, capsule())?;
    for speed in [0.02, 2.0, -2.0, -0.02].into_iter().flat_map(|speed| [speed; 120]) {
        world.body_mut(lift).ok_or("no lift")?.set_linear_velocity([0.1, speed, 0.0]);
        let off = walk(&mut world, body, 0.0, 1)? - world.body(lift).ok_or("no lift")?.position();
        assert!((off.y - 0.91).abs() < 0.02 && off.x.abs() < 0.02, "it rides the lift");
    }
    for mass in [40.0, 4000.0] {
        let (x, cube) = (-40.0 - mass / 100.0, ShapeDef::box_half([0.4; 3]));
        let load = put(&mut world, BodyDef::dynamic().with_mass(mass), x + 1.5, 0.4, cube)?;
        let body = put(&mut world, driven(), x, 0.81, capsule())?;
        let at = walk(&mut world, body, 1.5, 120)?.x;
        let off = world.body(load).ok_or("no crate")?.position().x - at;
        assert!((off - 0.7).abs() < 0.02, "a crate of {mass} kg is pushed before it");
    }
    Ok(())
}
