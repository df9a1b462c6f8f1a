//! Unit quaternions.

use core::ops::Mul;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::math::{Mat3, Vec3, vec3};
use super::trig;

/// A rotation as a unit quaternion `x i + y j + z k + w`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C)]
pub struct Quat {
    /// Coefficient of i.
    pub x: f32,
    /// Coefficient of j.
    pub y: f32,
    /// Coefficient of k.
    pub z: f32,
    /// Real part.
    pub w: f32,
}

impl Default for Quat {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Quat {
    /// No rotation.
    pub const IDENTITY: Self = Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };

    /// The quaternion with these four components; not normalized.
    #[must_use]
    #[inline]
    pub const fn new(x: f32, y: f32, z: f32, w: f32) -> Self {
        Self { x, y, z, w }
    }

    #[inline]
    fn length_squared(self) -> f32 {
        self.x * self.x + self.y * self.y + self.z * self.z + self.w * self.w
    }

    /// True if it is a rotation up to rounding, or up to the digits that a file may have kept.
    pub(crate) fn is_unit(self) -> bool {
        (0.9..1.1).contains(&self.length_squared())
    }

    /// True if its length is that after normalization, or of a product of a few normalized
    /// rotations. A vector that it rotates keeps its length as closely.
    pub(crate) fn is_normalized(self) -> bool {
        (self.length_squared() - 1.0).abs() < 1.0e-4
    }

    /// Rotation by `angle` [rad] about `axis` (any length; a zero axis gives the identity).
    #[must_use]
    pub fn from_axis_angle(axis: impl Into<Vec3>, angle: f32) -> Self {
        let Some(axis) = axis.into().try_normalize() else { return Self::IDENTITY };
        let (s, c) = trig::sin_cos(0.5 * angle);
        Self::new(axis.x * s, axis.y * s, axis.z * s, c)
    }

    /// Rotation about the vector `v` by its length [rad].
    #[must_use]
    pub fn from_rotation_vector(v: Vec3) -> Self {
        Self::from_axis_angle(v, v.length())
    }

    /// The shortest rotation from the unit vector `from` to the unit vector `to`.
    #[must_use]
    pub fn from_arc(from: Vec3, to: Vec3) -> Self {
        let d = from.dot(to);
        if d < -0.999_999 {
            let p = from.any_perpendicular();
            return Self::new(p.x, p.y, p.z, 0.0);
        }
        let c = from.cross(to);
        Self::new(c.x, c.y, c.z, 1.0 + d).normalized()
    }

    /// The rotation whose axes are the columns of `m`; `m` must be a rotation matrix.
    #[must_use]
    pub fn from_mat3(m: Mat3) -> Self {
        let (a, b, c) = (m.x, m.y, m.z);
        let trace = a.x + b.y + c.z;
        let q = if trace > 0.0 {
            Self::new(b.z - c.y, c.x - a.z, a.y - b.x, trace + 1.0)
        } else if a.x > b.y && a.x > c.z {
            Self::new(1.0 + a.x - b.y - c.z, a.y + b.x, c.x + a.z, b.z - c.y)
        } else if b.y > c.z {
            Self::new(a.y + b.x, 1.0 + b.y - a.x - c.z, b.z + c.y, c.x - a.z)
        } else {
            Self::new(c.x + a.z, b.z + c.y, 1.0 + c.z - a.x - b.y, a.y - b.x)
        };
        q.normalized()
    }

    /// Converts to a rotation matrix.
    #[must_use]
    #[inline]
    pub fn to_mat3(self) -> Mat3 {
        let (x, y, z, w) = (self.x, self.y, self.z, self.w);
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let (xy, xz, yz) = (x * y, x * z, y * z);
        let (wx, wy, wz) = (w * x, w * y, w * z);
        Mat3 {
            x: vec3(1.0 - 2.0 * (yy + zz), 2.0 * (xy + wz), 2.0 * (xz - wy)),
            y: vec3(2.0 * (xy - wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz + wx)),
            z: vec3(2.0 * (xz + wy), 2.0 * (yz - wx), 1.0 - 2.0 * (xx + yy)),
        }
    }

    /// The inverse rotation.
    #[must_use]
    #[inline]
    pub fn conjugate(self) -> Self {
        Self::new(-self.x, -self.y, -self.z, self.w)
    }

    /// Scaled to length 1; the identity if the length is zero or not finite.
    #[must_use]
    #[inline]
    pub fn normalized(self) -> Self {
        let n = self.length_squared().sqrt();
        if !(n > 1.0e-18 && n.is_finite()) {
            return Self::IDENTITY;
        }
        let k = 1.0 / n;
        Self::new(self.x * k, self.y * k, self.z * k, self.w * k)
    }

    /// Interpolates from this rotation to `other` by the fraction `part`, 0 to 1, along the shorter
    /// arc. It follows the path of uniform rotation; for 90° its angle is off by 1 % of that.
    #[must_use]
    pub fn nlerp(self, other: Self, part: f32) -> Self {
        let dot = self.x * other.x + self.y * other.y + self.z * other.z + self.w * other.w;
        let b = if dot < 0.0 { -part } else { part };
        let a = 1.0 - part;
        let mix = |from: f32, to: f32| from * a + to * b;
        let [x, y, z, w] = [
            mix(self.x, other.x),
            mix(self.y, other.y),
            mix(self.z, other.z),
            mix(self.w, other.w),
        ];
        Self::new(x, y, z, w).normalized()
    }

    /// Rotates a vector.
    #[must_use]
    #[inline]
    pub fn rotate(self, v: Vec3) -> Vec3 {
        let u = vec3(self.x, self.y, self.z);
        let t = u.cross(v) * 2.0;
        v + t * self.w + u.cross(t)
    }

    /// Rotates a vector by the inverse.
    #[must_use]
    #[inline]
    pub fn unrotate(self, v: Vec3) -> Vec3 {
        self.conjugate().rotate(v)
    }

    /// This rotation followed by the rotation vector `v` [rad, world], as the exponential of `v`.
    ///
    /// The half-angle sine and cosine come from their series to order 9 for rotations below half a
    /// radian, else from [`trig`].
    #[must_use]
    pub fn turned_by(self, v: Vec3) -> Self {
        let half = v * 0.5;
        let a2 = half.length_squared();
        let (k, c) = if a2 < 0.0625 {
            let sinc =
                1.0 - a2 * (1.0 / 6.0) * (1.0 - a2 * (1.0 / 20.0) * (1.0 - a2 * (1.0 / 42.0)));
            let cos = 1.0
                - a2 * 0.5
                    * (1.0
                        - a2 * (1.0 / 12.0)
                            * (1.0 - a2 * (1.0 / 30.0) * (1.0 - a2 * (1.0 / 56.0))));
            (sinc, cos)
        } else {
            let a = a2.sqrt();
            let (s, c) = trig::sin_cos(a);
            (s / a, c)
        };
        (Self::new(half.x * k, half.y * k, half.z * k, c) * self).normalized()
    }

    /// The angle of this rotation [rad], 0 to π.
    #[must_use]
    pub fn angle(self) -> f32 {
        let s = vec3(self.x, self.y, self.z).length();
        2.0 * trig::atan2(s, self.w.abs())
    }

    /// The rotation as a vector along its axis, with its angle [rad] as length; at most π long.
    #[must_use]
    pub fn to_rotation_vector(self) -> Vec3 {
        let q = if self.w < 0.0 { Self::new(-self.x, -self.y, -self.z, -self.w) } else { self };
        let u = vec3(q.x, q.y, q.z);
        let s = u.length();
        if s < 1.0e-9 {
            return u * 2.0;
        }
        u * (2.0 * trig::atan2(s, q.w) / s)
    }

    /// True if no component is infinite or NaN.
    #[must_use]
    pub fn is_finite(self) -> bool {
        // An infinity or NaN times 0 is NaN.
        (self.x * 0.0 + self.y * 0.0) + (self.z * 0.0 + self.w * 0.0) == 0.0
    }

    /// The components `[x, y, z, w]`.
    #[must_use]
    pub const fn to_array(self) -> [f32; 4] {
        [self.x, self.y, self.z, self.w]
    }
}

impl Mul for Quat {
    type Output = Self;
    /// The rotation `o` followed by `self`.
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self::new(
            self.w * o.x + self.x * o.w + self.y * o.z - self.z * o.y,
            self.w * o.y - self.x * o.z + self.y * o.w + self.z * o.x,
            self.w * o.z + self.x * o.y - self.y * o.x + self.z * o.w,
            self.w * o.w - self.x * o.x - self.y * o.y - self.z * o.z,
        )
    }
}

impl From<[f32; 4]> for Quat {
    /// Converts `[x, y, z, w]`; not normalized.
    fn from([x, y, z, w]: [f32; 4]) -> Self {
        Self::new(x, y, z, w)
    }
}

impl From<Quat> for [f32; 4] {
    fn from(q: Quat) -> Self {
        q.to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::{Quat, Vec3, vec3};

    #[test]
    fn rotation_matrix_vector_and_exponential_agree() {
        let v = vec3(0.3, -0.8, 0.5);
        for scale in [0.001, 0.3, 1.0, 2.5] {
            let q = Quat::from_rotation_vector(v * scale);
            let p = vec3(1.0, 2.0, -3.0);
            assert!((q.rotate(p) - q.to_mat3() * p).length() < 2e-6);
            assert!((q.unrotate(q.rotate(p)) - p).length() < 2e-6);
            assert!((Quat::IDENTITY.turned_by(v * scale).rotate(p) - q.rotate(p)).length() < 2e-6);
            assert!((q.to_rotation_vector() - v * scale).length() < 2e-6);
            assert!((Quat::from_mat3(q.to_mat3()).rotate(p) - q.rotate(p)).length() < 3e-6);
        }
        assert!((Quat::from_arc(Vec3::X, -Vec3::X).rotate(Vec3::X) + Vec3::X).length() < 1e-6);
    }
}
