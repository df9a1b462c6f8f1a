//! A one-way platform: a character jumps up through it, stands, drops through it; a crate stays.

use drystone::{AxisLocks, BodyDef, BodyId, DefError, ShapeDef, Vec3, World};

fn height(world: &World, body: BodyId) -> f32 {
    world.body(body).map_or(f32::NAN, |body| body.position().y)
}

/// Takes some steps, and returns the maximum height of the body [m].
fn run(world: &mut World, body: BodyId, steps: u32) -> f32 {
    (0..steps).fold(0.0, |highest, _| {
        world.step(1.0 / 60.0);
        height(world, body).max(highest)
    })
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), DefError> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    let board = ShapeDef::box_half([2.0, 0.1, 2.0]).with_one_way(Vec3::Y);
    let board = BodyDef::fixed().with_position([0.0, 2.4, 0.0]).with_shape(board);
    let board = world.add_body(board)?;
    let guest = BodyDef::dynamic().with_position([1.0, 2.8, 0.0]);
    let guest = world.add_body(guest.with_shape(ShapeDef::box_half([0.3; 3])))?;
    let player = BodyDef { locks: AxisLocks::ROTATION, ..BodyDef::dynamic() };
    let player = player.with_position([0.0, 0.8, 0.0]).with_mass(80.0);
    let player = world.add_body(player.with_shape(ShapeDef::capsule(0.5, 0.3)))?;
    run(&mut world, player, 30);
    if let Some(mut player) = world.body_mut(player) {
        player.apply_impulse([0.0, 80.0 * 8.0, 0.0]);
    }
    let (apex, free) = (run(&mut world, player, 150), 0.8 + 64.0 / 19.62);
    println!("apex {apex:.3} m (free {free:.3} m), stands at {:.4} m", height(&world, player));
    assert!((apex - free).abs() < 0.06, "the platform does not brake the jump");
    assert!((height(&world, player) - 3.3).abs() < 0.005);
    world.set_bodies_collide(player, board, false);
    run(&mut world, player, 20);
    world.set_bodies_collide(player, board, true);
    run(&mut world, player, 70);
    let [down, guest] = [player, guest].map(|id| height(&world, id));
    println!("down at {down:.4} m, the crate at {guest:.4} m");
    assert!((down - 0.8).abs() < 0.005 && (guest - 2.8).abs() < 0.005);
    Ok(())
}
