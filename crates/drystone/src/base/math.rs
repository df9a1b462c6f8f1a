//! Vectors and matrices. Plain `repr(C)` structs of `f32`. Every operation is a fixed sequence of
//! IEEE `+ - * /` and `sqrt`, so results have the same bits on every target.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use core::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, MulAssign, Neg, Sub, SubAssign};

/// A vector of three components.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C)]
pub struct Vec3 {
    /// First component.
    pub x: f32,
    /// Second component.
    pub y: f32,
    /// Third component.
    pub z: f32,
}

/// Constructs a [`Vec3`]; short for literals.
#[must_use]
#[inline]
pub const fn vec3(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3 { x, y, z }
}

/// Returns the nearest finite number: clamps infinities to the largest f32, and turns NaN into 0.
/// For results that users see.
#[must_use]
pub(crate) fn bounded(value: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(-f32::MAX, f32::MAX) }
}

impl Vec3 {
    /// (0, 0, 0).
    pub const ZERO: Self = vec3(0.0, 0.0, 0.0);
    /// (1, 1, 1).
    pub const ONE: Self = vec3(1.0, 1.0, 1.0);
    /// (1, 0, 0).
    pub const X: Self = vec3(1.0, 0.0, 0.0);
    /// (0, 1, 0).
    pub const Y: Self = vec3(0.0, 1.0, 0.0);
    /// (0, 0, 1).
    pub const Z: Self = vec3(0.0, 0.0, 1.0);

    /// The same value in all three components.
    #[must_use]
    #[inline]
    pub const fn splat(value: f32) -> Self {
        vec3(value, value, value)
    }

    /// Dot product.
    #[must_use]
    #[inline]
    pub fn dot(self, other: Self) -> f32 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Cross product (right-handed).
    #[must_use]
    #[inline]
    pub fn cross(self, other: Self) -> Self {
        vec3(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    /// Squared length.
    #[must_use]
    #[inline]
    pub fn length_squared(self) -> f32 {
        self.dot(self)
    }

    /// Length.
    #[must_use]
    #[inline]
    pub fn length(self) -> f32 {
        self.length_squared().sqrt()
    }

    /// Returns the unit vector along this one, or `None` if its length is zero, tiny or not finite.
    #[must_use]
    #[inline]
    pub fn try_normalize(self) -> Option<Self> {
        let length = self.length();
        (length > 1.0e-18 && length.is_finite()).then(|| self * (1.0 / length))
    }

    /// Returns the unit vector along this one, or `fallback` where [`Self::try_normalize`] is
    /// `None`.
    #[must_use]
    #[inline]
    pub fn normalize_or(self, fallback: Self) -> Self {
        self.try_normalize().unwrap_or(fallback)
    }

    /// Applies [`bounded`] to each component.
    #[must_use]
    pub(crate) fn bounded(self) -> Self {
        vec3(bounded(self.x), bounded(self.y), bounded(self.z))
    }

    /// True if all components are between `-maximum` and `maximum`; NaN never is.
    #[must_use]
    #[inline(always)]
    pub(crate) fn is_below(self, maximum: f32) -> bool {
        self.x.abs() < maximum && self.y.abs() < maximum && self.z.abs() < maximum
    }

    /// Component-wise product.
    #[must_use]
    #[inline]
    pub fn mul_each(self, other: Self) -> Self {
        vec3(self.x * other.x, self.y * other.y, self.z * other.z)
    }

    /// Component-wise smaller value.
    #[must_use]
    #[inline]
    pub fn min(self, other: Self) -> Self {
        vec3(lesser(self.x, other.x), lesser(self.y, other.y), lesser(self.z, other.z))
    }

    /// Component-wise larger value.
    #[must_use]
    #[inline]
    pub fn max(self, other: Self) -> Self {
        vec3(greater(self.x, other.x), greater(self.y, other.y), greater(self.z, other.z))
    }

    /// Component-wise absolute value.
    #[must_use]
    #[inline]
    pub fn abs(self) -> Self {
        vec3(self.x.abs(), self.y.abs(), self.z.abs())
    }

    /// The largest component.
    #[must_use]
    #[inline]
    pub fn max_element(self) -> f32 {
        greater(greater(self.x, self.y), self.z)
    }

    /// The smallest component.
    #[must_use]
    #[inline]
    pub fn min_element(self) -> f32 {
        lesser(lesser(self.x, self.y), self.z)
    }

    /// `self + (other - self) * t`.
    #[must_use]
    #[inline]
    pub fn lerp(self, other: Self, t: f32) -> Self {
        self + (other - self) * t
    }

    /// True if no component is infinite or NaN.
    #[must_use]
    #[inline]
    pub fn is_finite(self) -> bool {
        // An infinity or NaN times 0 is NaN.
        let Self { x, y, z } = self * 0.0;
        x + y + z == 0.0
    }

    /// Returns a unit vector perpendicular to this unit vector. The result depends on this vector
    /// alone, so the tangents of a contact are the same in every step with the same normal.
    #[must_use]
    #[inline]
    pub fn any_perpendicular(self) -> Self {
        // Drops a component that cannot be the only large one: 1/sqrt(3) < 0.58.
        let p = if self.x.abs() < 0.58 {
            vec3(0.0, self.z, -self.y)
        } else {
            vec3(self.y, -self.x, 0.0)
        };
        p * (1.0 / p.length())
    }

    /// The components as an array.
    #[must_use]
    #[inline]
    pub const fn to_array(self) -> [f32; 3] {
        [self.x, self.y, self.z]
    }
}

/// The smaller of two numbers; `b` if either is NaN. A compare and a select: equal on all targets.
#[must_use]
#[inline]
pub(crate) fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers; `b` if either is NaN. A compare and a select: equal on all targets.
#[must_use]
#[inline]
pub(crate) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

impl Add for Vec3 {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        vec3(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl Sub for Vec3 {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        vec3(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl Neg for Vec3 {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        vec3(-self.x, -self.y, -self.z)
    }
}

impl Mul<f32> for Vec3 {
    type Output = Self;
    #[inline]
    fn mul(self, s: f32) -> Self {
        vec3(self.x * s, self.y * s, self.z * s)
    }
}

impl Mul<Vec3> for f32 {
    type Output = Vec3;
    #[inline]
    fn mul(self, v: Vec3) -> Vec3 {
        v * self
    }
}

impl Div<f32> for Vec3 {
    type Output = Self;
    #[inline]
    fn div(self, s: f32) -> Self {
        vec3(self.x / s, self.y / s, self.z / s)
    }
}

impl AddAssign for Vec3 {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl SubAssign for Vec3 {
    #[inline]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl MulAssign<f32> for Vec3 {
    #[inline]
    fn mul_assign(&mut self, s: f32) {
        *self = *self * s;
    }
}

impl Index<usize> for Vec3 {
    type Output = f32;
    /// Component `i`; every `i` of 2 or more is the third.
    #[inline]
    fn index(&self, i: usize) -> &f32 {
        match i {
            0 => &self.x,
            1 => &self.y,
            _ => &self.z,
        }
    }
}

impl IndexMut<usize> for Vec3 {
    #[inline]
    fn index_mut(&mut self, i: usize) -> &mut f32 {
        match i {
            0 => &mut self.x,
            1 => &mut self.y,
            _ => &mut self.z,
        }
    }
}

impl From<[f32; 3]> for Vec3 {
    #[inline]
    fn from([x, y, z]: [f32; 3]) -> Self {
        vec3(x, y, z)
    }
}

impl From<(f32, f32, f32)> for Vec3 {
    #[inline]
    fn from((x, y, z): (f32, f32, f32)) -> Self {
        vec3(x, y, z)
    }
}

impl From<Vec3> for [f32; 3] {
    #[inline]
    fn from(v: Vec3) -> Self {
        v.to_array()
    }
}

impl From<Vec3> for (f32, f32, f32) {
    #[inline]
    fn from(v: Vec3) -> Self {
        (v.x, v.y, v.z)
    }
}

/// A 3 × 3 matrix, stored as three columns.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Mat3 {
    /// First column.
    pub x: Vec3,
    /// Second column.
    pub y: Vec3,
    /// Third column.
    pub z: Vec3,
}

impl Mat3 {
    /// The identity.
    pub const IDENTITY: Self = Self { x: Vec3::X, y: Vec3::Y, z: Vec3::Z };

    /// A diagonal matrix.
    #[must_use]
    #[inline]
    pub const fn diagonal(d: Vec3) -> Self {
        Self { x: vec3(d.x, 0.0, 0.0), y: vec3(0.0, d.y, 0.0), z: vec3(0.0, 0.0, d.z) }
    }

    /// The matrix `[r]×` with `[r]× v = r × v`.
    #[must_use]
    #[inline]
    pub const fn skew(r: Vec3) -> Self {
        Self { x: vec3(0.0, r.z, -r.y), y: vec3(-r.z, 0.0, r.x), z: vec3(r.y, -r.x, 0.0) }
    }

    /// The transposed matrix.
    #[must_use]
    #[inline]
    pub const fn transpose(self) -> Self {
        Self {
            x: vec3(self.x.x, self.y.x, self.z.x),
            y: vec3(self.x.y, self.y.y, self.z.y),
            z: vec3(self.x.z, self.y.z, self.z.z),
        }
    }

    /// The determinant.
    #[must_use]
    #[inline]
    pub fn determinant(self) -> f32 {
        self.x.dot(self.y.cross(self.z))
    }

    /// `transpose(self) * v`.
    #[must_use]
    #[inline]
    pub fn transpose_mul(self, v: Vec3) -> Vec3 {
        vec3(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
}

impl Mul<Vec3> for Mat3 {
    type Output = Vec3;
    #[inline]
    fn mul(self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

impl Mul for Mat3 {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self { x: self * o.x, y: self * o.y, z: self * o.z }
    }
}

impl Sub for Mat3 {
    type Output = Self;

    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl Add for Mat3 {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

#[cfg(test)]
mod tests {
    use super::{Mat3, Vec3, vec3};

    #[test]
    fn cross_is_right_handed_and_perpendicular_is_unit() {
        assert_eq!(Vec3::X.cross(Vec3::Y), Vec3::Z);
        for n in [Vec3::X, Vec3::Y, -Vec3::Z, vec3(0.6, 0.8, 0.0), vec3(0.577, 0.577, 0.578)] {
            let t = n.any_perpendicular();
            assert!(t.dot(n).abs() < 1e-6 && (t.length() - 1.0).abs() < 1e-6, "{n:?}");
        }
    }

    #[test]
    fn skew_matrix_is_the_cross_product() {
        let (r, v) = (vec3(1.0, -2.0, 3.0), vec3(0.5, 4.0, -1.0));
        assert_eq!(Mat3::skew(r) * v, r.cross(v));
    }
}
