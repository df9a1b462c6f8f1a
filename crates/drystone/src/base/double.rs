//! Vectors and quaternions in double precision, for code whose differences cancel: hulls, mass,
//! rays, free rotation.

use core::ops::{Add, Mul, Neg, Sub};

use super::math::{Vec3, vec3};
use super::quat::Quat;

/// A vector of three `f64`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct DVec3 {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
}

impl DVec3 {
    pub(crate) const ZERO: Self = Self { x: 0.0, y: 0.0, z: 0.0 };

    #[inline]
    pub(crate) fn dot(self, o: Self) -> f64 {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    #[inline]
    pub(crate) fn cross(self, o: Self) -> Self {
        Self {
            x: self.y * o.z - self.z * o.y,
            y: self.z * o.x - self.x * o.z,
            z: self.x * o.y - self.y * o.x,
        }
    }

    #[inline]
    pub(crate) fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Rounded to `f32`.
    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
    pub(crate) fn single(self) -> Vec3 {
        vec3(self.x as f32, self.y as f32, self.z as f32)
    }
}

/// A unit quaternion of `f64`: vector and real part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DQuat {
    pub(crate) v: DVec3,
    pub(crate) w: f64,
}

impl DQuat {
    /// The rotation `o` followed by `self`.
    #[inline]
    pub(crate) fn times(self, o: Self) -> Self {
        Self {
            v: o.v * self.w + self.v * o.w + self.v.cross(o.v),
            w: self.w * o.w - self.v.dot(o.v),
        }
    }

    /// Converts an `f32` quaternion exactly, without normalizing it.
    #[inline]
    pub(crate) fn widened(q: Quat) -> Self {
        Self { v: DVec3::from(vec3(q.x, q.y, q.z)), w: f64::from(q.w) }
    }

    #[inline]
    pub(crate) fn rotate(self, p: DVec3) -> DVec3 {
        let t = self.v.cross(p) * 2.0;
        p + t * self.w + self.v.cross(t)
    }

    #[inline]
    pub(crate) fn unrotate(self, p: DVec3) -> DVec3 {
        Self { v: -self.v, w: self.w }.rotate(p)
    }

    /// Scales to length 1; the quaternion already has it up to rounding.
    pub(crate) fn normalized(self) -> Self {
        let k = 1.0 / (self.v.dot(self.v) + self.w * self.w).sqrt();
        Self { v: self.v * k, w: self.w * k }
    }

    /// Rounded to `f32`.
    #[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
    pub(crate) fn single(self) -> Quat {
        let v = self.v.single();
        Quat::new(v.x, v.y, v.z, self.w as f32)
    }
}

impl From<Quat> for DQuat {
    /// Normalizes, since an `f32` quaternion has length 1 to seven digits only.
    fn from(q: Quat) -> Self {
        Self::widened(q).normalized()
    }
}

/// The larger of two numbers; `b` if either is NaN. A compare and a select: equal on all targets.
#[inline]
pub(crate) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers; `b` if either is NaN. A compare and a select: equal on all targets.
#[inline]
pub(crate) fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

impl From<Vec3> for DVec3 {
    #[inline]
    fn from(v: Vec3) -> Self {
        Self { x: f64::from(v.x), y: f64::from(v.y), z: f64::from(v.z) }
    }
}

impl Add for DVec3 {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl Sub for DVec3 {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl Neg for DVec3 {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl Mul<f64> for DVec3 {
    type Output = Self;
    #[inline]
    fn mul(self, s: f64) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}
