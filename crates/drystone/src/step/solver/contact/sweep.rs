//! Parameters of a sweep over contacts.

use crate::step::context::softness::Softness;

/// Parameters of one sweep over contacts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactSweep {
    pub(crate) inv_h: f32,
    pub(crate) softness: Softness,
    /// The sweep removes the velocity that the push-out added.
    pub(crate) relaxes: bool,
    /// Maximum net speed of push-out [m/s].
    pub(crate) cap: f32,
    /// Approach speed above which a point is hit [m/s]: see [`HIT_SPEED`].
    pub(crate) hit: f32,
    /// Rounds over the points of a manifold.
    pub(crate) inner: u32,
    /// Time of the step that positions have advanced [s].
    pub(crate) elapsed: f32,
}

/// Part of a deep overlap that may be pushed out in a second [1/s]. The speed limit grows with the
/// depth, so bodies that an impact pressed together separate in half a second. Equilibrium does not
/// reach the limit.
pub(crate) const DEEP_RATE: f32 = 6.0;

pub(crate) const HIT_SPEED: f32 = 0.2;
