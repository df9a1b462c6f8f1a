//! A set of small numbers, one bit each.

/// Grows on demand; iteration is in rising order.
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

    pub(crate) fn clear(&mut self) {
        self.words.clear();
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = u32> {
        (0_u32..).zip(&self.words).flat_map(|(k, &word)| {
            let mut rest = word;
            core::iter::from_fn(move || {
                (rest != 0).then(|| {
                    let bit = rest.trailing_zeros();
                    rest &= rest - 1;
                    k * 64 + bit
                })
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::BitSet;

    #[test]
    fn bits_come_back_in_order() {
        let mut s = BitSet::default();
        for i in [200, 3, 64, 63, 3] {
            s.insert(i);
        }
        s.remove(64);
        assert!(s.contains(200) && !s.contains(64) && !s.contains(9999));
        assert_eq!(s.iter().collect::<Vec<_>>(), [3, 63, 200]);
    }
}
