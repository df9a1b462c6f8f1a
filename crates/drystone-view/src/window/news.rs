//! The event that wakes a window.

/// There is something new to show.
#[derive(Clone, Copy, Debug)]
pub(super) struct News;
