//! Parameters of a sweep over contacts.

use crate::step::context::softness::Softness;

/// What one sweep over contacts does.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactSweep {
    pub(crate) inv_h: f32,
    pub(crate) softness: Softness,
    /// It takes out the velocity that the push put in.
    pub(crate) relaxes: bool,
    /// Greatest net speed of push-out [m/s].
    pub(crate) cap: f32,
    /// A point that approaches faster is hit [m/s]: see [`HIT_SPEED`].
    pub(crate) hit: f32,
    /// Rounds over the points of a manifold.
    pub(crate) inner: u32,
    /// Time of the step that positions have advanced [s].
    pub(crate) elapsed: f32,
}

/// The part of a deep overlap that may be pushed out in a second [1/s]: the cap on the speed grows with
/// the depth, so that what an impact squeezed together comes apart in half a second. At rest the cap is not
/// reached.
pub(crate) const DEEP_RATE: f32 = 6.0;

pub(crate) const HIT_SPEED: f32 = 0.2;
