//! A set of 64-bit keys: which pairs of shapes have a contact. Never iterated, so its order cannot
//! be observed.

use super::wide::prefetch;

/// Open addressing with linear probing; key 0 is reserved.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairSet {
    keys: Vec<u64>,
    len: usize,
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

    #[inline]
    pub(crate) fn contains(&self, key: u64) -> bool {
        if self.keys.is_empty() {
            return false;
        }
        let mut i = self.start(key);
        loop {
            match self.keys[i] {
                0 => return false,
                k if k == key => return true,
                _ => i = (i + 1) & (self.keys.len() - 1),
            }
        }
    }

    /// Asks for the place of a key, which will be needed soon. Changes nothing but time.
    #[inline]
    pub(crate) fn prefetch(&self, key: u64) {
        if !self.keys.is_empty() {
            prefetch(&self.keys[self.start(key)]);
        }
    }

    /// Adds `key`; false if it was there.
    pub(crate) fn insert(&mut self, key: u64) -> bool {
        if 2 * (self.len + 1) > self.keys.len() {
            self.grow();
        }
        let mut i = self.start(key);
        loop {
            match self.keys[i] {
                0 => break,
                k if k == key => return false,
                _ => i = (i + 1) & (self.keys.len() - 1),
            }
        }
        self.keys[i] = key;
        self.len += 1;
        true
    }

    pub(crate) fn remove(&mut self, key: u64) {
        if self.keys.is_empty() {
            return;
        }
        let mask = self.keys.len() - 1;
        let mut hole = self.start(key);
        while self.keys[hole] != key {
            if self.keys[hole] == 0 {
                return;
            }
            hole = (hole + 1) & mask;
        }
        self.len -= 1;
        // Close the gap: pull back every later key of the run that may stand in the hole.
        let mut i = hole;
        loop {
            self.keys[hole] = 0;
            loop {
                i = (i + 1) & mask;
                if self.keys[i] == 0 {
                    return;
                }
                let home = self.start(self.keys[i]);
                let stays =
                    if hole <= i { hole < home && home <= i } else { hole < home || home <= i };
                if !stays {
                    break;
                }
            }
            self.keys[hole] = self.keys[i];
            hole = i;
        }
    }

    fn grow(&mut self) {
        let old = core::mem::take(&mut self.keys);
        self.keys = vec![0; (old.len() * 2).max(64)];
        self.len = 0;
        for key in old {
            if key != 0 {
                self.insert(key);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{PairSet, pair_key};

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
}
