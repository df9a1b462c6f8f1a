//! A set of small numbers, one bit each.

/// Grows on demand.
#[derive(Clone, Debug, Default)]
pub(crate) struct BitSet {
    words: Vec<u64>,
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
    }
}
