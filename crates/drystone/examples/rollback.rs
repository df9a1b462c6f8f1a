//! Saves, loads and replays 500 bodies, and rolls back eight frames when an input arrives late.

use drystone::{BodyDef, BodyId, DefError, ShapeDef, World};

fn scene() -> Result<(World, Vec<BodyId>), DefError> {
    let (mut world, mut ids) = (World::default(), Vec::new());
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    for i in 0..500_u16 {
        let [x, y, z] = [i % 10, i / 100, i / 10 % 10].map(f32::from);
        let at = BodyDef::dynamic().with_position([1.02 * x, 0.6 + 1.1 * y, 1.02 * z]);
        let shape = if i % 3 == 0 { ShapeDef::sphere(0.45) } else { ShapeDef::box_half([0.45; 3]) };
        ids.push(world.add_body(at.with_shape(shape.with_friction(0.4)))?);
    }
    Ok((world, ids))
}

fn play(world: &mut World, ids: &[BodyId], frames: [usize; 2], late: usize, kept: &mut [World]) {
    for frame in frames[0]..frames[1] {
        kept[frame % 8].clone_from(world); // The state before the frame.
        let body = world.body_mut(ids[frame * 13 % 500]);
        if let Some(mut body) = body.filter(|_| frame % 7 == 0 || frame == late) {
            body.apply_impulse([900.0, 2000.0, 0.0]);
        }
        world.step(1.0 / 60.0);
    }
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ((mut world, ids), mut replay, mut kept) =
        (scene()?, scene()?.0, vec![World::default(); 8]);
    play(&mut world, &ids, [0, 120], 0, &mut kept);
    let mut loaded = World::restore(&world.snapshot())?;
    play(&mut loaded, &ids, [120, 240], 0, &mut kept);
    play(&mut replay, &ids, [0, 240], 0, &mut kept);
    play(&mut world, &ids, [120, 240], 0, &mut kept);
    assert_eq!([loaded.state_hash(), replay.state_hash()], [world.state_hash(); 2]);
    for (late, same) in [(0, true), (232, false)] {
        let mut other = kept[232 % 8].clone();
        play(&mut other, &ids, [232, 240], late, &mut kept);
        println!("frames 232 to 239 again, input in frame {late}: {:016x}", other.state_hash());
        assert_eq!(other.state_hash() == world.state_hash(), same);
    }
    Ok(())
}
