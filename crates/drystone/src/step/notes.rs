//! Findings of `finalize` about bodies.

use crate::base::math::Vec3;
use crate::base::quat::Quat;

/// What finalize found out about a body, beside how it moved.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Note {
    /// The body's state became non-finite; it was put back.
    Fault(u32),
    /// A kinematic body that does not move.
    Idle(u32),
    /// Some body has been still for long enough to sleep.
    Still,
}

/// How a body moved that moved or turned far for its size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flight {
    pub(crate) row: u32,
    /// Where its center was, and how it stood.
    pub(crate) from: Vec3,
    pub(crate) stood: Quat,
    /// No shape left the box that it had in the tree: with all that they may have met they are pairs. (Of bodies that move,
    /// only if it did not [fly](Body::flies): those that it was to pass are none.)
    pub(crate) in_boxes: bool,
    pub(crate) flew: bool,
}
