//! Rays against one solid.

use super::solid::Solid;
use crate::base::math::Vec3;

/// Where a ray meets a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayHit {
    /// Part of the ray's length, 0 to 1.
    pub(crate) fraction: f32,
    /// Outward normal there [frame of the solid].
    pub(crate) normal: Vec3,
}

/// The first point of `origin + t delta`, 0 <= t <= `max_fraction`, on the surface of the solid (both
/// in its frame). A ray that starts inside a convex solid does not hit it.
pub(crate) fn ray(solid: &Solid, origin: Vec3, delta: Vec3, max_fraction: f32) -> Option<RayHit> {
    let _ = (solid, origin, delta, max_fraction);
    None
}
