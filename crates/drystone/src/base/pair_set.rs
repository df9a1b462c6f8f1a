//! A set of 64-bit keys: the pairs of shapes that have a contact. It is never iterated, so neither
//! its order nor the order of insertion by several workers can be observed.
#![expect(
    unsafe_code,
    reason = "a copy of keys as plain memory: one by one they are half of what their contacts take"
)]

use core::sync::atomic::{AtomicU64, Ordering};

use super::simd::wide::prefetch;
use super::threads::jobs::{Jobs, for_ranges, grain};

/// Prefetch distance, in keys.
const PREFETCH: usize = 8;

/// Open addressing with linear probing; key 0 is reserved.
#[derive(Debug, Default)]
pub(crate) struct PairSet {
    keys: Vec<AtomicU64>,
    len: usize,
}

impl Clone for PairSet {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Copies into the existing list.
    fn clone_from(&mut self, from: &Self) {
        let n = from.keys.len();
        self.keys.truncate(n);
        self.keys.reserve_exact(n - self.keys.len());
        self.keys.resize_with(n, AtomicU64::default);
        let (to, from_keys) = (self.keys.as_mut_ptr(), from.keys.as_ptr());
        // SAFETY: both lists have `n` keys and are not the same list. Keys are written through a
        // shared set only within `insert_new`, which borrows the set mutably.
        unsafe { core::ptr::copy_nonoverlapping(from_keys, to, n) };
        self.len = from.len;
    }
}

/// The key of an unordered pair of different row numbers.
#[inline]
pub(crate) fn pair_key(a: u32, b: u32) -> u64 {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    (u64::from(low) << 32) | u64::from(high)
}

impl PairSet {
    #[inline]
    fn start(&self, key: u64) -> usize {
        let h = key.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        #[expect(clippy::cast_possible_truncation, reason = "any bits of the hash will do")]
        let h = (h ^ (h >> 32)) as usize;
        h & (self.keys.len() - 1)
    }

    const fn after(&self, place: usize) -> usize {
        (place + 1) & (self.keys.len() - 1)
    }

    #[inline]
    fn at(&self, place: usize) -> u64 {
        self.keys[place].load(Ordering::Relaxed)
    }

    #[inline]
    fn put(&mut self, place: usize, key: u64) {
        *self.keys[place].get_mut() = key;
    }

    #[inline]
    pub(crate) fn contains(&self, key: u64) -> bool {
        if self.keys.is_empty() {
            return false;
        }
        let mut i = self.start(key);
        loop {
            match self.at(i) {
                0 => return false,
                k if k == key => return true,
                _ => i = self.after(i),
            }
        }
    }

    /// Prefetches the slot of a key. Affects only time.
    #[inline]
    pub(crate) fn prefetch(&self, key: u64) {
        if !self.keys.is_empty() {
            prefetch(&self.keys[self.start(key)]);
        }
    }

    /// Adds `key`; returns false if it was already in the set.
    pub(crate) fn insert(&mut self, key: u64) -> bool {
        if 2 * (self.len + 1) > self.keys.len() {
            self.grow(self.len + 1, &Jobs::Inline);
        }
        let mut i = self.start(key);
        loop {
            match self.at(i) {
                0 => break,
                k if k == key => return false,
                _ => i = self.after(i),
            }
        }
        self.put(i, key);
        self.len += 1;
        true
    }

    /// Adds keys that are not yet in the set; each key occurs once.
    pub(crate) fn insert_new(&mut self, keys: &[u64], jobs: &Jobs<'_>) {
        let len = self.len + keys.len();
        if 2 * len > self.keys.len() {
            self.grow(len, jobs);
        }
        self.claim_all(keys, |key| *key, jobs);
        self.len = len;
    }

    /// Claims a slot for each key. A world of one thread needs no atomic exchange for this.
    fn claim_all<T: Sync>(&mut self, keys: &[T], key: impl Fn(&T) -> u64 + Sync, jobs: &Jobs<'_>) {
        let alone = jobs.workers() == 1;
        let set = &*self;
        for_ranges(jobs, keys.len(), grain(jobs, keys.len(), 64), |range| {
            for k in range {
                if let Some(soon) = keys.get(k + PREFETCH) {
                    set.prefetch(key(soon));
                }
                match key(&keys[k]) {
                    0 => {}
                    key => set.claim(key, alone),
                }
            }
        });
    }

    fn claim(&self, key: u64, alone: bool) {
        let mut i = self.start(key);
        loop {
            if self.at(i) == 0 {
                if alone {
                    self.keys[i].store(key, Ordering::Relaxed);
                    return;
                }
                let place = &self.keys[i];
                if place.compare_exchange(0, key, Ordering::Relaxed, Ordering::Relaxed).is_ok() {
                    return;
                }
            }
            i = self.after(i);
        }
    }

    pub(crate) fn remove(&mut self, key: u64) {
        if self.keys.is_empty() {
            return;
        }
        let mut hole = self.start(key);
        while self.at(hole) != key {
            if self.at(hole) == 0 {
                return;
            }
            hole = self.after(hole);
        }
        self.len -= 1;
        // Closes the gap: moves back every later key of the run that may stand in the hole.
        let mut i = hole;
        loop {
            self.put(hole, 0);
            loop {
                i = self.after(i);
                if self.at(i) == 0 {
                    return;
                }
                let home = self.start(self.at(i));
                let stays =
                    if hole <= i { hole < home && home <= i } else { hole < home || home <= i };
                if !stays {
                    break;
                }
            }
            self.put(hole, self.at(i));
            hole = i;
        }
    }

    /// Grows the table for `len` keys in total.
    fn grow(&mut self, len: usize, jobs: &Jobs<'_>) {
        let room = (2 * len).next_power_of_two().max(64);
        let new = core::iter::repeat_with(AtomicU64::default).take(room).collect();
        let old = core::mem::replace(&mut self.keys, new);
        self.claim_all(&old, |key| key.load(Ordering::Relaxed), jobs);
    }
}

#[cfg(test)]
mod tests {
    use core::ops::Range;

    use super::{PairSet, pair_key};
    use crate::base::threads::jobs::Jobs;
    use crate::base::threads::team::Team;

    #[test]
    fn pairs_come_and_go() {
        let mut set = PairSet::default();
        for i in 0..500 {
            assert!(set.insert(pair_key(i, i + 7)) && !set.insert(pair_key(i + 7, i)));
        }
        for i in (0..500).step_by(3) {
            set.remove(pair_key(i, i + 7));
        }
        for i in 0..500 {
            assert_eq!(set.contains(pair_key(i, i + 7)), i % 3 != 0, "{i}");
        }
    }

    #[test]
    fn many_come_at_once_whoever_adds_them() {
        let key = |i: u32| pair_key(i, i * 7 + 1);
        let keys = |range: Range<u32>| range.map(key).collect::<Vec<_>>();
        let holds = |set: &PairSet, ranges: [Range<u32>; 2]| {
            let there = |i| ranges.iter().any(|range| range.contains(&i));
            (0..60_000).all(|i| set.contains(key(i)) == there(i))
        };
        for workers in 1..=4 {
            let (team, mut set) = (Team::new(workers), PairSet::default());
            // Into a table that grows, and one that has space.
            for range in [1..10_000, 10_000..15_000, 15_000..30_000, 40_000..41_000] {
                set.insert_new(&keys(range), &Jobs::Team(&team));
            }
            assert!(holds(&set, [1..30_000, 40_000..41_000]));
            keys(15_000..40_000).into_iter().for_each(|key| set.remove(key));
            assert!(holds(&set, [1..15_000, 40_000..41_000]));
        }
    }
}
