//! Eight bounding boxes, tested at once. Plain arrays: a lane never depends on its neighbor, so the
//! compiler turns each loop into the target's vector instructions, and the result is the same
//! everywhere.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater, lesser};
use crate::base::simd::wide::{LANES, Lanes, at, bits_up_to_zero, put};

/// Rounding allowance of [`Aabb::meets_ray`].
const ROUNDING: f32 = 1.0 + 4.0 * f32::EPSILON;

/// A segment `origin + t delta` from `t = 0` [m], or a box with this motion, prepared for tests
/// with boxes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    /// Corners of the moving box at the start; both equal for a segment.
    low: Vec3,
    high: Vec3,
    /// 1/delta per component, infinite where that is zero.
    inv: Vec3,
}

impl Ray {
    pub(crate) fn new(origin: Vec3, delta: Vec3) -> Self {
        Self::of_box(&Aabb::new(origin, origin), delta)
    }

    pub(crate) fn of_box(bounds: &Aabb, delta: Vec3) -> Self {
        let inv = Vec3 { x: 1.0 / delta.x, y: 1.0 / delta.y, z: 1.0 / delta.z };
        Self { low: bounds.min, high: bounds.max, inv }
    }
}

/// Eight boxes; a free lane holds the empty box, which overlaps nothing.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Boxes {
    /// Indexed by coordinate, then box [m].
    pub(crate) min: [Lanes; 3],
    pub(crate) max: [Lanes; 3],
}

impl Boxes {
    pub(crate) const EMPTY: Self =
        Self { min: [[f32::INFINITY; LANES]; 3], max: [[f32::NEG_INFINITY; LANES]; 3] };

    #[inline]
    pub(crate) fn set(&mut self, lane: usize, b: &Aabb) {
        put(&mut self.min, lane, b.min);
        put(&mut self.max, lane, b.max);
    }

    #[inline]
    pub(crate) fn get(&self, lane: usize) -> Aabb {
        Aabb::new(at(&self.min, lane), at(&self.max, lane))
    }

    /// Bounding box of all eight.
    #[inline]
    pub(crate) fn bounds(&self) -> Aabb {
        let mut all = Aabb::EMPTY;
        for i in 0..3 {
            let (mut low, mut high) = (self.min[i], self.max[i]);
            for half in [4, 2, 1] {
                for l in 0..half {
                    low[l] = lesser(low[l], low[l + half]);
                    high[l] = greater(high[l], high[l + half]);
                }
            }
            (all.min[i], all.max[i]) = (low[0], high[0]);
        }
        all
    }

    /// Fraction at which a ray enters each box; infinite where it does not hit it within `max`. The
    /// results equal those of [`Aabb::meets_ray`].
    #[inline]
    pub(crate) fn entries(&self, ray: &Ray, max: f32) -> Lanes {
        let (mut near, mut high) = ([0.0; LANES], [max; LANES]);
        for i in 0..3 {
            let (first, last, k) = (ray.low[i], ray.high[i], ray.inv[i]);
            let (from, to) = (&self.min[i], &self.max[i]);
            // The branch is outside the lane loops: inside, compilers process lanes one by one.
            if k.is_infinite() {
                for l in 0..LANES {
                    high[l] = if last < from[l] || first > to[l] { -1.0 } else { high[l] };
                }
                continue;
            }
            for l in 0..LANES {
                let (a, b) = ((from[l] - last) * k, (to[l] - first) * k);
                near[l] = greater(near[l], lesser(a, b));
                high[l] = lesser(high[l], greater(a, b));
            }
        }
        for l in 0..LANES {
            // Free lanes compute infinity minus infinity.
            let met = self.min[0][l] <= self.max[0][l] && near[l] <= high[l] * ROUNDING;
            near[l] = if met { near[l] } else { f32::INFINITY };
        }
        near
    }

    /// Bit mask of the boxes that overlap `b`.
    #[inline]
    pub(crate) fn overlaps(&self, b: &Aabb) -> u32 {
        let mut apart = [f32::NEG_INFINITY; LANES];
        for i in 0..3 {
            let (low, high) = (b.min[i], b.max[i]);
            for l in 0..LANES {
                apart[l] = greater(greater(self.min[i][l] - high, low - self.max[i][l]), apart[l]);
            }
        }
        bits_up_to_zero(&apart)
    }
}

/// Calls `f` with each lane that a ray enters, the nearest first, while its entry is not beyond
/// `max`. `near` holds the entries; infinite means no hit. `f` may shorten `max`; negative: stop.
#[inline]
pub(crate) fn nearest_first(mut near: Lanes, max: &mut f32, mut f: impl FnMut(usize, &mut f32)) {
    while *max >= 0.0 {
        let mut first = 0;
        for lane in 1..LANES {
            if near[lane] < near[first] {
                first = lane;
            }
        }
        // An infinite entry is no hit, or visited already; the end of a very long ray may be
        // infinite too.
        if !(near[first] <= *max * ROUNDING) || near[first].is_infinite() {
            return;
        }
        near[first] = f32::INFINITY;
        f(first, max);
    }
}
