//! A rigid transform.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::math::Vec3;
use super::quat::Quat;

/// A rotation followed by a translation.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C)]
pub struct Pose {
    /// Translation [m].
    pub position: Vec3,
    /// Rotation.
    pub rotation: Quat,
}

impl Pose {
    /// No motion.
    pub const IDENTITY: Self = Self { position: Vec3::ZERO, rotation: Quat::IDENTITY };

    /// The transform that rotates by `rotation` and then moves by `position` [m].
    #[must_use]
    pub fn new(position: impl Into<Vec3>, rotation: impl Into<Quat>) -> Self {
        Self { position: position.into(), rotation: rotation.into() }
    }

    /// A pure translation [m].
    #[must_use]
    pub fn at(position: impl Into<Vec3>) -> Self {
        Self::new(position, Quat::IDENTITY)
    }

    /// A local point in the outer frame.
    #[must_use]
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.rotation.rotate(p) + self.position
    }

    /// A local direction in the outer frame.
    #[must_use]
    #[inline]
    pub fn direction(&self, v: Vec3) -> Vec3 {
        self.rotation.rotate(v)
    }

    /// An outer point in the local frame.
    #[must_use]
    #[inline]
    pub fn local_point(&self, p: Vec3) -> Vec3 {
        self.rotation.unrotate(p - self.position)
    }

    /// An outer direction in the local frame.
    #[must_use]
    #[inline]
    pub fn local_direction(&self, v: Vec3) -> Vec3 {
        self.rotation.unrotate(v)
    }

    /// `inner`, which is given in this frame, in the outer frame.
    #[must_use]
    #[inline]
    pub fn compose(&self, inner: &Self) -> Self {
        Self { position: self.point(inner.position), rotation: self.rotation * inner.rotation }
    }

    /// `other` as seen from this frame.
    #[must_use]
    #[inline]
    pub fn relative(&self, other: &Self) -> Self {
        Self {
            position: self.local_point(other.position),
            rotation: self.rotation.conjugate() * other.rotation,
        }
    }

    /// The opposite transform.
    #[must_use]
    #[inline]
    pub fn inverse(&self) -> Self {
        Self {
            position: self.rotation.unrotate(-self.position),
            rotation: self.rotation.conjugate(),
        }
    }

    /// The pose that is this part of the way from here to `other`, 0 to 1: places on a line, rotations the shorter way round.
    #[must_use]
    pub fn lerp(&self, other: &Self, part: f32) -> Self {
        let position = self.position + (other.position - self.position) * part;
        Self { position, rotation: self.rotation.nlerp(other.rotation, part) }
    }

    /// True if no number is infinite or NaN.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.position.is_finite() && self.rotation.is_finite()
    }
}
