//! A ghost walks through walls, and becomes solid inside one, which pushes it out.

use drystone::{AxisLocks, BodyDef, BodyId, Filter, ShapeDef, World};

const WALL: u64 = 2;
const PLAYER: u64 = 4;

/// Walks for some steps at this speed [m/s], and returns the position.
fn walk(world: &mut World, player: BodyId, speed: f32, steps: u32) -> Option<[f32; 3]> {
    for _ in 0..steps {
        let mut body = world.body_mut(player)?;
        let fall = body.get().linear_velocity().y;
        body.set_linear_velocity([speed, fall, 0.0]);
        world.step(1.0 / 60.0);
    }
    Some(world.body(player)?.position().to_array())
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    for x in [2.0, 4.0, 6.0] {
        let wall = ShapeDef::box_half([0.2, 1.0, 2.0]).with_filter(Filter::layers(WALL, u64::MAX));
        world.add_body(BodyDef::fixed().with_position([x, 1.0, 0.0]).with_shape(wall))?;
    }
    let player = BodyDef { locks: AxisLocks::ROTATION, ..BodyDef::dynamic() };
    let player = world.add_body(player.with_position([0.0, 0.8, 0.0]).with_mass(70.0))?;
    let solid = Filter::layers(PLAYER, u64::MAX);
    let shape = ShapeDef::capsule(0.5, 0.3).with_friction(0.0).with_filter(solid);
    let shape = world.add_shape(player, shape)?;
    let [x, ..] = walk(&mut world, player, 2.0, 120).ok_or("no player")?;
    println!("the wall stops it at {x:.3} m");
    assert!((x - 1.5).abs() < 0.01);
    world.shape_mut(shape).ok_or("no shape")?.set_filter(Filter::layers(PLAYER, !WALL));
    let [x, y, _] = walk(&mut world, player, 2.0, 90).ok_or("no player")?;
    assert!((x - 4.5).abs() < 0.05 && (y - 0.8).abs() < 0.005, "a ghost walks through two");
    walk(&mut world, player, 2.0, 42).ok_or("no player")?;
    world.shape_mut(shape).ok_or("no shape")?.set_filter(solid);
    (0..240).for_each(|_| world.step(1.0 / 60.0));
    let player = world.body(player).ok_or("no player")?;
    println!("the wall pushes it out to {:.3} m", player.position().x);
    assert!((player.position().x - 6.0).abs() > 0.49 && (player.mass() - 70.0).abs() < 1e-3);
    Ok(())
}
