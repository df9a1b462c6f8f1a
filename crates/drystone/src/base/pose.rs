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
    /// The identity transform.
    pub const IDENTITY: Self = Self { position: Vec3::ZERO, rotation: Quat::IDENTITY };

    /// The transform that rotates by `rotation` and then translates by `position` [m].
    #[must_use]
    pub fn new(position: impl Into<Vec3>, rotation: impl Into<Quat>) -> Self {
        Self { position: position.into(), rotation: rotation.into() }
    }

    /// A pure translation [m].
    #[must_use]
    pub fn at(position: impl Into<Vec3>) -> Self {
        Self::new(position, Quat::IDENTITY)
    }

    /// Converts a local point to the outer frame.
    #[must_use]
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.rotation.rotate(p) + self.position
    }

    /// Converts a local direction to the outer frame.
    #[must_use]
    #[inline]
    pub fn direction(&self, v: Vec3) -> Vec3 {
        self.rotation.rotate(v)
    }

    /// Converts an outer point to the local frame.
    #[must_use]
    #[inline]
    pub fn local_point(&self, p: Vec3) -> Vec3 {
        self.rotation.unrotate(p - self.position)
    }

    /// Converts an outer direction to the local frame.
    #[must_use]
    #[inline]
    pub fn local_direction(&self, v: Vec3) -> Vec3 {
        self.rotation.unrotate(v)
    }

    /// Converts `inner`, a pose in this frame, to the outer frame.
    #[must_use]
    #[inline]
    pub fn compose(&self, inner: &Self) -> Self {
        Self { position: self.point(inner.position), rotation: self.rotation * inner.rotation }
    }

    /// Returns `other` relative to this frame.
    #[must_use]
    #[inline]
    pub fn relative(&self, other: &Self) -> Self {
        Self {
            position: self.local_point(other.position),
            rotation: self.rotation.conjugate() * other.rotation,
        }
    }

    /// The inverse transform.
    #[must_use]
    #[inline]
    pub fn inverse(&self) -> Self {
        Self {
            position: self.rotation.unrotate(-self.position),
            rotation: self.rotation.conjugate(),
        }
    }

    /// Interpolates from this pose to `other` by the fraction `part`, 0 to 1: positions on a line,
    /// rotations along the shorter arc.
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
