//! A number in a row that several workers borrow at once.

use core::sync::atomic::{AtomicU32, Ordering};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// In each phase at most one worker writes it, and then no other reads it. A relaxed load or store
/// costs the same as for a plain number.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub(crate) struct Shared(AtomicU32);

impl Clone for Shared {
    fn clone(&self) -> Self {
        Self::new(self.get())
    }
}

impl Shared {
    pub(crate) const fn new(value: u32) -> Self {
        Self(AtomicU32::new(value))
    }

    #[inline]
    pub(crate) fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }

    #[inline]
    pub(crate) fn set(&self, value: u32) {
        self.0.store(value, Ordering::Relaxed);
    }
}
