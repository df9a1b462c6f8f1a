//! A set of small numbers, one bit each.

/// One bit per number; grows on demand.
#[derive(Debug, Default)]
pub(crate) struct BitSet {
    words: Vec<u64>,
}

impl Clone for BitSet {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Copies into the existing list.
    fn clone_from(&mut self, from: &Self) {
        let Self { words } = from;
        self.words.clone_from(words);
    }
}

impl BitSet {
    #[inline]
    pub(crate) fn contains(&self, i: u32) -> bool {
        self.words.get((i >> 6) as usize).is_some_and(|w| (w >> (i & 63)) & 1 == 1)
    }

    #[inline]
    pub(crate) fn insert(&mut self, i: u32) {
        let word = (i >> 6) as usize;
        if word >= self.words.len() {
            self.words.resize(word + 1, 0);
        }
        self.words[word] |= 1 << (i & 63);
    }

    #[inline]
    pub(crate) fn remove(&mut self, i: u32) {
        if let Some(w) = self.words.get_mut((i >> 6) as usize) {
            *w &= !(1 << (i & 63));
        }
    }

    /// Removes the given numbers, which must be all that are in the set.
    pub(crate) fn remove_all(&mut self, all: &[u32]) {
        if all.len() > self.words.len() {
            self.words.fill(0);
        } else {
            all.iter().for_each(|i| self.remove(*i));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::BitSet;

    #[test]
    fn bits_come_and_go() {
        let mut s = BitSet::default();
        for i in [200, 3, 64, 63, 3] {
            s.insert(i);
        }
        s.remove(64);
        assert!(s.contains(200) && !s.contains(64) && !s.contains(9999));
        assert!(s.contains(3) && s.contains(63));
        for more in [0, 10] {
            let all: Vec<u32> = [200, 3, 63].into_iter().chain(300..300 + more).collect();
            all.iter().for_each(|i| s.insert(*i));
            s.remove_all(&all);
            assert!(all.iter().all(|i| !s.contains(*i)));
        }
    }
}
