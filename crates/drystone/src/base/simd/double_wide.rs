//! Eight vectors and quaternions in double precision. Each lane gives the same bits as
//! [`crate::base::double`], since the order of operations is the same.

use core::ops::{Add, Mul, Neg};

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, f64x8, mask64x8};

use super::wide::LANES;

/// Eight numbers in memory.
pub(crate) type DLanes = [f64; LANES];

/// Eight numbers in registers.
pub(crate) type DWide<S> = f64x8<S>;

/// One boolean per lane.
pub(crate) type DMask<S> = mask64x8<S>;

/// Loads eight numbers.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, from: &DLanes) -> DWide<S> {
    DWide::load_array_ref(simd, from)
}

/// The same number in every lane.
#[inline(always)]
pub(crate) fn splat<S: Simd>(simd: S, value: f64) -> DWide<S> {
    DWide::splat(simd, value)
}

/// `a` where `mask`, else `b`.
#[inline(always)]
pub(crate) fn select<S: Simd>(mask: DMask<S>, a: DWide<S>, b: DWide<S>) -> DWide<S> {
    mask.select(a, b)
}

/// Rounded to `f32`.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
pub(crate) fn single<S: Simd>(a: DWide<S>) -> [f32; LANES] {
    let (mut exact, mut rounded) = ([0.0; LANES], [0.0; LANES]);
    a.store_array(&mut exact);
    for lane in 0..LANES {
        rounded[lane] = exact[lane] as f32;
    }
    rounded
}

/// Converts eight `f32` numbers exactly.
#[inline(always)]
pub(crate) fn widened<S: Simd>(simd: S, from: &[f32; LANES]) -> DWide<S> {
    let mut lanes = [0.0; LANES];
    for lane in 0..LANES {
        lanes[lane] = f64::from(from[lane]);
    }
    load(simd, &lanes)
}

/// Eight vectors.
#[derive(Clone, Copy)]
pub(crate) struct DVec3w<S: Simd> {
    pub(crate) x: DWide<S>,
    pub(crate) y: DWide<S>,
    pub(crate) z: DWide<S>,
}

impl<S: Simd> DVec3w<S> {
    #[inline(always)]
    pub(crate) fn load(simd: S, from: &[DLanes; 3]) -> Self {
        Self { x: load(simd, &from[0]), y: load(simd, &from[1]), z: load(simd, &from[2]) }
    }

    #[inline(always)]
    pub(crate) fn dot(self, o: Self) -> DWide<S> {
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

    #[inline(always)]
    pub(crate) fn length(self) -> DWide<S> {
        self.dot(self).sqrt()
    }

    /// Component-wise product.
    #[inline(always)]
    pub(crate) fn each(self, o: Self) -> Self {
        Self { x: self.x * o.x, y: self.y * o.y, z: self.z * o.z }
    }
}

impl<S: Simd> Add for DVec3w<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<S: Simd> Neg for DVec3w<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<S: Simd> Mul<DWide<S>> for DVec3w<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: DWide<S>) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

/// Eight unit quaternions: vector and real part.
#[derive(Clone, Copy)]
pub(crate) struct DQuatw<S: Simd> {
    pub(crate) v: DVec3w<S>,
    pub(crate) w: DWide<S>,
}

impl<S: Simd> DQuatw<S> {
    /// The rotation `o` followed by `self`.
    #[inline(always)]
    pub(crate) fn times(self, o: Self) -> Self {
        Self {
            v: o.v * self.w + self.v * o.w + self.v.cross(o.v),
            w: self.w * o.w - self.v.dot(o.v),
        }
    }

    #[inline(always)]
    pub(crate) fn rotate(self, simd: S, p: DVec3w<S>) -> DVec3w<S> {
        let t = self.v.cross(p) * splat(simd, 2.0);
        p + t * self.w + self.v.cross(t)
    }

    #[inline(always)]
    pub(crate) fn unrotate(self, simd: S, p: DVec3w<S>) -> DVec3w<S> {
        self.conjugate().rotate(simd, p)
    }

    /// The inverse rotation.
    #[inline(always)]
    pub(crate) fn conjugate(self) -> Self {
        Self { v: -self.v, w: self.w }
    }

    /// Scaled to length 1.
    #[inline(always)]
    pub(crate) fn normalized(self, simd: S) -> Self {
        let k = splat(simd, 1.0) / (self.v.dot(self.v) + self.w * self.w).sqrt();
        Self { v: self.v * k, w: self.w * k }
    }

    /// Converts `f32` quaternions, x y z w, exactly, without normalizing them.
    #[inline(always)]
    pub(crate) fn widened(simd: S, from: &[[f32; LANES]; 4]) -> Self {
        let [x, y, z, w] = from;
        let v = DVec3w { x: widened(simd, x), y: widened(simd, y), z: widened(simd, z) };
        Self { v, w: widened(simd, w) }
    }

    /// Rounded to `f32`: x y z w.
    #[inline(always)]
    pub(crate) fn single(self) -> [[f32; LANES]; 4] {
        [single(self.v.x), single(self.v.y), single(self.v.z), single(self.w)]
    }
}
