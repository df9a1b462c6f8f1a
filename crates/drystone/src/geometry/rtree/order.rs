//! The order of leaves: along a Hilbert curve through their centers, very large boxes last.

use crate::base::aabb::Aabb;
use crate::base::grow::Slack;
use crate::base::math::Vec3;
use crate::base::threads::jobs::{Jobs, for_items, for_runs, grain};

/// Bits per axis: 2^11 cells of the curve, so that a key and an index fit in 64 bits.
const BITS: u32 = 11;
const PLACE_BITS: u32 = 30;
/// Width of the curve's cube, in mean deviations from the mean center; centers outside are clamped
/// to its border. One body that fell off the world then does not squeeze all others into one cell.
const SPREAD: f64 = 8.0;
/// Boxes this many powers of two above the mean size are kept apart: every query would hit them in
/// the blocks of small boxes.
const LARGE: i64 = 3;
/// Number of runs in which keys are sorted in parallel and then merged. It is fixed, and keys
/// differ, so the result does not depend on the threads.
const RUNS: usize = 8;

/// Memory reused from build to build.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    boxes: Vec<(u32, Aabb)>,
    keys: Vec<u64>,
    merged: Vec<u64>,
    slack: Slack,
}

impl Scratch {
    /// Collects the leaves from `start` on, without holes.
    pub(super) fn collect(&mut self, items: &[u32], start: usize, bounds: impl Fn(usize) -> Aabb) {
        self.boxes.clear();
        for (leaf, item) in items.iter().enumerate().skip(start) {
            if *item != super::NONE {
                self.boxes.push((*item, bounds(leaf)));
            }
        }
    }

    /// Clears the last build, and frees memory that only few builds need.
    pub(super) fn settle(&mut self) {
        let Self { boxes, keys, merged, slack } = self;
        let enough = slack.look(boxes.len());
        boxes.clear();
        keys.clear();
        merged.clear();
        if let Some(enough) = enough {
            boxes.shrink_to(enough);
            keys.shrink_to(enough);
            merged.shrink_to(enough);
        }
    }

    pub(super) const fn len(&self) -> usize {
        self.boxes.len()
    }

    /// Item and box at an index of the order.
    pub(super) fn at(&self, place: usize) -> (u32, Aabb) {
        let index = (self.keys[place] & ((1 << PLACE_BITS) - 1)) as usize;
        self.boxes[index]
    }

    /// Computes the order.
    pub(super) fn sort(&mut self, jobs: &Jobs<'_>) {
        let Self { boxes, keys, merged, .. } = self;
        let n = boxes.len();
        keys.clear();
        keys.resize(n, 0);
        if n == 0 {
            return;
        }
        let large = mean_exponent(boxes) + LARGE;
        let (middle, spread) = middle_of(boxes, large);
        #[expect(clippy::cast_possible_truncation, reason = "rounding is harmless")]
        let scale =
            if spread > 0.0 { (f64::from(1_u32 << BITS) / (SPREAD * spread)) as f32 } else { 0.0 };
        for_items(jobs, keys, grain(jobs, n, 1024), |first, keys| {
            for ((place, (_, b)), key) in (first as u64..).zip(&boxes[first..]).zip(keys) {
                let behind = u64::from(exponent(b) > large);
                let curve = hilbert(cell(b.center() - middle, scale));
                *key = (((behind << (3 * BITS)) | curve) << PLACE_BITS) | place;
            }
        });
        let run = n.div_ceil(RUNS).max(1024);
        if n > run {
            for_runs(jobs, keys, run, |_, keys| keys.sort_unstable());
            merge_runs(keys, merged, run, jobs);
        } else {
            keys.sort_unstable();
        }
    }
}

/// Merges sorted runs of `run` keys until one run is left.
fn merge_runs(keys: &mut Vec<u64>, merged: &mut Vec<u64>, mut run: usize, jobs: &Jobs<'_>) {
    let n = keys.len();
    merged.clear();
    merged.resize(n, 0);
    while run < n {
        let from = &*keys;
        for_runs(jobs, merged, 2 * run, |k, to| {
            let low = 2 * k * run;
            let (middle, high) = ((low + run).min(n), low + to.len());
            let (mut a, mut b) = (low, middle);
            for out in to {
                let first = b >= high || (a < middle && from[a] <= from[b]);
                *out = if first { from[a] } else { from[b] };
                a += usize::from(first);
                b += usize::from(!first);
            }
        });
        core::mem::swap(keys, merged);
        run *= 2;
    }
}

/// Binary exponent of the longest edge.
fn exponent(b: &Aabb) -> i64 {
    i64::from((b.max - b.min).max_element().to_bits() >> 23)
}

fn mean_exponent(boxes: &[(u32, Aabb)]) -> i64 {
    let sum: i64 = boxes.iter().map(|(_, b)| exponent(b)).sum();
    sum / i64::try_from(boxes.len().max(1)).unwrap_or(i64::MAX)
}

/// Mean of the centers of boxes that are not large, and the maximum mean deviation along an axis.
fn middle_of(boxes: &[(u32, Aabb)], large: i64) -> (Vec3, f64) {
    let centers = || boxes.iter().filter(|(_, b)| exponent(b) <= large).map(|(_, b)| b.center());
    let (mut sum, mut n) = ([0.0_f64; 3], 0.0);
    for c in centers() {
        for i in 0..3 {
            sum[i] += f64::from(c[i]);
        }
        n += 1.0;
    }
    if n == 0.0 {
        return (Vec3::ZERO, 0.0);
    }
    let mean = sum.map(|s| s / n);
    let mut deviation = [0.0_f64; 3];
    for c in centers() {
        for i in 0..3 {
            deviation[i] += (f64::from(c[i]) - mean[i]).abs();
        }
    }
    #[expect(clippy::cast_possible_truncation, reason = "rounding is harmless")]
    let middle = Vec3 { x: mean[0] as f32, y: mean[1] as f32, z: mean[2] as f32 };
    let maximum = deviation.iter().fold(0.0_f64, |a, b| if *b > a { *b } else { a });
    (middle, maximum / n)
}

fn cell(from_middle: Vec3, scale: f32) -> [u32; 3] {
    const MAX: f32 = 2047.0;
    let mut cell = [0; 3];
    for i in 0..3 {
        let x = from_middle[i] * scale + 1024.0;
        // NaN becomes 0.
        let x = if x > 0.0 { x } else { 0.0 };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let x = if x < MAX { x as u32 } else { MAX as u32 };
        cell[i] = x;
    }
    cell
}

/// Index of a cell on the curve, by the transform of [Skilling04], without branches.
fn hilbert(mut x: [u32; 3]) -> u64 {
    for bit in (1..BITS).rev() {
        let below = (1 << bit) - 1;
        for i in 0..3 {
            let set = 0_u32.wrapping_sub((x[i] >> bit) & 1);
            let swap = (x[0] ^ x[i]) & below & !set;
            x[0] ^= (below & set) ^ swap;
            x[i] ^= swap;
        }
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut turn = 0;
    for bit in 1..BITS {
        turn ^= ((1 << bit) - 1) & 0_u32.wrapping_sub((x[2] >> bit) & 1);
    }
    (spread(x[0] ^ turn) << 2) | (spread(x[1] ^ turn) << 1) | spread(x[2] ^ turn)
}

/// Moves bit k to bit 3 k.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x) & 0x1f_ffff;
    x = (x | (x << 32)) & 0x001f_0000_0000_ffff;
    x = (x | (x << 16)) & 0x001f_0000_ff00_00ff;
    x = (x | (x << 8)) & 0x100f_00f0_0f00_f00f;
    x = (x | (x << 4)) & 0x10c3_0c30_c30c_30c3;
    (x | (x << 2)) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::{BITS, hilbert};

    #[test]
    fn neighbors_on_the_curve_are_neighbors_in_space() {
        // The curve through the 16³ cells nearest the origin: its first 4096 indices.
        let mut cells: Vec<(u64, [u32; 3])> = Vec::new();
        for x in 0..16 {
            for y in 0..16 {
                for z in 0..16 {
                    cells.push((hilbert([x, y, z]), [x, y, z]));
                }
            }
        }
        cells.sort_unstable();
        for (place, pair) in (0_u64..).zip(cells.windows(2)) {
            let ((a, from), (b, to)) = (pair[0], pair[1]);
            assert_eq!((a, b), (place, place + 1));
            let steps: u32 = (0..3).map(|i| from[i].abs_diff(to[i])).sum();
            assert_eq!(steps, 1, "{from:?} {to:?}");
        }
        assert!(hilbert([2047; 3]) < 1 << (3 * BITS));
    }
}
