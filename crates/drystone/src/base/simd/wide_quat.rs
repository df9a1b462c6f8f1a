//! Rotations in lanes, and the angle function that they need.

use core::ops::Neg;

use fearless_simd::{Simd, SimdBase};

use super::wide::{LANES, Vec3w, Wide, above, gather_rows, gather4, max, min, select, splat, sqrt};

/// Eight rotations as unit quaternions.
#[derive(Clone, Copy)]
pub(crate) struct Quatw<S: Simd> {
    /// Coefficients of i, j and k.
    pub(crate) u: Vec3w<S>,
    /// Real part.
    pub(crate) w: Wide<S>,
}

impl<S: Simd> Quatw<S> {
    /// Loads contiguous rows x, y, z, w.
    #[inline(always)]
    pub(crate) fn of_rows(simd: S, r: &[[f32; 4]; LANES]) -> Self {
        let [x, y, z, w] = gather_rows(simd, r);
        Self { u: Vec3w { x, y, z }, w }
    }

    /// Like [`Self::of_rows`], for rows at any address.
    #[inline(always)]
    pub(crate) fn gather(simd: S, r: [&[f32; 4]; LANES]) -> Self {
        let [x, y, z, w] = gather4(simd, r);
        Self { u: Vec3w { x, y, z }, w }
    }

    /// Same bits as [`crate::base::quat::Quat::rotate`].
    #[inline(always)]
    pub(crate) fn rotate(self, simd: S, v: Vec3w<S>) -> Vec3w<S> {
        let t = self.u.cross(v) * splat(simd, 2.0);
        v + t * self.w + self.u.cross(t)
    }

    /// Same bits as [`crate::base::quat::Quat::unrotate`].
    #[inline(always)]
    pub(crate) fn unrotate(self, simd: S, v: Vec3w<S>) -> Vec3w<S> {
        self.conjugate().rotate(simd, v)
    }

    /// The rotation `o` relative to this one: the conjugate of this times `o`, with the same bits
    /// as the product of [`crate::base::quat::Quat`].
    #[inline(always)]
    pub(crate) fn to(self, o: Self) -> Self {
        let c = -self.u;
        let u = Vec3w {
            x: self.w * o.u.x + c.x * o.w + c.y * o.u.z - c.z * o.u.y,
            y: self.w * o.u.y - c.x * o.u.z + c.y * o.w + c.z * o.u.x,
            z: self.w * o.u.z + c.x * o.u.y - c.y * o.u.x + c.z * o.w,
        };
        Self { u, w: self.w * o.w - c.x * o.u.x - c.y * o.u.y - c.z * o.u.z }
    }

    /// Twice the chord of two unit quaternions: at least the angle between the rotations, for small
    /// angles.
    #[inline(always)]
    pub(crate) fn chord(self, simd: S, o: Self) -> Wide<S> {
        let (d, w) = (self.u - o.u, self.w - o.w);
        splat(simd, 2.0) * sqrt(d.x * d.x + d.y * d.y + d.z * d.z + w * w)
    }

    #[inline(always)]
    pub(crate) fn conjugate(self) -> Self {
        Self { u: -self.u, w: self.w }
    }

    /// The rotation `o` followed by this one.
    #[inline(always)]
    pub(crate) fn after(self, o: Self) -> Self {
        let u = o.u * self.w + self.u * o.w + self.u.cross(o.u);
        Self { u, w: self.w * o.w - self.u.dot(o.u) }
    }

    /// The same rotation with a real part that is at least 0.
    #[inline(always)]
    pub(crate) fn shorter(self, simd: S) -> Self {
        let long = above(splat(simd, 0.0), self.w);
        Self { u: Vec3w::select(long, self.u.neg(), self.u), w: select(long, -self.w, self.w) }
    }

    /// The axes x, y, z rotated by it.
    #[inline(always)]
    pub(crate) fn axes(self, simd: S) -> [Vec3w<S>; 3] {
        let (one, two) = (splat(simd, 1.0), splat(simd, 2.0));
        let (Vec3w { x, y, z }, w) = (self.u, self.w);
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let (xy, xz, yz) = (x * y, x * z, y * z);
        let (wx, wy, wz) = (w * x, w * y, w * z);
        [
            Vec3w { x: one - two * (yy + zz), y: two * (xy + wz), z: two * (xz - wy) },
            Vec3w { x: two * (xy - wz), y: one - two * (xx + zz), z: two * (yz + wx) },
            Vec3w { x: two * (xz + wy), y: two * (yz - wx), z: one - two * (xx + yy) },
        ]
    }
}

/// Angles of the points (x, y) [rad], -π to π; 0 at the origin. The error is at most 3e-7.
///
/// Computes the arc tangent of the smaller component over the larger one; beyond tan π/8 by the
/// sum of angles, atan t = π/4 + atan (t - 1)/(t + 1). The rest is t + t³ P(t²). P has degree 3
/// and the minimal maximum relative error up to tan π/8, 2e-8, from the exchange algorithm
/// [Remez34].
#[inline(always)]
pub(crate) fn atan2<S: Simd>(simd: S, y: Wide<S>, x: Wide<S>) -> Wide<S> {
    use core::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    let zero = splat(simd, 0.0);
    let (size_x, size_y) = (x.abs(), y.abs());
    let is_steep = above(size_y, size_x);
    let (large, small) = (max(size_x, size_y), min(size_x, size_y));
    let is_wide = above(small, large * splat(simd, 0.414_213_57));
    let over = select(is_wide, small - large, small);
    let under = select(is_wide, small + large, large);
    let t = select(above(under, zero), over / under, zero);
    let z = t * t;
    let p =
        splat(simd, 0.199_776_5) + z * (splat(simd, -0.138_769_75) + z * splat(simd, 0.080_512_81));
    let p = splat(simd, -0.333_329_47) + z * p;
    let angle = t + t * z * p;
    let angle = select(is_wide, splat(simd, FRAC_PI_4) + angle, angle);
    let angle = select(is_steep, splat(simd, FRAC_PI_2) - angle, angle);
    let angle = select(above(zero, x), splat(simd, PI) - angle, angle);
    select(above(zero, y), -angle, angle)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{SimdBase, dispatch};

    use super::{LANES, Wide, atan2};
    use crate::base::simd::wide::SimdLevel;
    use crate::base::trig;

    #[test]
    fn angles_are_those_of_the_points_in_all_directions() {
        // Errors come from rounding of the quotient, of the polynomial and of the sums with π/4,
        // π/2 and π: an ulp of π, 2.4e-7, for a large angle; 3 ulps of the angle itself for a
        // small one.
        for SimdLevel(level) in SimdLevel::available() {
            for i in 0..4000_u16 {
                let (s, c) =
                    trig::sin_cos((f32::from(i) - 2000.0) * (core::f32::consts::PI / 2000.0));
                for size in [1.0e-12, 1.0, 3.0e7] {
                    let (y, x) = (s * size, c * size);
                    let mut out = [0.0; LANES];
                    dispatch!(level, simd => {
                        let [y, x] = [y, x].map(|v| Wide::splat(simd, v));
                        atan2(simd, y, x).store_array(&mut out);
                    });
                    let exact = f64::from(y).atan2(f64::from(x));
                    let error = (f64::from(out[0]) - exact).abs();
                    let allowed = if exact.abs() < 0.4 { 1.8e-7 * exact.abs() } else { 3.0e-7 };
                    assert!(error <= allowed, "{y} {x}: {} for {exact}", out[0]);
                }
            }
        }
    }

    #[test]
    fn the_origin_has_no_angle() {
        let mut out = [1.0; LANES];
        dispatch!(SimdLevel::best().0, simd => {
            let zero = Wide::splat(simd, 0.0);
            atan2(simd, zero, zero).store_array(&mut out);
        });
        assert!(out.iter().all(|angle| angle.to_bits() == 0));
    }
}
