//! Order in which the classic methods solve contacts.

use super::rows::Pair;

/// The pairs in the order of a sweep, and the ends of levels in it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sequence {
    pub(crate) pairs: Vec<u32>,
    /// End of each level in `pairs`.
    pub(crate) ends: Vec<usize>,
}

impl Sequence {
    /// Recomputes the ends of levels.
    pub(crate) fn end_levels(&mut self, pairs: &[Pair]) {
        let level = |i: usize| self.pairs.get(i).map(|p| pairs[*p as usize].level);
        self.ends.clear();
        self.ends
            .extend((0..self.pairs.len()).filter(|i| level(*i) != level(i + 1)).map(|i| i + 1));
    }

    /// Puts pairs in an order unrelated to their positions.
    pub(crate) fn shuffle(&mut self) {
        // An odd factor permutes the 32-bit numbers; their upper halves look random.
        let key = |pair: &u32| {
            let x = pair.wrapping_add(1).wrapping_mul(0x85eb_ca6b);
            ((x ^ x >> 15).wrapping_mul(0xc2b2_ae35), *pair)
        };
        self.pairs.sort_unstable_by_key(key);
    }

    pub(crate) fn levels(&self) -> impl Iterator<Item = &[u32]> {
        let starts = core::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| &self.pairs[start..*end])
    }
}
