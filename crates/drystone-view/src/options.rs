//! The state of a window at its start.

use std::fmt;

use crate::overlay::Overlays;
use crate::sim::{Opened, Opener};

/// The state of a window at its start.
pub struct Options {
    /// The scene at its beginning.
    pub opened: Opened,
    /// Opens other scenes.
    pub open: Opener,
    /// Whether it runs from the start.
    pub playing: bool,
    /// The overlays over bodies at first.
    pub overlays: Overlays,
    /// Whether the panel is seen at first; if left open, in windows that are wide enough.
    pub panel: Option<bool>,
}

impl fmt::Debug for Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Options").field("opened", &self.opened.name).finish_non_exhaustive()
    }
}
