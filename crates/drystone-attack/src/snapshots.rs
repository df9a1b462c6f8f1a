//! Damaged snapshots of worlds: an invalid one must be refused, and a restored one must be a valid
//! world.

use std::time::{Duration, Instant};

use drystone::World;

use crate::apply::{Ids, apply};
use crate::damage;
use crate::finding::{Findings, Kind};
use crate::generate;
use crate::op::{Op, Style};
use crate::oracle;
use crate::rng::Rng;
use crate::run::guarded;
use crate::unit::Unit;

/// Number of damaged copies of one snapshot.
const COPIES: usize = 16;

/// Number of bytes before the data that the checksum covers, and its position.
const HEADER: usize = 20;
const CHECKSUM: usize = 12;

/// Number of steps of a restored world.
const STEPS: u32 = 30;

/// Time after which a restored world is abandoned [s].
const LONGEST: Duration = Duration::from_secs(3);

/// Makes a world, and damages its snapshot in several ways.
#[must_use]
pub fn attack(seed: u64) -> Unit {
    let mut unit = Unit::default();
    let mut rng = Rng::new(seed ^ 0x0005_a4ed);
    let Ok(Some(bytes)) = guarded(|| snapshot(seed, &mut rng)) else { return unit };
    for copy in 0..COPIES {
        let (header, body) = bytes.split_at(HEADER);
        let mut body = body.to_vec();
        damage::bytes(&mut body, &mut rng);
        let mut damaged = [header, &body].concat();
        if rng.chance(0.8) {
            mend(&mut damaged);
        }
        unit.tried += 1;
        let mut findings = Findings::default();
        let caught = guarded(|| restored(&damaged, &mut findings));
        match caught {
            Ok(Some(steps)) => unit.steps += u64::from(steps),
            Ok(None) => unit.refused += 1,
            Err(panic) => findings.add(Kind::Panic, panic.place, panic.message, 0),
        }
        if !findings.all.is_empty() {
            unit.inputs.push((format!("damaged-{copy}.bin"), damaged));
        }
        for f in findings.all {
            let detail = format!("copy {copy}: {}", f.detail);
            unit.findings.add(f.kind, format!("a damaged snapshot: {}", f.what), detail, f.step);
        }
    }
    unit
}

/// A snapshot of an ordinary world after some steps.
fn snapshot(seed: u64, rng: &mut Rng) -> Option<Vec<u8>> {
    let program = generate::program_of(seed, Style::Ordinary);
    let mut world = World::new(program.config.clone()).ok()?;
    let (mut ids, mut findings) = (Ids::default(), Findings::default());
    let mut left = rng.below_u32(40);
    for op in &program.ops {
        let Op::Step(dt, count) = op else {
            let _ = apply(&mut world, &mut ids, op, &mut findings, 0);
            continue;
        };
        for _ in 0..(*count).min(left) {
            world.step(*dt);
        }
        left = left.saturating_sub(*count);
        if left == 0 {
            break;
        }
    }
    Some(world.snapshot())
}

/// Corrects the checksum.
fn mend(bytes: &mut [u8]) {
    let Some((header, body)) = bytes.split_at_mut_checked(HEADER) else { return };
    header[CHECKSUM..].copy_from_slice(&checksum(body).to_le_bytes());
}

/// The checksum of the engine's snapshots.
fn checksum(bytes: &[u8]) -> u64 {
    let mut hash = 0x9e37_79b9_7f4a_7c15_u64;
    let mut word = |w: u32| {
        hash = (hash ^ u64::from(w)).wrapping_mul(0xff51_afd7_ed55_8ccd).rotate_left(31);
    };
    let (words, rest) = bytes.as_chunks::<4>();
    words.iter().for_each(|bytes| word(u32::from_le_bytes(*bytes)));
    rest.iter().for_each(|byte| word(u32::from(*byte)));
    hash = (hash ^ (hash >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    hash ^ (hash >> 29)
}

/// Restores and steps; returns the number of steps, or `None` if it was refused.
fn restored(bytes: &[u8], findings: &mut Findings) -> Option<u32> {
    let mut world = World::restore(bytes).ok()?;
    let start = Instant::now();
    oracle::own_snapshot(&world, findings, 0);
    for step in 1..=STEPS {
        world.step(1.0 / 60.0);
        if step == STEPS {
            oracle::full(&world, findings, step);
            oracle::own_snapshot(&world, findings, step);
        } else {
            oracle::quick(&world, findings, step);
        }
        if start.elapsed() > LONGEST {
            return Some(step);
        }
    }
    Some(STEPS)
}

#[cfg(test)]
mod tests {
    use super::{HEADER, mend};
    use drystone::World;

    #[test]
    fn a_mended_checksum_is_the_engines_own() {
        let bytes = World::default().snapshot();
        let mut again = bytes.clone();
        again[12..HEADER].fill(0);
        mend(&mut again);
        assert_eq!(bytes, again);
    }
}
