//! The word by which workers claim the chunks of a phase.

use crate::base::threads::sync::AtomicU64;
use crate::base::threads::team::PHASES;
use core::ops::Range;
use std::any::Any;

/// Payload of a task's panic.
pub(super) type Payload = Box<dyn Any + Send>;

/// A [`tagged`] number for each phase of a series, on cache lines of its own.
#[derive(Debug, Default)]
#[repr(align(128))]
pub(super) struct PerPhase(pub(super) [AtomicU64; PHASES]);

/// The unclaimed chunks of a list in one word, [`tagged`] at first. The upper half is the series'
/// epoch; the lower half is the number of chunks claimed from the back and the number left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Word(pub(super) u64);

impl Word {
    pub(crate) fn left(self) -> usize {
        usize::try_from(self.0 & 0xffff).unwrap_or(0)
    }

    pub(crate) fn back(self) -> usize {
        usize::try_from(self.0 >> 16 & 0x7fff).unwrap_or(0)
    }

    /// Returns the word after a claim of the next chunk from one end.
    pub(crate) fn claimed(self, back: bool) -> Self {
        Self(self.0 - 1 + if back { 1 << 16 } else { 0 })
    }
}

/// Packs a series' epoch and a number. Epochs recur after 2³² series (eight days without a
/// break). A worker that slept exactly that long does no harm. A claim succeeds only for the
/// current word, which the running series wrote after its job.
pub(super) fn tagged(epoch: u32, number: usize) -> u64 {
    u64::from(epoch) << 32 | number as u64
}

/// Unpacks a [`tagged`] word.
pub(super) fn untagged(word: u64) -> (u32, usize) {
    ((word >> 32) as u32, (word & 0xffff_ffff) as usize)
}

/// Range of the chunks in one of `lists` lists.
pub(super) fn part(chunks: usize, lists: usize, list: usize) -> Range<usize> {
    (chunks * list).div_ceil(lists)..(chunks * (list + 1)).div_ceil(lists)
}

/// Id of this process.
pub(super) fn this_process() -> usize {
    // WebAssembly has no process ids, and the call would panic.
    if cfg!(target_family = "wasm") { 0 } else { std::process::id() as usize }
}
