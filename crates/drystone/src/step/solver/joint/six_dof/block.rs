//! Solver rows of eight six-axis joints.

use fearless_simd::Simd;

use super::drive::Push;
use crate::base::simd::wide::{LANES, Lanes, Wide, load};

/// Drive, friction and limit of an axis.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Axis {
    pub(crate) drive: Push,
    /// Maximum impulse of the drive; 0: none.
    pub(crate) maximum: Lanes,
    /// Maximum impulse of friction; 0: none.
    pub(crate) friction: Lanes,
    pub(crate) limit: Push,
    /// 1 where the limit is as stiff as the joint.
    pub(crate) hard: Lanes,
    pub(crate) low: Lanes,
    pub(crate) high: Lanes,
    /// Some joint of the eight has a drive, a limit, or a sprung limit on the axis.
    pub(crate) drives: bool,
    pub(crate) limits: bool,
    pub(crate) yields: bool,
    /// Some joint has a drive, friction or a limit on the axis.
    pub(crate) acts: bool,
}

/// Eight six-axis joints.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct SixDofBlock {
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
    /// Velocities of kinematic bodies: B's less A's, and angular velocities.
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
    /// 1 where an axis is locked, and its locked coordinate.
    pub(crate) locked: [Lanes; 6],
    pub(crate) place: [Lanes; 6],
    /// Impulse of lock or drive, of friction, and of the limit.
    pub(crate) lock_or_drive: [Lanes; 6],
    pub(crate) friction: [Lanes; 6],
    pub(crate) limit: [Lanes; 6],
    /// The part of the warm start that the bodies carry: linear, and the moments on A and B.
    pub(crate) carried: [Lanes; 3],
    pub(crate) carried_a: [Lanes; 3],
    pub(crate) carried_b: [Lanes; 3],
    /// Impulse about B's anchor.
    pub(crate) torque: [Lanes; 3],
    /// Some translation is locked, and some rotation.
    pub(crate) locks: [bool; 2],
    /// A drive, friction or limit acts on some translation, and on some rotation.
    pub(crate) acts: [bool; 2],
    /// Some axis has a drive or a sprung limit, which need the velocities at the start of the
    /// substep.
    pub(crate) springs: bool,
    /// A tree solves the whole joint: see `tree/six_dof.rs`.
    pub(crate) is_direct: bool,
    /// All translations are locked at a gap of zero: see kernel_anchored.rs.
    pub(crate) is_anchored: bool,
    pub(crate) axes: [Axis; 6],
}

impl SixDofBlock {
    /// True if a drive, friction or limit acts on the axis in one of the joints. (The data of an
    /// axis is filled only if something acts on a translation, or on a rotation.)
    #[inline(always)]
    pub(crate) fn acts_on(&self, axis: usize) -> bool {
        self.acts[axis / 3] && self.axes[axis].acts
    }

    /// Total impulse on an axis.
    #[inline(always)]
    pub(crate) fn pushes<S: Simd>(&self, simd: S, axis: usize) -> Wide<S> {
        load(simd, &self.lock_or_drive[axis])
            + load(simd, &self.friction[axis])
            + load(simd, &self.limit[axis])
    }
}
