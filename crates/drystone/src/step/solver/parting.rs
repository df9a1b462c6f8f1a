//! Deep overlaps part in the positions, after the last sweep over the velocities.
//!
//! A push by velocities adds up over all contacts of a body, and whatever else touches it answers: 20 boxes in one place flew
//! apart at 68 m/s, and what lay on the ground was thrown off it. No sweep finds all of that again. A push in the
//! positions leaves nothing behind. Shallow overlaps keep the push by velocities, which knows the load that made them.
//!
//! Reads: blocks, motion. Writes: lines (motion). Runs: over colors, over blocks with a deep point; others pay for a look at
//! one flag. What is not deep does not move by a bit, so grouping does not show.

use fearless_simd::{Simd, dispatch};

use super::Solver;
use super::plan::Group;
use super::rows::{ContactBlock, Extra, Line, Velocity, load_motion, store_motion};
use crate::base::disjoint::Rows;
use crate::base::jobs::Jobs;
use crate::base::wide::{Vec3w, load, max, splat};

/// Sweeps over the deep overlaps after a step, and the part that each takes out in a second [1/s]: a pair comes apart by half
/// in 0.06 s, and a row of bodies that overlap from its ends inward.
const SWEEPS: u32 = 4;
const RATE: f32 = 3.0;

/// What a sweep takes out of the positions.
#[derive(Clone, Copy, Debug)]
struct Parting {
    /// What may stay [m].
    deep: f32,
    /// The part of the rest that is taken out.
    part: f32,
    /// Length of the step [s].
    elapsed: f32,
}

impl Solver<'_> {
    /// Takes a part of deep overlaps out of the positions.
    pub(super) fn part(&self, group: &Group, jobs: &Jobs<'_>) {
        let (deep, dt) = (self.ctx.deep, self.ctx.dt);
        let parting = Parting { deep, part: (RATE * dt).min(0.25), elapsed: dt };
        for _ in 0..SWEEPS {
            self.plan.contacts.for_blocks(&group.contacts, jobs, 64, |batch, blocks| {
                for i in blocks.filter(|i| self.blocks.read(*i).is_deep) {
                    let block = self.blocks.read(i);
                    let extra = if self.has_extras { Some(self.extras.read(i)) } else { None };
                    dispatch!(self.ctx.level, simd => {
                        if batch.fixed {
                            part::<_, true>(simd, block, extra, &self.lines, &parting);
                        } else {
                            part::<_, false>(simd, block, extra, &self.lines, &parting);
                        }
                    });
                }
            });
        }
    }
}

/// Takes a part of what is deep out of the positions of a block's bodies, in the order of the points: what one moves, the
/// next ones know. Velocities stay as they are. What is not deep does not move by a bit.
#[inline(always)]
fn part<S: Simd, const FIXED: bool>(
    simd: S,
    block: &ContactBlock,
    extra: Option<&Extra>,
    lines: &Rows<'_, Line>,
    parting: &Parting,
) {
    let zero = splat(simd, 0.0);
    let n = Vec3w::load(simd, &block.n);
    let (beta, mut xb) = (load(simd, &block.beta), load_motion(simd, lines, &block.row_b));
    let (mut alpha, mut xa) = (zero, Velocity::zero(simd));
    if !FIXED {
        (alpha, xa) = (load(simd, &block.alpha), load_motion(simd, lines, &block.row_a));
    }
    for j in 0..usize::from(block.count.min(4)) {
        let point = &block.points[j];
        let b = Vec3w::load(simd, &point.b);
        let mut s = load(simd, &point.s0) + n.dot(xb.v) * beta + b.dot(xb.w);
        if !FIXED {
            s -= n.dot(xa.v) * alpha + Vec3w::load(simd, &point.a).dot(xa.w);
        }
        if let Some(extra) = extra
            && extra.drifts
        {
            s += load(simd, &extra.drift[j]) * splat(simd, parting.elapsed);
        }
        let excess = max(zero, -s - splat(simd, parting.deep));
        let d = load(simd, &point.mass) * excess * splat(simd, parting.part);
        xb.v = xb.v + n * (beta * d);
        xb.w = xb.w + b * d;
        if !FIXED {
            xa.v = xa.v - n * (alpha * d);
            xa.w = xa.w - Vec3w::load(simd, &point.a) * d;
        }
    }
    store_motion(simd, lines, &block.row_b, xb);
    if !FIXED {
        store_motion(simd, lines, &block.row_a, xa);
    }
}
