//! A world that adds and removes the same number of objects repeatedly; its memory must not grow.

use std::time::{Duration, Instant};

use drystone::particle::ParticleId;
use drystone::{BodyId, World};

use crate::apply::{Ids, apply};
use crate::finding::{Findings, Kind};
use crate::generate;
use crate::op::{Op, Style};
use crate::oracle;
use crate::process::resident_bytes;
use crate::run::guarded;
use crate::unit::Unit;

/// Duration of one unit.
const LONG: Duration = Duration::from_secs(6);

/// The same program fills the world in each round; memory must be stable after this number of
/// rounds.
const WARM: u32 = 20;

/// Allowed growth of the process after that [bytes]: the system's allocator is not exact.
const SLACK: u64 = 6 << 20;

/// Fills and empties one world repeatedly.
#[must_use]
pub fn attack(seed: u64) -> Unit {
    let mut unit = Unit { tried: 1, ..Unit::default() };
    let mut findings = Findings::default();
    let mut steps = 0;
    if let Err(panic) = guarded(|| soak(seed, &mut findings, &mut steps)) {
        findings.add(Kind::Panic, panic.place, panic.message, 0);
    }
    unit.findings = findings;
    unit.steps = steps;
    unit
}

fn soak(seed: u64, findings: &mut Findings, steps: &mut u64) {
    let program = generate::program_of(seed, Style::Ordinary);
    let Ok(mut world) = World::new(program.config.clone()) else { return };
    let start = Instant::now();
    let (mut round, mut length, mut resident) = (0_u32, 0, 0);
    while start.elapsed() < LONG {
        let mut ids = Ids::default();
        let mut left = 60;
        for op in &program.ops {
            let Op::Step(dt, count) = op else {
                let _ = apply(&mut world, &mut ids, op, findings, round);
                continue;
            };
            for _ in 0..(*count).min(left) {
                world.step(*dt);
                ids.take_pieces(&world);
                *steps += 1;
            }
            left = left.saturating_sub(*count);
        }
        oracle::quick(&world, findings, round);
        clear(&mut world);
        ids.gone.check(&world, findings, round);
        if world.set_config(program.config.clone()).is_err() {
            return;
        }
        world.step(1.0 / 60.0);
        round += 1;
        if round == WARM {
            (length, resident) = (world.snapshot().len(), resident_bytes("self"));
        }
    }
    if round <= WARM {
        return;
    }
    let (length_now, resident_now) = (world.snapshot().len(), resident_bytes("self"));
    // Slots store their generation, a number of up to five bytes.
    if length_now > 2 * length + 1024 {
        let detail = format!("{length} bytes after {WARM} rounds, {length_now} after {round}");
        findings.add(Kind::Growth, "the snapshot of an emptied world grows", detail, round);
    }
    if resident > 0 && resident_now > resident + SLACK {
        let detail = format!("{resident} bytes after {WARM} rounds, {resident_now} after {round}");
        findings.add(Kind::Growth, "the process grows", detail, round);
    }
}

/// Removes everything from a world.
fn clear(world: &mut World) {
    let bodies: Vec<BodyId> = world.bodies().map(|b| b.id()).collect();
    for id in bodies {
        world.remove_body(id);
    }
    let particles: Vec<ParticleId> = world.particles().map(|p| p.id()).collect();
    for id in particles {
        world.remove_particle(id);
    }
}
