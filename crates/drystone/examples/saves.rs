//! The cost of saving a state and of going back to it: a pyramid of 820 boxes at rest, on one
//! thread.
//!
//! `cargo run --release --example saves`

use std::time::Instant;

use drystone::snapshot::{apply_delta, write_delta};
use drystone::{BodyDef, DefError, ShapeDef, World};

const DT: f32 = 1.0 / 60.0;
/// Maximum number of frames that a two-player network game rolls back, as in GGRS.
const FRAMES: usize = 8;

fn pyramid(base: u16) -> Result<World, DefError> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    for row in 0..base {
        for k in 0..base - row {
            let x = f32::from(k) + 0.5 * f32::from(row);
            let at = BodyDef::dynamic().with_position([x, 0.5 + f32::from(row), 0.0]);
            let at = BodyDef { can_sleep: false, ..at };
            world.add_body(at.with_shape(ShapeDef::box_half([0.5; 3])))?;
        }
    }
    Ok(world)
}

/// Duration of a call [ms]: the minimum of many, because other load only adds to it.
fn time(mut call: impl FnMut()) -> f64 {
    let mut least = f64::INFINITY;
    for _ in 0..60 {
        let start = Instant::now();
        call();
        least = least.min(start.elapsed().as_secs_f64() * 1000.0);
    }
    least
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = pyramid(40)?;
    for _ in 0..120 {
        world.step(DT);
    }
    let mut saves = vec![world.clone(); FRAMES];
    let mut next = 0;
    let clone_from = time(|| {
        saves[next % FRAMES].clone_from(&world);
        next += 1;
    });
    let (mut bytes, mut base, mut delta, mut whole) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let snapshot = time(|| world.snapshot_into(&mut bytes));
    let mut refused = Ok(());
    let restore = time(|| refused = saves[0].restore_from(&bytes));
    refused?;
    base.clone_from(&bytes);
    world.step(DT);
    world.snapshot_into(&mut bytes);
    let write = time(|| write_delta(&base, &bytes, &mut delta));
    let mut refused = Ok(());
    let apply = time(|| refused = apply_delta(&base, &delta, &mut whole));
    refused?;
    let counts = world.counts();
    println!("{} boxes, {} contacts, {} bytes", counts.dynamic, counts.contacts, bytes.len());
    println!(
        "clone_from {clone_from:.3} ms, snapshot_into {snapshot:.3} ms, restore_from {restore:.3} ms"
    );
    println!(
        "a delta of a step: {} bytes, written in {write:.3} ms, applied in {apply:.3} ms",
        delta.len()
    );

    // Returns to the first state and replays to the last: the frames alone, and with a save per
    // frame.
    let start = world.clone();
    let alone = time(|| {
        world.clone_from(&start);
        (0..FRAMES).for_each(|_| world.step(DT));
    });
    let hash = world.state_hash();
    let kept = time(|| {
        world.clone_from(&start);
        for save in &mut saves {
            save.clone_from(&world);
            world.step(DT);
        }
    });
    assert_eq!(world.state_hash(), hash);
    let on = time(|| (0..FRAMES).for_each(|_| world.step(DT)));
    println!(
        "{FRAMES} steps {on:.3} ms; back and {FRAMES} steps {alone:.3} ms; and with a save of each {kept:.3} ms"
    );
    println!("{:.2} times the steps alone", kept / on);
    Ok(())
}
