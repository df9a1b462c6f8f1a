//! DOC

use crate::base::simd::wide::{LANES, Lanes};

/// Eight joints, balls or distances. As in [`ContactBlock`], lanes do not straddle cache lines.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct JointBlock {
    pub(crate) row_a: [u32; LANES],
    pub(crate) row_b: [u32; LANES],
    pub(crate) alpha: Lanes,
    pub(crate) beta: Lanes,
    /// Of balls the one number of S of each body, if the inertia of all of them is the same about every axis, and nothing in
    /// [`JointRest::s_a`] and `s_b` then; else the first is below 0.
    pub(crate) round: [Lanes; 2],
    /// Arms at the step's start.
    pub(crate) r_a: [Lanes; 3],
    pub(crate) r_b: [Lanes; 3],
    /// Anchor B less anchor A at the step's start.
    pub(crate) gap: [Lanes; 3],
    pub(crate) impulse: [Lanes; 3],
    /// The part of the warm start that the bodies carry, as it was applied: r × p of each body.
    pub(crate) carried_a: [Lanes; 3],
    pub(crate) carried_b: [Lanes; 3],
}

/// What only some blocks of joints need, beside them: so that the others lie closer together.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct JointRest {
    pub(crate) s_a: [Lanes; 6],
    pub(crate) s_b: [Lanes; 6],
    /// Velocity of the gap that comes from kinematic bodies, where one of the bodies cannot be pushed.
    pub(crate) drift: [Lanes; 3],
    /// Distances: the linear part of the warm start; of balls it is their impulse.
    pub(crate) carried: [Lanes; 3],
    /// Distances: least, greatest, rest length; spring rate, mass, impulse (all 0: no spring).
    pub(crate) limits: [Lanes; 3],
    pub(crate) spring: [Lanes; 3],
}

impl JointBlock {
    /// It is one of balls, and the inertia of all its bodies is the same about every axis.
    pub(crate) fn is_round(&self) -> bool {
        self.round[0][0] >= 0.0
    }
}
