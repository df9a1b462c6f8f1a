//! Solver rows of eight ball or distance joints.

use crate::base::simd::wide::{LANES, Lanes};

/// Eight joints, all balls or all distances. As in [`ContactBlock`], lanes do not straddle cache
/// lines.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct JointBlock {
    pub(crate) row_a: [u32; LANES],
    pub(crate) row_b: [u32; LANES],
    pub(crate) alpha: Lanes,
    pub(crate) beta: Lanes,
    /// Ball joints: the scalar S of each body, if the inertia of all bodies in the block is the
    /// same about every axis. [`JointExtra::s_a`] and `s_b` are unused then. Otherwise the first
    /// value is negative.
    pub(crate) round: [Lanes; 2],
    /// Lever arms at the step's start.
    pub(crate) r_a: [Lanes; 3],
    pub(crate) r_b: [Lanes; 3],
    /// Anchor B less anchor A at the step's start.
    pub(crate) gap: [Lanes; 3],
    pub(crate) impulse: [Lanes; 3],
    /// The part of the warm start that the bodies carry, as it was applied: r × p of each body.
    pub(crate) carried_a: [Lanes; 3],
    pub(crate) carried_b: [Lanes; 3],
}

/// Data that only some blocks need, kept apart so that the others are closer together in memory.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct JointExtra {
    pub(crate) s_a: [Lanes; 6],
    pub(crate) s_b: [Lanes; 6],
    /// Velocity of the gap that kinematic bodies cause, where one of the bodies cannot be pushed.
    pub(crate) drift: [Lanes; 3],
    /// Distances: the linear part of the warm start. (For ball joints it is their impulse.)
    pub(crate) carried: [Lanes; 3],
    /// Distances: minimum, maximum and rest length; spring rate, mass, impulse (all 0: no spring).
    pub(crate) limits: [Lanes; 3],
    pub(crate) spring: [Lanes; 3],
}

impl JointBlock {
    /// True if the lane has rows: a joint that is no pendulum.
    pub(crate) const fn is_solved(&self, lane: usize) -> bool {
        self.row_a[lane] != 0 || self.row_b[lane] != 0
    }

    /// True if no lane has rows.
    pub(crate) fn is_empty(&self) -> bool {
        self.row_a == [0; LANES] && self.row_b == [0; LANES]
    }

    /// True for a block of ball joints whose bodies all have the same inertia about every axis.
    pub(crate) fn is_round(&self) -> bool {
        self.round[0][0] >= 0.0
    }
}
