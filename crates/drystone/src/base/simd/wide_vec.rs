//! Vectors and symmetric matrices of eight lanes.

use crate::base::math::Vec3;
use crate::base::simd::wide::{
    LANES, Lanes, Wide, above, gather_rows, load, max, min, select, splat, sqrt,
};
use core::ops::{Add, Mul, Neg, Sub};
use fearless_simd::{Simd, SimdBase, SimdMask, mask32x8};

/// Eight vectors.
#[derive(Clone, Copy)]
pub(crate) struct Vec3w<S: Simd> {
    pub(crate) x: Wide<S>,
    pub(crate) y: Wide<S>,
    pub(crate) z: Wide<S>,
}

impl<S: Simd> Vec3w<S> {
    /// Loads rows x, y, z and a fourth number, which is ignored.
    #[inline(always)]
    pub(crate) fn of_rows(simd: S, r: &[[f32; 4]; LANES]) -> Self {
        let [x, y, z, _] = gather_rows(simd, r);
        Self { x, y, z }
    }

    #[inline(always)]
    pub(crate) fn load(simd: S, from: &[Lanes; 3]) -> Self {
        Self { x: load(simd, &from[0]), y: load(simd, &from[1]), z: load(simd, &from[2]) }
    }

    /// Loads three vectors. (`array::map` in a kernel may not be inlined, and then costs ten times
    /// more.)
    #[inline(always)]
    pub(crate) fn load3(simd: S, from: &[[Lanes; 3]; 3]) -> [Self; 3] {
        [Self::load(simd, &from[0]), Self::load(simd, &from[1]), Self::load(simd, &from[2])]
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, v: Vec3) -> Self {
        Self { x: splat(simd, v.x), y: splat(simd, v.y), z: splat(simd, v.z) }
    }

    #[inline(always)]
    pub(crate) fn zero(simd: S) -> Self {
        let zero = splat(simd, 0.0);
        Self { x: zero, y: zero, z: zero }
    }

    /// `a` where `mask`, else `b`.
    #[inline(always)]
    pub(crate) fn select(mask: mask32x8<S>, a: Self, b: Self) -> Self {
        Self { x: select(mask, a.x, b.x), y: select(mask, a.y, b.y), z: select(mask, a.z, b.z) }
    }

    #[inline(always)]
    pub(crate) fn store(self, to: &mut [Lanes; 3]) {
        self.x.store_array(&mut to[0]);
        self.y.store_array(&mut to[1]);
        self.z.store_array(&mut to[2]);
    }

    #[inline(always)]
    pub(crate) fn dot(self, o: Self) -> Wide<S> {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    #[inline(always)]
    pub(crate) fn cross(self, o: Self) -> Self {
        Self {
            x: self.y * o.z - self.z * o.y,
            y: self.z * o.x - self.x * o.z,
            z: self.x * o.y - self.y * o.x,
        }
    }

    /// Same bits as [`crate::base::math::Vec3::any_perpendicular`].
    #[inline(always)]
    pub(crate) fn any_perpendicular(self, simd: S) -> Self {
        let zero = splat(simd, 0.0);
        let flat = above(splat(simd, 0.58), self.x.abs());
        let p = Self {
            x: select(flat, zero, self.y),
            y: select(flat, self.z, -self.x),
            z: select(flat, -self.y, zero),
        };
        p * (splat(simd, 1.0) / sqrt(p.dot(p)))
    }
}

impl<S: Simd> Add for Vec3w<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<S: Simd> Sub for Vec3w<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl<S: Simd> Neg for Vec3w<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<S: Simd> Mul<Wide<S>> for Vec3w<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: Wide<S>) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

/// Eight symmetric matrices.
#[derive(Clone, Copy)]
pub(crate) struct Sym3w<S: Simd> {
    pub(crate) xx: Wide<S>,
    pub(crate) yy: Wide<S>,
    pub(crate) zz: Wide<S>,
    pub(crate) xy: Wide<S>,
    pub(crate) xz: Wide<S>,
    pub(crate) yz: Wide<S>,
}

impl<S: Simd> Sym3w<S> {
    /// Loads in the order of [`crate::base::sym3::Sym3`]: xx, yy, zz, xy, xz, yz.
    #[inline(always)]
    pub(crate) fn load(simd: S, m: &[Lanes; 6]) -> Self {
        Self {
            xx: load(simd, &m[0]),
            yy: load(simd, &m[1]),
            zz: load(simd, &m[2]),
            xy: load(simd, &m[3]),
            xz: load(simd, &m[4]),
            yz: load(simd, &m[5]),
        }
    }

    #[inline(always)]
    pub(crate) fn store(self, to: &mut [Lanes; 6]) {
        for (lanes, out) in
            [self.xx, self.yy, self.zz, self.xy, self.xz, self.yz].into_iter().zip(to)
        {
            lanes.store_array(out);
        }
    }

    #[inline(always)]
    pub(crate) fn scaled(self, k: Wide<S>) -> Self {
        Self {
            xx: self.xx * k,
            yy: self.yy * k,
            zz: self.zz * k,
            xy: self.xy * k,
            xz: self.xz * k,
            yz: self.yz * k,
        }
    }

    #[inline(always)]
    pub(crate) fn mul(self, v: Vec3w<S>) -> Vec3w<S> {
        Vec3w {
            x: self.xx * v.x + self.xy * v.y + self.xz * v.z,
            y: self.xy * v.x + self.yy * v.y + self.yz * v.z,
            z: self.xz * v.x + self.yz * v.y + self.zz * v.z,
        }
    }

    /// True if each is a multiple of the identity.
    #[inline(always)]
    pub(crate) fn is_round(&self, simd: S) -> bool {
        let zero = splat(simd, 0.0);
        let maximum = max(max(self.xx, self.yy), self.zz);
        let minimum = min(min(self.xx, self.yy), self.zz);
        let off = max(max(self.xy.abs(), self.xz.abs()), self.yz.abs());
        !above(max(maximum - minimum, off), zero).any_true()
    }

    /// The solution of `self x = v`; zero where the matrix is singular.
    #[inline(always)]
    pub(crate) fn solve(self, simd: S, v: Vec3w<S>) -> Vec3w<S> {
        let cx = self.yy * self.zz - self.yz * self.yz;
        let cy = self.xz * self.yz - self.xy * self.zz;
        let cz = self.xy * self.yz - self.xz * self.yy;
        let det = self.xx * cx + self.xy * cy + self.xz * cz;
        let zero = splat(simd, 0.0);
        let k = select(above(det, zero), splat(simd, 1.0) / det, zero);
        let inverse = Self {
            xx: cx * k,
            xy: cy * k,
            xz: cz * k,
            yy: (self.xx * self.zz - self.xz * self.xz) * k,
            yz: (self.xy * self.xz - self.xx * self.yz) * k,
            zz: (self.xx * self.yy - self.xy * self.xy) * k,
        };
        inverse.mul(v)
    }
}
