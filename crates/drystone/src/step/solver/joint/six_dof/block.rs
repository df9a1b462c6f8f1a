//! Rows of eight joints of six axes.

use fearless_simd::Simd;

use super::drive::Push;
use crate::base::simd::wide::{LANES, Lanes, Wide, load};

/// Drive, friction and limit of an axis.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Axis {
    pub(crate) drive: Push,
    /// Greatest impulse of the drive; 0: none.
    pub(crate) most: Lanes,
    /// Greatest impulse of friction; 0: none.
    pub(crate) friction: Lanes,
    pub(crate) limit: Push,
    /// 1 where the limit is as hard as the joint.
    pub(crate) hard: Lanes,
    pub(crate) low: Lanes,
    pub(crate) high: Lanes,
    /// Whether some of the eight have any of it: a drive, a limit, a limit that is a spring.
    pub(crate) drives: bool,
    pub(crate) limits: bool,
    pub(crate) yields: bool,
    /// Or anything at all that acts on the axis.
    pub(crate) acts: bool,
}

/// Eight joints of six axes.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct SixBlock {
    pub(crate) row_a: [u32; LANES],
    pub(crate) row_b: [u32; LANES],
    pub(crate) alpha: Lanes,
    pub(crate) beta: Lanes,
    pub(crate) s_a: [Lanes; 6],
    pub(crate) s_b: [Lanes; 6],
    pub(crate) r_a: [Lanes; 3],
    pub(crate) r_b: [Lanes; 3],
    /// Anchor B less anchor A at the step's start.
    pub(crate) gap: [Lanes; 3],
    /// Velocities of kinematic bodies: B's less A's, and angular ones.
    pub(crate) drift: [Lanes; 3],
    pub(crate) spin_a: [Lanes; 3],
    pub(crate) spin_b: [Lanes; 3],
    /// u and n at the step's start.
    pub(crate) u: [[Lanes; 3]; 3],
    pub(crate) n: [[Lanes; 3]; 3],
    /// Angles at the step's start.
    pub(crate) angles: [Lanes; 3],
    /// Direction of the swing at the step's start where there is a cone: along y, and along z.
    pub(crate) swing: [Lanes; 2],
    /// 1 where an axis is locked, and the place where it is.
    pub(crate) locked: [Lanes; 6],
    pub(crate) place: [Lanes; 6],
    /// Impulse of lock or drive, of friction, and of the limit.
    pub(crate) held: [Lanes; 6],
    pub(crate) friction: [Lanes; 6],
    pub(crate) limit: [Lanes; 6],
    /// What the bodies carry of the warm start: linear; the moments on A and B.
    pub(crate) carried: [Lanes; 3],
    pub(crate) carried_a: [Lanes; 3],
    pub(crate) carried_b: [Lanes; 3],
    /// Impulse about B's anchor.
    pub(crate) torque: [Lanes; 3],
    /// Some axis of motion is locked, and some turn.
    pub(crate) holds: [bool; 2],
    /// Something acts on some axis of motion, and on some turn.
    pub(crate) acts: [bool; 2],
    /// Some axis is driven, or has a limit that is a spring: they ask how fast the bodies were when the substep began.
    pub(crate) springs: bool,
    /// A tree solves all there is: see tree_six.rs.
    pub(crate) is_direct: bool,
    /// All motions are locked, and what is to be of the gap is none: see pinned.rs.
    pub(crate) is_anchored: bool,
    pub(crate) axes: [Axis; 6],
}

impl SixBlock {
    /// True if something acts on an axis of one of the joints. (What is known of an axis is not filled in where
    /// nothing acts on any motion, or on any turn.)
    #[inline(always)]
    pub(crate) fn acts_on(&self, axis: usize) -> bool {
        self.acts[axis / 3] && self.axes[axis].acts
    }

    /// Impulse of all that acts on an axis.
    #[inline(always)]
    pub(crate) fn pushes<S: Simd>(&self, simd: S, axis: usize) -> Wide<S> {
        load(simd, &self.held[axis])
            + load(simd, &self.friction[axis])
            + load(simd, &self.limit[axis])
    }
}
