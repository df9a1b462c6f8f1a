//! Findings of the stage `finalize` about bodies, for later stages.

use crate::base::math::Vec3;
use crate::base::quat::Quat;

/// A finding about a body, beside its motion.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Note {
    /// The body's state became non-finite; it was put back.
    Fault(u32),
    /// A kinematic body does not move.
    Idle(u32),
    /// Some body has been still for long enough to sleep.
    Still,
}

/// Motion of a body that moved or turned far for its size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flight {
    pub(crate) row: u32,
    /// Center and rotation at the start of the step.
    pub(crate) from: Vec3,
    pub(crate) stood: Quat,
    /// No shape left its box in the tree, so pairs exist with everything that the shapes may have
    /// met. (For moving bodies this holds only if the body did not [fly](Body::flies): the
    /// broadphase drops pairs that it will pass.)
    pub(crate) in_boxes: bool,
    pub(crate) flew: bool,
}
