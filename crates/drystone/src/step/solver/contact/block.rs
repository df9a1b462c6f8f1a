//! Solver rows of eight contacts.

use fearless_simd::{Simd, SimdBase};

use crate::base::simd::wide::{LANES, Lanes, Wide, load, splat};
use crate::step::context::StepContext;

/// Index of K_ij in [`ContactBlock::k`].
pub(crate) const K: [[usize; 4]; 4] = [[0, 1, 3, 6], [1, 2, 4, 7], [3, 4, 5, 8], [6, 7, 8, 9]];

/// Rows of one point of each contact.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct PointRows {
    pub(crate) b: [Lanes; 3],
    /// Separation at the step's start.
    pub(crate) s0: Lanes,
    /// 1/K_jj; 0 for a missing point.
    pub(crate) mass: Lanes,
    pub(crate) impulse: Lanes,
    /// Last, so that contacts with fixed bodies do not load its cache lines.
    pub(crate) a: [Lanes; 3],
}

/// Eight contacts. If only one body can be pushed, it is B, even if it is A in the contact (which
/// flips the signs of its rows and of β). Then `row_a`, `alpha` and the rows `a` are zero and never
/// read.
///
/// Lanes must not straddle cache lines. (With a single `u32` in between, the sweeps took half as
/// long again.)
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct ContactBlock {
    pub(crate) row_b: [u32; LANES],
    pub(crate) beta: Lanes,
    pub(crate) n: [Lanes; 3],
    pub(crate) mu: Lanes,
    pub(crate) t1: [Lanes; 3],
    pub(crate) t2: [Lanes; 3],
    pub(crate) b_t: [[Lanes; 3]; 3],
    /// Inverse of the 3 × 3 matrix of friction's rows (t1, t2, twist): 11, 12, 22, 13, 23, 33.
    pub(crate) mass_t: [Lanes; 6],
    /// Step size along all three rows that does not overshoot, for sliding contacts.
    pub(crate) mass_slide: Lanes,
    /// Friction along t1 and t2, and twist about n as an impulse at the reach [N s].
    pub(crate) friction: [Lanes; 3],
    pub(crate) row_a: [u32; LANES],
    pub(crate) alpha: Lanes,
    pub(crate) a_t: [[Lanes; 3]; 3],
    /// K_ij, the upper triangle by columns: 00, 01 11, 02 12 22, 03 13 23 33.
    pub(crate) k: [Lanes; 10],
    /// 1 where the contact had no impulse at the step's start: it gets more rounds.
    pub(crate) fresh: Lanes,
    pub(crate) any_fresh: bool,
    /// Some contact has fewer points than the rows that are solved for the block: 1, 2 or 4.
    pub(crate) is_mixed: bool,
    /// Maximum number of points of its contacts.
    pub(crate) count: u8,
    /// Bit for each lane that was pressed in any sweep of the step. (The last sweep does not show a
    /// landing that an earlier one stopped.)
    pub(crate) pressed: u8,
    /// Bit for each lane that overlaps more than its load explains: see `contact/part.rs`.
    pub(crate) parting: u8,
    /// Bit for each lane that may bounce or get an impact in this step, and for each that did.
    pub(crate) arrives: u8,
    pub(crate) hit: u8,
    /// Its rows are rebuilt in each substep.
    pub(crate) is_renewed: bool,
    /// Points of each lane that may land in this step: see
    /// [`Watch`](crate::step::solver::totals_rows::Watch).
    pub(crate) landing: [u8; LANES],
    /// Last, so that contacts with fewer points load fewer cache lines.
    pub(crate) points: [PointRows; 4],
}

impl ContactBlock {
    /// Rows that the kernel solves: 4 for contacts of three points.
    pub(crate) const fn rows(&self) -> usize {
        match self.count {
            0 | 1 => 1,
            2 => 2,
            _ => 4,
        }
    }

    /// Cache lines of a block that a sweep reads, for contacts of up to `points` points.
    #[inline(always)]
    pub(crate) const fn cache_lines(points: usize) -> usize {
        (core::mem::offset_of!(Self, points) + points * size_of::<PointRows>()).div_ceil(64)
    }
}

/// Data that only some contacts need, beside their block: restitution, rolling resistance, moving
/// partners.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Extra {
    pub(crate) bounces: bool,
    pub(crate) rolls: bool,
    pub(crate) drifts: bool,
    /// Kinetic friction is lower than static friction.
    pub(crate) slips: bool,
    /// Some contacts have a spring softness of their own.
    pub(crate) softens: bool,
    /// Coefficient of restitution; 0: no bounce.
    pub(crate) restitution: Lanes,
    /// Relative acceleration along the normal [m/s²].
    pub(crate) fall: Lanes,
    /// Speed along the normal that forces alone give one of the bodies in a step [m/s].
    pub(crate) slow: Lanes,
    /// Normal speed of the points that kinematic bodies cause, and the speed along friction's rows.
    pub(crate) drift: [Lanes; 4],
    pub(crate) drift_t: [Lanes; 3],
    /// Rate of change of the tangential drift [m/s²].
    pub(crate) drift_rate: [Lanes; 2],
    /// Kinetic friction as a fraction of static friction.
    pub(crate) kinetic: Lanes,
    /// [`Softness`](crate::step::context::softness::Softness) of contacts with their own; the mass
    /// of others is 0.
    pub(crate) soft_rate: Lanes,
    pub(crate) soft_mass: Lanes,
    pub(crate) soft_impulse: Lanes,
    /// S of both bodies, for rolling.
    pub(crate) s_a: [Lanes; 6],
    pub(crate) s_b: [Lanes; 6],
    /// Limit of the rolling impulse per normal impulse [m].
    pub(crate) rolling: Lanes,
    pub(crate) rolling_impulse: [Lanes; 3],
}

impl Extra {
    /// Adds the rate of change of the tangential velocity [m/s²] between bodies that rotate
    /// together. The rows are those of the middle of the step, and a sweep solves the velocity of
    /// the substep after it, at that substep's middle.
    #[inline(always)]
    pub(crate) fn corotate<S: Simd>(&mut self, simd: S, rate: &[Wide<S>; 2], ctx: &StepContext) {
        self.drifts = true;
        let from = splat(simd, 0.5 * (ctx.h - ctx.dt));
        for i in 0..2 {
            let velocity = load(simd, &self.drift_t[i]) + rate[i] * from;
            velocity.store_array(&mut self.drift_t[i]);
            let rate = load(simd, &self.drift_rate[i]) + rate[i];
            rate.store_array(&mut self.drift_rate[i]);
        }
    }

    /// Squared frequency of a lane with its own spring softness [rad²/s²], in substeps of this rate
    /// [1/s].
    pub(crate) fn spring(&self, lane: usize, inv_h: f32) -> Option<f64> {
        let is_soft = self.softens && self.soft_mass[lane] > 0.0;
        is_soft.then(|| f64::from(self.soft_rate[lane] / self.soft_impulse[lane] * inv_h))
    }
}
