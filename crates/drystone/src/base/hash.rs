//! The hash of a state: 64 bits from the bits of numbers, in the order of input.

use super::math::Vec3;

/// A multiply-and-rotate hash over 32-bit words. Not cryptographic; every input bit reaches every
/// output bit after [`StateHash::finish`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct StateHash(u64);

impl Default for StateHash {
    fn default() -> Self {
        Self(0x9e37_79b9_7f4a_7c15)
    }
}

impl StateHash {
    /// Adds one word.
    #[inline]
    pub(crate) fn word(&mut self, w: u32) {
        self.0 = (self.0 ^ u64::from(w)).wrapping_mul(0xff51_afd7_ed55_8ccd).rotate_left(31);
    }

    /// Adds the bits of some numbers.
    #[inline]
    pub(crate) fn floats(&mut self, values: &[f32]) {
        for v in values {
            self.word(v.to_bits());
        }
    }

    /// Adds the bits of a vector.
    pub(crate) fn vector(&mut self, v: Vec3) {
        self.floats(&v.to_array());
    }

    /// Adds some words.
    pub(crate) fn words(&mut self, words: &[u32]) {
        words.iter().for_each(|w| self.word(*w));
    }

    /// Adds a count.
    pub(crate) fn count(&mut self, n: usize) {
        // Lists of a world are shorter than 2^32.
        #[expect(clippy::cast_possible_truncation, reason = "any bits will do for a hash")]
        self.word(n as u32);
    }

    /// Returns the hash of all input.
    #[must_use]
    pub(crate) fn finish(self) -> u64 {
        let mut h = self.0;
        h = (h ^ (h >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
        h ^ (h >> 29)
    }
}
