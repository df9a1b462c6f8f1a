//! A dynamic tree of bounding boxes: a packed R-tree, eight boxes per block, its leaves sorted
//! along a Hilbert curve [Kamel94] [Skilling04].
//!
//! Block `b` of a level holds the boxes of blocks `8 b .. 8 b + 8` of the level below. There are no
//! pointers, and one test covers eight children. Moved boxes are refitted in place; the order is
//! computed again only when the boxes of the blocks have grown. New boxes stand behind the sorted
//! leaves until [`RTree::tidy`] sorts them into sections of decreasing size. This is the
//! logarithmic method [Bentley80]: adding one box to a million costs the logarithm, not the
//! million.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

mod order;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::base::aabb::Aabb;
use crate::base::grow;
use crate::base::math::Vec3;
use crate::base::simd::wide::LANES;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, for_items, grain};
use crate::geometry::boxes::{Boxes, Ray, nearest_first};

const NONE: u32 = u32::MAX;
/// Maximum number of levels: blocks of eight, and items are numbered by 32 bits.
const MAX_LEVELS: usize = 11;
/// Growth factor of the blocks at which the order is computed again. Queries slow down roughly in
/// proportion to it. At 1.2 rebuilding costs more than it saves; at 3 the queries do.
const WORN: f64 = 1.6;
/// Tree of items' boxes; an item is a small number of the caller's.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct RTree {
    /// `levels[0]` holds the leaves; the last level has one block.
    levels: Vec<Vec<Boxes>>,
    /// The item of each leaf; [`NONE`] for a free leaf.
    items: Vec<u32>,
    /// The leaf of each item.
    leaf_of: Vec<u32>,
    len: usize,
    /// First leaves of the sorted sections, and the start of the unsorted rest.
    sections: Vec<u32>,
    sorted: usize,
    /// Number of leaves changed since the last check of the blocks' sizes.
    stirred: usize,
    /// Surface area of the lowest blocks per leaf at the last build.
    fresh: f64,
    #[cfg_attr(feature = "serde", serde(skip))]
    scratch: order::Scratch,
    /// Levels that a smaller tree does not need, kept for their memory.
    #[cfg_attr(feature = "serde", serde(skip))]
    spare: Vec<Vec<Boxes>>,
}

impl Clone for RTree {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Copies into the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { levels, items, leaf_of, sections, len, sorted, stirred, fresh, .. } = from;
        // A tree that grows again reuses its upper levels.
        let fewer = levels.len().min(self.levels.len());
        self.spare.extend(self.levels.drain(fewer..));
        self.levels.extend((fewer..levels.len()).map(|_| self.spare.pop().unwrap_or_default()));
        self.levels.clone_from(levels);
        self.items.clone_from(items);
        self.leaf_of.clone_from(leaf_of);
        self.sections.clone_from(sections);
        self.len = *len;
        self.sorted = *sorted;
        self.stirred = *stirred;
        self.fresh = *fresh;
    }
}

impl RTree {
    /// Number of items.
    pub(crate) const fn len(&self) -> usize {
        self.len
    }

    /// All items, in the order of the leaves: items near in space are near in the list.
    pub(crate) fn items(&self) -> impl Iterator<Item = u32> {
        self.items.iter().copied().filter(|item| *item != NONE)
    }

    /// The leaf of an item; items near in space have close numbers.
    #[inline]
    pub(crate) fn leaf(&self, item: u32) -> u32 {
        self.leaf_of.get(item as usize).copied().unwrap_or(NONE)
    }

    /// Returns true if items and leaves refer to each other, and every level has the blocks that
    /// the one below needs.
    pub(crate) fn is_valid(&self) -> bool {
        let leaves = self.items.len();
        let is_leaf = |(leaf, item): (u32, &u32)| *item == NONE || self.leaf(*item) == leaf;
        let named = self.leaf_of.iter().filter(|leaf| **leaf != NONE).count();
        let mut blocks = leaves;
        let mut is_level = |level: &Vec<Boxes>| {
            blocks = blocks.div_ceil(LANES);
            level.len() == blocks
        };
        let levels =
            self.levels.len() <= MAX_LEVELS && self.levels.iter().all(&mut is_level) && blocks <= 1;
        let sections = self.sections.is_sorted_by(|a, b| a < b)
            && self.sections.last().is_none_or(|last| (*last as usize) < self.sorted);
        let items = (0..).zip(&self.items).all(is_leaf);
        let count = self.items().count();
        levels && sections && items && self.sorted <= leaves && count == self.len && named == count
    }

    /// Adds a box for `item`.
    pub(crate) fn insert(&mut self, bounds: &Aabb, item: u32) {
        let leaf = u32::try_from(self.items.len()).expect("fewer than 2^30 shapes fit in memory");
        let index = item as usize;
        if index >= self.leaf_of.len() {
            self.leaf_of.resize(index + 1, NONE);
        }
        self.leaf_of[index] = leaf;
        self.items.push(item);
        self.len += 1;
        self.fit_levels();
        let mut at = leaf as usize;
        for level in &mut self.levels {
            let block = &mut level[at / LANES];
            let grown = block.get(at % LANES).union(bounds);
            block.set(at % LANES, &grown);
            at /= LANES;
        }
    }

    /// Moves all boxes to coordinates relative to another origin [m].
    pub(crate) fn shift(&mut self, origin: Vec3) {
        for block in self.levels.iter_mut().flatten() {
            for lane in 0..LANES {
                let there = block.get(lane).told_from(origin);
                block.set(lane, &there);
            }
        }
    }

    /// Removes an item.
    pub(crate) fn remove(&mut self, item: u32) {
        let leaf = core::mem::replace(&mut self.leaf_of[item as usize], NONE);
        self.items[leaf as usize] = NONE;
        self.len -= 1;
        self.stirred += 1;
        self.set_leaf(leaf, &Aabb::EMPTY);
    }

    /// Replaces the box of an item.
    pub(crate) fn replace(&mut self, item: u32, bounds: &Aabb) {
        let leaf = self.leaf_of[item as usize];
        let old = self.levels[0][leaf as usize / LANES].get(leaf as usize % LANES);
        if old.overlaps(bounds) {
            self.stirred += 1;
            self.set_leaf(leaf, bounds);
        } else {
            // The item moved far away, and would only enlarge its old block.
            self.remove(item);
            self.insert(bounds, item);
        }
    }

    /// Replaces the boxes of many items. Items must differ.
    pub(crate) fn replace_all(&mut self, boxes: &[(u32, Aabb)], jobs: &Jobs<'_>) {
        // A full refit costs about 3 ns per leaf, the path up from one leaf about 100 ns.
        if boxes.len() * 32 < self.items.len() {
            for (item, bounds) in boxes {
                self.stirred += 1;
                self.set_leaf(self.leaf_of[*item as usize], bounds);
            }
            return;
        }
        for (item, bounds) in boxes {
            let leaf = self.leaf_of[*item as usize] as usize;
            self.levels[0][leaf / LANES].set(leaf % LANES, bounds);
        }
        self.stirred += boxes.len();
        self.refit(1, 0, jobs);
    }

    fn set_leaf(&mut self, leaf: u32, bounds: &Aabb) {
        let mut at = leaf as usize;
        let mut bounds = *bounds;
        for level in &mut self.levels {
            let block = &mut level[at / LANES];
            if block.get(at % LANES) == bounds {
                return;
            }
            block.set(at % LANES, &bounds);
            bounds = block.bounds();
            at /= LANES;
        }
    }

    /// Adapts the number of blocks of all levels to the number of leaves.
    fn fit_levels(&mut self) {
        let mut n = self.items.len();
        let mut k = 0;
        while n > 1 || k == 0 {
            n = n.div_ceil(LANES);
            if k == self.levels.len() {
                self.levels.push(Vec::new());
                if k > 0 && n > 0 {
                    // A new root: the former single block is its first child.
                    let below = self.levels[k - 1][0].bounds();
                    let mut root = Boxes::EMPTY;
                    root.set(0, &below);
                    self.levels[k].push(root);
                }
            }
            grow::resize(&mut self.levels[k], n, Boxes::EMPTY);
            k += 1;
        }
        self.levels.truncate(k);
    }

    /// Computes the blocks of level `from` and above from those below, right of leaf `first`.
    fn refit(&mut self, from: usize, first: usize, jobs: &Jobs<'_>) {
        let mut start = first;
        for k in 1..self.levels.len() {
            start /= LANES;
            if k < from {
                continue;
            }
            let (below, above) = self.levels.split_at_mut(k);
            let (below, blocks) = (&below[k - 1], &mut above[0][start / LANES..]);
            let offset = start / LANES;
            for_items(jobs, blocks, grain(jobs, below.len(), 512), |at, blocks| {
                for (b, block) in blocks.iter_mut().enumerate() {
                    let first = (offset + at + b) * LANES;
                    *block = Boxes::EMPTY;
                    for (lane, child) in below[first..].iter().take(LANES).enumerate() {
                        block.set(lane, &child.bounds());
                    }
                }
            });
        }
    }

    /// Surface area of the lowest blocks per leaf.
    fn wear(&self) -> f64 {
        let Some(parents) = self.levels.get(1) else { return 0.0 };
        let mut sum = 0.0;
        for parent in parents {
            for lane in 0..LANES {
                let b = parent.get(lane);
                // Half-spaces have infinite boxes, which do not count.
                if b.min.x <= b.max.x && b.half_area() < 1.0e20 {
                    sum += f64::from(b.half_area());
                }
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "a mean")]
        let n = self.len.max(1) as f64;
        sum / n
    }

    /// Restores the order of the tree where needed. Call it before many queries.
    pub(crate) fn tidy(&mut self, jobs: &Jobs<'_>) {
        self.scratch.settle();
        let holes = self.items.len() - self.len;
        if holes > 64 && holes > self.len {
            self.build(0, jobs);
        } else if self.items.len() - self.sorted >= LANES {
            self.sort_in(jobs);
        }
        if self.stirred * 4 > self.len && self.len > 4 * LANES {
            self.stirred = 0;
            if self.wear() > WORN * self.fresh {
                self.build(0, jobs);
            }
        }
    }

    /// Sorts the unsorted leaves into one section, with the sections before it that are not much
    /// larger.
    fn sort_in(&mut self, jobs: &Jobs<'_>) {
        let n = self.items.len();
        let mut start = self.sorted;
        while let Some(&first) = self.sections.last() {
            if start - first as usize > 2 * (n - start) {
                break;
            }
            self.sections.pop();
            start = first as usize;
        }
        self.build(start, jobs);
    }

    /// Sorts the leaves from `start` on, without holes, and computes their blocks.
    fn build(&mut self, start: usize, jobs: &Jobs<'_>) {
        // A section starts with a new block, apart from the rest of the section before it.
        self.scratch
            .collect(&self.items, start, |leaf| self.levels[0][leaf / LANES].get(leaf % LANES));
        self.scratch.sort(jobs);
        let n = start + self.scratch.len();
        self.items.truncate(start);
        self.items.resize(n, NONE);
        let fewer = n.div_ceil(LANES);
        self.levels[0].truncate(fewer);
        self.fit_levels();
        let (sorted, blocks) = (&self.scratch, &mut self.levels[0]);
        // SAFETY: each leaf belongs to one block, and each item to one leaf.
        let apart = unsafe { Apart::promise() };
        let items = Rows::new(&mut self.items, apart);
        let leaf_of = Rows::new(&mut self.leaf_of, apart);
        let first = start / LANES;
        let blocks = &mut blocks[first..];
        for_items(jobs, blocks, grain(jobs, blocks.len(), 256), |at, blocks| {
            for (b, block) in blocks.iter_mut().enumerate() {
                let base = (first + at + b) * LANES;
                for lane in 0..LANES {
                    let leaf = base + lane;
                    if leaf < start {
                        continue;
                    }
                    if leaf >= n {
                        block.set(lane, &Aabb::EMPTY);
                        continue;
                    }
                    let (item, bounds) = sorted.at(leaf - start);
                    block.set(lane, &bounds);
                    *items.row(leaf) = item;
                    #[expect(clippy::cast_possible_truncation, reason = "leaves are u32")]
                    let number = leaf as u32;
                    *leaf_of.row(item as usize) = number;
                }
            }
        });
        self.refit(1, start, jobs);
        self.sections.retain(|s| (*s as usize) < start);
        if n > start {
            self.sections.push(u32::try_from(start).expect("leaves are u32"));
        }
        self.sorted = n;
        if start == 0 {
            self.stirred = 0;
            self.fresh = self.wear();
        }
    }

    /// Calls `visit` with every item whose box overlaps `bounds`, until it returns false.
    #[inline]
    pub(crate) fn query(&self, bounds: &Aabb, visit: impl FnMut(u32) -> bool) {
        self.query_inline(bounds, visit);
    }

    /// [`Self::query`], for callers that are compiled for a SIMD level. A stack of masks replaces
    /// recursion, because a recursive function is not inlined.
    #[inline(always)]
    pub(crate) fn query_inline(&self, bounds: &Aabb, mut visit: impl FnMut(u32) -> bool) {
        let Some(top) = self.levels.len().checked_sub(1) else { return };
        let overlaps = |level: usize, block: usize| {
            self.levels[level].get(block).map_or(0, |block| block.overlaps(bounds))
        };
        // The block of each level, and its children that are still to be visited.
        let (mut blocks, mut masks) = ([0; MAX_LEVELS], [0; MAX_LEVELS]);
        let mut level = top;
        masks[top] = overlaps(top, 0);
        loop {
            let mask = masks[level];
            if mask == 0 {
                if level == top {
                    return;
                }
                level += 1;
                continue;
            }
            masks[level] = mask & (mask - 1);
            let child = blocks[level] * LANES + mask.trailing_zeros() as usize;
            if level > 0 {
                level -= 1;
                (blocks[level], masks[level]) = (child, overlaps(level, child));
            } else if self.items.get(child).is_some_and(|item| *item != NONE && !visit(*item)) {
                return;
            }
        }
    }

    /// Number of leaf blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.levels.first().map_or(0, Vec::len)
    }

    /// Calls `visit` with every pair of items whose boxes overlap, if the first is in this leaf
    /// block and the second behind it. Over all blocks this gives every pair once. Eight items
    /// descend the tree together.
    #[inline]
    pub(crate) fn pairs_of(&self, block: usize, mut visit: impl FnMut(u32, u32)) {
        let Some(own) = self.levels.first().and_then(|leaves| leaves.get(block)) else { return };
        let mut see = |a: usize, b: usize| {
            if let (Some(&a), Some(&b)) = (self.items.get(a), self.items.get(b))
                // A box that is not finite may overlap free leaves too.
                && a != NONE
                && b != NONE
            {
                visit(a, b);
            }
        };
        for lane in 0..LANES - 1 {
            let mut mask = own.overlaps(&own.get(lane)) & (u32::MAX << (lane + 1));
            while mask != 0 {
                see(block * LANES + lane, block * LANES + mask.trailing_zeros() as usize);
                mask &= mask - 1;
            }
        }
        if self.levels.len() > 1 {
            self.pairs_below(self.levels.len() - 1, 0, block, own, &own.bounds(), &mut see);
        }
    }

    /// [`Self::pairs_of`] for the leaves under a block above the leaf level.
    fn pairs_below(
        &self,
        level: usize,
        index: usize,
        block: usize,
        own: &Boxes,
        bounds: &Aabb,
        visit: &mut impl FnMut(usize, usize),
    ) {
        let Some(above) = self.levels[level].get(index) else { return };
        // The child that holds the block itself, if it is here; children before it were processed
        // earlier.
        let own_child = block >> (3 * (level - 1));
        let mut mask = above.overlaps(bounds);
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            let child = index * LANES + lane;
            mask &= mask - 1;
            if level > 1 {
                if child >= own_child {
                    self.pairs_below(level - 1, child, block, own, bounds, visit);
                }
                continue;
            }
            if child <= block {
                continue;
            }
            let Some(other) = self.levels[0].get(child) else { continue };
            let mut mine = own.overlaps(&above.get(lane));
            while mine != 0 {
                let a = mine.trailing_zeros() as usize;
                mine &= mine - 1;
                let mut theirs = other.overlaps(&own.get(a));
                while theirs != 0 {
                    visit(block * LANES + a, child * LANES + theirs.trailing_zeros() as usize);
                    theirs &= theirs - 1;
                }
            }
        }
    }

    /// Calls `visit` with every item whose box the segment or moving box may hit, up to the
    /// fraction `max`, near blocks first. `visit` returns the new max: smaller to shorten the ray,
    /// negative to stop.
    pub(crate) fn ray(&self, ray: &Ray, max_fraction: f32, mut visit: impl FnMut(u32) -> f32) {
        let mut max = max_fraction;
        if let Some(top) = self.levels.len().checked_sub(1) {
            self.ray_block(top, 0, ray, &mut max, &mut visit);
        }
    }

    fn ray_block(
        &self,
        level: usize,
        index: usize,
        ray: &Ray,
        max: &mut f32,
        visit: &mut impl FnMut(u32) -> f32,
    ) {
        let Some(block) = self.levels[level].get(index) else { return };
        nearest_first(block.entries(ray, *max), max, |lane, max| {
            let child = index * LANES + lane;
            if level > 0 {
                self.ray_block(level - 1, child, ray, max, visit);
            } else if let Some(&item) = self.items.get(child)
                && item != NONE
            {
                *max = visit(item);
            }
        });
    }
}

#[cfg(test)]
mod tests;
