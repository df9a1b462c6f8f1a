//! Lanes: eight numbers at a time, the vocabulary of the kernels.
//!
//! The batch is always eight wide, whatever the CPU: two registers on SSE2 and NEON, one on AVX2. So
//! the grouping of constraints, and with it every bit of the result, is the same everywhere. Only
//! `+ - * /`, `sqrt`, compare and select are used: no fused, approximate or horizontal operation.

use core::ops::{Add, Mul, Neg, Sub};

use fearless_simd::{
    Level, Select, Simd, SimdBase, SimdCombine, SimdFloat, SimdSplit, f32x4, f32x8, mask32x8,
};

/// Lanes of a batch.
pub(crate) const LANES: usize = 8;

/// Eight numbers in memory.
pub(crate) type Lanes = [f32; LANES];

/// Eight numbers in registers.
pub(crate) type Wide<S> = f32x8<S>;

/// Loads.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, from: &Lanes) -> Wide<S> {
    Wide::load_array_ref(simd, from)
}

/// The same number in every lane.
#[inline(always)]
pub(crate) fn splat<S: Simd>(simd: S, value: f32) -> Wide<S> {
    Wide::splat(simd, value)
}

/// The larger one of each lane; the second if they do not compare.
#[inline(always)]
pub(crate) fn max<S: Simd>(a: Wide<S>, b: Wide<S>) -> Wide<S> {
    select(a.simd_gt(b), a, b)
}

/// The smaller one of each lane; the second if they do not compare.
#[inline(always)]
pub(crate) fn min<S: Simd>(a: Wide<S>, b: Wide<S>) -> Wide<S> {
    select(a.simd_lt(b), a, b)
}

/// `a` where `mask`, else `b`.
#[inline(always)]
pub(crate) fn select<S: Simd>(mask: mask32x8<S>, a: Wide<S>, b: Wide<S>) -> Wide<S> {
    mask.select(a, b)
}

/// 1/a where a > 0, else 0.
#[inline(always)]
pub(crate) fn inverse_or_zero<S: Simd>(simd: S, a: Wide<S>) -> Wide<S> {
    let zero = splat(simd, 0.0);
    select(above(a, zero), splat(simd, 1.0) / a, zero)
}

/// Square roots.
#[inline(always)]
pub(crate) fn sqrt<S: Simd>(a: Wide<S>) -> Wide<S> {
    a.sqrt()
}

/// `a > b`, lane by lane.
#[inline(always)]
pub(crate) fn above<S: Simd>(a: Wide<S>, b: Wide<S>) -> mask32x8<S> {
    a.simd_gt(b)
}

/// Eight vectors.
#[derive(Clone, Copy)]
pub(crate) struct Vec3w<S: Simd> {
    pub(crate) x: Wide<S>,
    pub(crate) y: Wide<S>,
    pub(crate) z: Wide<S>,
}

impl<S: Simd> Vec3w<S> {
    #[inline(always)]
    pub(crate) fn load(simd: S, from: &[Lanes; 3]) -> Self {
        Self { x: load(simd, &from[0]), y: load(simd, &from[1]), z: load(simd, &from[2]) }
    }

    /// Three of them. (`array::map` in a kernel may not be inlined, and then costs ten times more.)
    #[inline(always)]
    pub(crate) fn load3(simd: S, from: &[[Lanes; 3]; 3]) -> [Self; 3] {
        [Self::load(simd, &from[0]), Self::load(simd, &from[1]), Self::load(simd, &from[2])]
    }

    #[inline(always)]
    pub(crate) fn zero(simd: S) -> Self {
        let zero = splat(simd, 0.0);
        Self { x: zero, y: zero, z: zero }
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
    /// In the order of [`crate::base::sym3::Sym3`]: xx, yy, zz, xy, xz, yz.
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
    pub(crate) fn mul(self, v: Vec3w<S>) -> Vec3w<S> {
        Vec3w {
            x: self.xx * v.x + self.xy * v.y + self.xz * v.z,
            y: self.xy * v.x + self.yy * v.y + self.yz * v.z,
            z: self.xz * v.x + self.yz * v.y + self.zz * v.z,
        }
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

/// Four rows of four numbers, turned into four columns. Its own inverse.
#[inline(always)]
fn transpose4<S: Simd>([r0, r1, r2, r3]: [f32x4<S>; 4]) -> [f32x4<S>; 4] {
    let (a, b) = (r0.zip_low(r2), r1.zip_low(r3));
    let (c, d) = (r0.zip_high(r2), r1.zip_high(r3));
    [a.zip_low(b), a.zip_high(b), c.zip_low(d), c.zip_high(d)]
}

#[inline(always)]
fn load4<S: Simd>(
    simd: S,
    a: &[f32; 4],
    b: &[f32; 4],
    c: &[f32; 4],
    d: &[f32; 4],
) -> [f32x4<S>; 4] {
    [
        f32x4::load_array_ref(simd, a),
        f32x4::load_array_ref(simd, b),
        f32x4::load_array_ref(simd, c),
        f32x4::load_array_ref(simd, d),
    ]
}

/// Eight 16-byte rows to vectors; the fourth number of a row is left out.
#[inline(always)]
pub(crate) fn gather<S: Simd>(simd: S, r: [&[f32; 4]; LANES]) -> Vec3w<S> {
    let [x0, y0, z0, _] = transpose4(load4(simd, r[0], r[1], r[2], r[3]));
    let [x1, y1, z1, _] = transpose4(load4(simd, r[4], r[5], r[6], r[7]));
    Vec3w { x: x0.combine(x1), y: y0.combine(y1), z: z0.combine(z1) }
}

/// Vectors to eight 16-byte rows, the fourth number 0.
#[inline(always)]
pub(crate) fn scatter<S: Simd>(simd: S, v: Vec3w<S>) -> [f32x4<S>; LANES] {
    let zero = f32x4::splat(simd, 0.0);
    let ((x0, x1), (y0, y1), (z0, z1)) = (v.x.split(), v.y.split(), v.z.split());
    let [a, b, c, d] = transpose4([x0, y0, z0, zero]);
    let [e, f, g, h] = transpose4([x1, y1, z1, zero]);
    [a, b, c, d, e, f, g, h]
}

/// A SIMD level of this machine. All levels give the same bits; the best is chosen by itself.
#[derive(Clone, Copy, Debug)]
pub struct SimdLevel(pub(crate) Level);

impl SimdLevel {
    /// The best level of this machine.
    #[must_use]
    pub fn best() -> Self {
        Self(Level::new())
    }

    /// All levels of this machine, the best first. For tests and measurements.
    #[must_use]
    pub fn available() -> Vec<Self> {
        let best = Level::new();
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        let levels = [
            best.as_avx512().map(Simd::level),
            best.as_avx2().map(Simd::level),
            best.as_sse4_2().map(Simd::level),
            best.as_sse2().map(Simd::level),
        ];
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        let levels = [Some(best)];
        let mut all: Vec<Self> = levels.into_iter().flatten().map(Self).collect();
        if all.is_empty() {
            all.push(Self(best));
        }
        all
    }

    /// The level called `name` (see [`Self::name`]), if this machine has it.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::available().into_iter().find(|l| l.name() == name)
    }

    /// Its name: `avx512`, `avx2`, `sse4.2`, `sse2`, `neon`, `simd128` or `scalar`.
    #[must_use]
    pub fn name(self) -> &'static str {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            if self.0.as_avx512().is_some() {
                return "avx512";
            }
            if self.0.as_avx2().is_some() {
                return "avx2";
            }
            if self.0.as_sse4_2().is_some() {
                return "sse4.2";
            }
            if self.0.as_sse2().is_some() {
                return "sse2";
            }
        }
        #[cfg(target_arch = "aarch64")]
        if self.0.as_neon().is_some() {
            return "neon";
        }
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        if self.0.as_wasm_simd128().is_some() {
            return "simd128";
        }
        "scalar"
    }
}
