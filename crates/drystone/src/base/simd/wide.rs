//! Lanes: eight numbers at a time, the vocabulary of the kernels.
//!
//! A batch is always eight wide on every CPU: two registers on SSE2 and NEON, one on AVX2. The
//! grouping of constraints, and with it every bit of the result, is therefore the same everywhere.
//! The kernels use only `+ - * /`, `sqrt`, compare and select, and no fused or approximate
//! operation. The only reductions over the lanes of a batch are minimum and maximum, which do not
//! depend on the order.

#![cfg_attr(
    target_arch = "x86_64",
    expect(unsafe_code, reason = "an instruction that every x86-64 has is unsafe to name")
)]

pub(crate) use super::wide_vec::{Sym3w, Vec3w};

use fearless_simd::{
    Level, Select, Simd, SimdBase, SimdCombine, SimdFloat, SimdMask, SimdSplit, f32x4, f32x8,
    mask32x8,
};

use crate::base::math::{Vec3, greater, lesser};

/// Number of lanes of a batch.
pub(crate) const LANES: usize = 8;

/// Eight numbers in memory.
pub(crate) type Lanes = [f32; LANES];

/// Eight numbers in registers.
pub(crate) type Wide<S> = f32x8<S>;

/// One boolean per lane.
pub(crate) type Mask<S> = mask32x8<S>;

/// Loads eight numbers.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, from: &Lanes) -> Wide<S> {
    Wide::load_array_ref(simd, from)
}

/// The same number in every lane.
#[inline(always)]
pub(crate) fn splat<S: Simd>(simd: S, value: f32) -> Wide<S> {
    Wide::splat(simd, value)
}

/// The larger number in each lane; the second if they do not compare. This is the behavior of the
/// one x86 instruction; other targets need two.
#[inline(always)]
pub(crate) fn max<S: Simd>(a: Wide<S>, b: Wide<S>) -> Wide<S> {
    if cfg!(any(target_arch = "x86", target_arch = "x86_64")) {
        a.max(b)
    } else {
        select(a.simd_gt(b), a, b)
    }
}

/// The smaller number in each lane; the second if they do not compare.
#[inline(always)]
pub(crate) fn min<S: Simd>(a: Wide<S>, b: Wide<S>) -> Wide<S> {
    if cfg!(any(target_arch = "x86", target_arch = "x86_64")) {
        a.min(b)
    } else {
        select(a.simd_lt(b), a, b)
    }
}

/// `a` where `mask`, else `b`.
#[inline(always)]
pub(crate) fn select<S: Simd>(mask: mask32x8<S>, a: Wide<S>, b: Wide<S>) -> Wide<S> {
    mask.select(a, b)
}

/// Applies [`crate::base::math::bounded`] to each lane.
#[inline(always)]
pub(crate) fn bounded<S: Simd>(simd: S, a: Wide<S>) -> Wide<S> {
    let maximum = splat(simd, f32::MAX);
    select(a.simd_eq(a), min(max(a, -maximum), maximum), splat(simd, 0.0))
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

/// Bit mask of the numbers that are at most 0. Compilers make twenty instructions of a loop; this
/// takes two per register.
#[cfg(target_arch = "x86_64")]
#[inline]
pub(crate) fn bits_up_to_zero(numbers: &Lanes) -> u32 {
    use core::arch::x86_64::{__m128, _mm_cmple_ps, _mm_movemask_ps, _mm_setzero_ps};
    #[inline]
    #[target_feature(enable = "sse")]
    fn bits(x: __m128) -> i32 {
        _mm_movemask_ps(_mm_cmple_ps(x, _mm_setzero_ps()))
    }
    let [low, high]: [__m128; 2] = bytemuck::cast(*numbers);
    // SAFETY: SSE is part of every x86-64.
    let low = unsafe { bits(low) };
    // SAFETY: as above.
    let high = unsafe { bits(high) };
    (low | high << 4).cast_unsigned()
}

/// Bit mask of the numbers that are at most 0.
#[cfg(not(target_arch = "x86_64"))]
#[inline]
pub(crate) fn bits_up_to_zero(numbers: &Lanes) -> u32 {
    numbers.iter().enumerate().fold(0, |bits, (i, x)| bits | u32::from(*x <= 0.0) << i)
}

/// Bit mask of all lanes.
pub(crate) const ALL: u32 = (1 << LANES) - 1;

/// Bit mask of the lanes in use in group `group`, if `count` items are stored in groups of lanes.
#[inline(always)]
pub(crate) fn lanes_in_use(count: usize, group: usize) -> u32 {
    (1 << (count - group * LANES).min(LANES)) - 1
}

/// Bit mask of the lanes that are set; lane 0 is the lowest bit.
#[inline(always)]
pub(crate) fn bits<S: Simd>(mask: Mask<S>) -> u32 {
    #[expect(clippy::cast_possible_truncation, reason = "eight bits")]
    let bits = mask.to_bitmask() as u32;
    bits
}

/// The smallest lane; no lane may be NaN.
#[inline(always)]
pub(crate) fn reduce_min<S: Simd>(a: Wide<S>) -> f32 {
    let mut l = [0.0; LANES];
    a.store_array(&mut l);
    let (p, q) = (
        lesser(lesser(l[0], l[4]), lesser(l[2], l[6])),
        lesser(lesser(l[1], l[5]), lesser(l[3], l[7])),
    );
    lesser(p, q)
}

/// The largest lane; no lane may be NaN.
#[inline(always)]
pub(crate) fn reduce_max<S: Simd>(a: Wide<S>) -> f32 {
    let mut l = [0.0; LANES];
    a.store_array(&mut l);
    let (p, q) = (
        greater(greater(l[0], l[4]), greater(l[2], l[6])),
        greater(greater(l[1], l[5]), greater(l[3], l[7])),
    );
    greater(p, q)
}

/// Prefetches the cache lines of an item. Affects only time.
#[inline(always)]
pub(crate) fn prefetch<T>(item: &T) {
    prefetch_lines(item, size_of::<T>().div_ceil(64));
}

/// Prefetches the first cache lines of an item.
#[inline(always)]
pub(crate) fn prefetch_lines<T>(item: &T, lines: usize) {
    (0..lines).for_each(|k| prefetch_line(item, k));
}

/// Prefetches the cache line that contains byte 64 k of an item.
#[inline(always)]
pub(crate) fn prefetch_line<T>(item: &T, k: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let line = core::ptr::from_ref(item).cast::<i8>().wrapping_add(64 * k);
        // SAFETY: a prefetch reads nothing and faults at no address; SSE is there on every x86-64.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (item, k);
}

/// `a > b`, lane by lane.
#[inline(always)]
pub(crate) fn above<S: Simd>(a: Wide<S>, b: Wide<S>) -> mask32x8<S> {
    a.simd_gt(b)
}

/// The vector in one lane.
#[inline(always)]
pub(crate) const fn at(lanes: &[Lanes; 3], lane: usize) -> Vec3 {
    Vec3 { x: lanes[0][lane], y: lanes[1][lane], z: lanes[2][lane] }
}

/// Writes the vector of one lane.
#[inline(always)]
pub(crate) const fn put(lanes: &mut [Lanes; 3], lane: usize, v: Vec3) {
    (lanes[0][lane], lanes[1][lane], lanes[2][lane]) = (v.x, v.y, v.z);
}

/// Interleaves the lower halves of `a` and `b`, within each half of four: a0 b0 a1 b1, a4 b4 a5 b5.
/// The compiler makes one instruction of it where the target has one.
#[inline(always)]
fn unpack_low<S: Simd>(a: Wide<S>, b: Wide<S>) -> Wide<S> {
    a.zip_low(b).split().0.combine(a.zip_high(b).split().0)
}

/// Interleaves the upper halves, like [`unpack_low`]: a2 b2 a3 b3, a6 b6 a7 b7.
#[inline(always)]
fn unpack_high<S: Simd>(a: Wide<S>, b: Wide<S>) -> Wide<S> {
    a.zip_low(b).split().1.combine(a.zip_high(b).split().1)
}

/// Combines rows k and k + 4 of eight rows.
#[inline(always)]
fn pair<S: Simd>(simd: S, low: &[f32; 4], high: &[f32; 4]) -> Wide<S> {
    f32x4::load_array_ref(simd, low).combine(f32x4::load_array_ref(simd, high))
}

/// Transposes eight 16-byte rows to four columns, with loads and a transposition in registers.
#[inline(always)]
pub(crate) fn gather4<S: Simd>(simd: S, r: [&[f32; 4]; LANES]) -> [Wide<S>; 4] {
    let (a, b) = (pair(simd, r[0], r[4]), pair(simd, r[1], r[5]));
    let (c, d) = (pair(simd, r[2], r[6]), pair(simd, r[3], r[7]));
    let (p, q) = (unpack_low(a, c), unpack_low(b, d));
    let (s, t) = (unpack_high(a, c), unpack_high(b, d));
    [unpack_low(p, q), unpack_high(p, q), unpack_low(s, t), unpack_high(s, t)]
}

/// Like [`gather4`], for contiguous rows.
#[inline(always)]
pub(crate) fn gather_rows<S: Simd>(simd: S, r: &[[f32; 4]; LANES]) -> [Wide<S>; 4] {
    let mut rows = [&r[0]; LANES];
    for lane in 1..LANES {
        rows[lane] = &r[lane];
    }
    gather4(simd, rows)
}

/// Converts eight 16-byte rows to vectors; ignores the fourth number of each row.
#[inline(always)]
pub(crate) fn gather<S: Simd>(simd: S, r: [&[f32; 4]; LANES]) -> Vec3w<S> {
    let [x, y, z, _] = gather4(simd, r);
    Vec3w { x, y, z }
}

/// Transposes four columns to eight 16-byte rows.
#[inline(always)]
pub(crate) fn scatter4<S: Simd>([x, y, z, w]: [Wide<S>; 4]) -> [f32x4<S>; LANES] {
    let (p, q) = (unpack_low(x, z), unpack_low(y, w));
    let (s, t) = (unpack_high(x, z), unpack_high(y, w));
    let (a, e) = unpack_low(p, q).split();
    let (b, f) = unpack_high(p, q).split();
    let (c, g) = unpack_low(s, t).split();
    let (d, h) = unpack_high(s, t).split();
    [a, b, c, d, e, f, g, h]
}

/// Converts vectors to eight 16-byte rows, with 0 as the fourth number.
#[inline(always)]
pub(crate) fn scatter<S: Simd>(simd: S, v: Vec3w<S>) -> [f32x4<S>; LANES] {
    scatter4([v.x, v.y, v.z, splat(simd, 0.0)])
}

/// A SIMD level of this machine. All levels give the same bits; the engine selects the best one.
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

    /// Name of the level: `avx512`, `avx2`, `sse4.2`, `sse2`, `neon`, `simd128` or `scalar`.
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
