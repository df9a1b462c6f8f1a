//! Saved worlds: snapshots, deltas, journals, copies, hashes.

pub(crate) mod clone;
#[cfg(feature = "snapshot")]
pub(crate) mod delta;
pub(crate) mod hashes;
#[cfg(feature = "snapshot")]
pub(crate) mod journal;
#[cfg(feature = "snapshot")]
pub(crate) mod library;
#[cfg(feature = "snapshot")]
pub(crate) mod snapshot;
