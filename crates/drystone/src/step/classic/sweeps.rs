//! Sweeps without accumulated impulses: each visit of a point solves its present error.
//!
//! Bounces, stops, shock propagation and push-out follow [Guendelman03].

use super::accumulate::rub;
use super::rows::{Mover, Pair, PairPoint};
use super::sequence::Sequence;
use crate::base::collision::collide;
use crate::base::math::Vec3;

/// Rounds over the points of a pair in one visit of a stop.
const PAIR_ROUNDS: u32 = 4;

/// Rounds over the pairs of a level before the next level, in stops and in push-out.
const LEVEL_ROUNDS: u32 = 2;

/// Rounds over the points of a pair in shock propagation and in push-out.
const SHOCK_ROUNDS: u32 = 10;

const PUSH_ROUNDS: u32 = 5;

/// Bounces the points that approach and would overlap at the end of a substep of `h`, one by one,
/// until none is left or after `maximum` sweeps. `before_forces`: future positions include the
/// velocity that forces will add; the bounce uses the current velocity. Returns the number of
/// sweeps.
pub(crate) fn bounce(
    sequence: &Sequence,
    maximum: u32,
    h: f32,
    before_forces: bool,
    movers: &mut [Mover],
    pairs: &mut [Pair],
) -> u32 {
    for sweep in 0..maximum {
        let mut any = false;
        for row in &sequence.pairs {
            let pair = &mut pairs[*row as usize];
            for i in 0..pair.points().len() {
                let p = pair.points[i];
                let u = pair.slip(&p, movers);
                let s = pair.separation(&p, movers);
                let (a, b) = (&movers[pair.a as usize], &movers[pair.b as usize]);
                let forces = if before_forces { b.add_v - a.add_v } else { Vec3::ZERO };
                let s = s + h * pair.normal.dot(u + forces);
                if s < 0.0 && u.dot(pair.normal) < 0.0 {
                    let e = pair.restitution;
                    strike(pair, i, u, e, movers);
                    any = true;
                }
            }
        }
        if !any {
            return sweep;
        }
    }
    maximum
}

/// Applies the collision rule's impulse for the relative velocity `u` at a point.
fn strike(pair: &mut Pair, i: usize, u: Vec3, restitution: f32, movers: &mut [Mover]) {
    let p = pair.points[i];
    let k = pair.matrix(&p, movers);
    let (j, _) = collide(&k, pair.normal, u, restitution, pair.friction);
    pair.push(&p, j, movers);
    let press = j.dot(pair.normal);
    let q = &mut pair.points[i];
    q.press += press;
    q.rub += j - pair.normal * press;
    pair.pressed = true;
    pair.resist_rolling(press, movers);
}

/// Stops contacts that would overlap at the end of the substep, in `sweeps` sweeps from the ground
/// up, with restitutions of -1 + k/sweeps. Returns the number of sweeps.
pub(crate) fn stop(
    sequence: &Sequence,
    sweeps: u32,
    h: f32,
    movers: &mut [Mover],
    pairs: &mut [Pair],
    mut between: impl FnMut(&mut [Mover]),
) -> u32 {
    for k in 1..=sweeps {
        #[expect(clippy::cast_precision_loss, reason = "at most 100,000")]
        let restitution = -1.0 + k as f32 / sweeps as f32;
        between(movers);
        for level in sequence.levels() {
            for _ in 0..LEVEL_ROUNDS {
                for row in level {
                    stop_pair(&mut pairs[*row as usize], PAIR_ROUNDS, restitution, h, movers);
                }
            }
        }
    }
    sweeps * LEVEL_ROUNDS
}

/// Shock propagation: one more sweep from the ground up, in which the bodies below a level cannot
/// be pushed.
pub(crate) fn shock(sequence: &Sequence, h: f32, movers: &mut [Mover], pairs: &mut [Pair]) -> u32 {
    for level in sequence.levels() {
        for _ in 0..LEVEL_ROUNDS {
            for row in level {
                stop_pair(&mut pairs[*row as usize], SHOCK_ROUNDS, 0.0, h, movers);
            }
        }
        freeze(level, movers, pairs);
    }
    thaw(movers);
    LEVEL_ROUNDS
}

fn freeze(level: &[u32], movers: &mut [Mover], pairs: &[Pair]) {
    for row in level {
        let pair = &pairs[*row as usize];
        for body in [pair.a, pair.b] {
            let mover = &mut movers[body as usize];
            mover.frozen |= mover.level <= pair.level;
        }
    }
}

fn thaw(movers: &mut [Mover]) {
    for mover in movers {
        mover.frozen = false;
    }
}

/// Stops the points of a pair that would overlap, as one problem. The impulses of this visit are
/// clamped as sums, because separate impulses at four corners leave the pair separating (20 cubes:
/// 0.05 m/s upward after a step). A stopped body stays above the surface by up to the displacement
/// of a substep. If it closed the gap first, it would arrive with that velocity and bounce.
fn stop_pair(pair: &mut Pair, rounds: u32, restitution: f32, h: f32, movers: &mut [Mover]) {
    let n = pair.normal;
    let count = pair.points().len();
    let meets = |pair: &Pair, p: &PairPoint, movers: &[Mover]| {
        let u = pair.slip(p, movers).dot(n);
        u < 0.0 && pair.separation(p, movers) + h * u < 0.0
    };
    if !pair.points().iter().any(|p| meets(pair, p, movers)) {
        return;
    }
    let mut visit = pair.points;
    let mut targets = [0.0; 4];
    for (p, target) in visit.iter_mut().zip(&mut targets) {
        (p.press, p.rub) = (0.0, Vec3::ZERO);
        *target = -restitution * pair.slip(p, movers).dot(n).min(0.0);
    }
    for _ in 0..rounds {
        for (p, target) in visit[..count].iter_mut().zip(targets) {
            let response = n.dot(pair.matrix(p, movers).mul(n));
            if !(response > 0.0) || (p.press <= 0.0 && !meets(pair, p, movers)) {
                continue;
            }
            let u = pair.slip(p, movers).dot(n);
            let next = (p.press + (target - u) / response).max(0.0);
            let j = next - p.press;
            p.press = next;
            pair.push(p, n * j, movers);
        }
        for p in &mut visit[..count] {
            rub(pair, p, movers);
        }
    }
    let mut total = 0.0;
    for (p, of_visit) in pair.points.iter_mut().zip(&visit[..count]) {
        p.press += of_visit.press;
        p.rub += of_visit.rub;
        total += of_visit.press;
    }
    pair.pressed = true;
    pair.resist_rolling(total, movers);
}

/// Separates overlapping bodies from the ground up, with the bodies below fixed, in two gradual
/// rounds. Velocities do not change.
pub(crate) fn push_out(sequence: &Sequence, movers: &mut [Mover], pairs: &[Pair]) {
    for part in [0.5, 1.0] {
        for level in sequence.levels() {
            for row in level {
                let pair = &pairs[*row as usize];
                for _ in 0..PUSH_ROUNDS {
                    let mut deepest: (f32, Option<&PairPoint>) = (0.0, None);
                    for p in pair.points() {
                        let s = pair.separation(p, movers);
                        if s < deepest.0 {
                            deepest = (s, Some(p));
                        }
                    }
                    let (s, Some(p)) = deepest else { break };
                    let response = pair.normal.dot(pair.matrix(p, movers).mul(pair.normal));
                    if !(response > 0.0) {
                        break;
                    }
                    pair.shift(p, pair.normal * (-part * s / response), movers);
                }
            }
            freeze(level, movers, pairs);
        }
        thaw(movers);
    }
}
