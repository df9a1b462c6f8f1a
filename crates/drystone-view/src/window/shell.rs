//! The part of a window that only a desktop has.

use std::future::Future;

use winit::window::{Window, WindowAttributes};

use super::stage::Stage;
use crate::error::ViewError;
use crate::sim::Slot;

/// The part of a window that only a desktop has: nothing.
pub(super) struct Shell;

#[expect(clippy::unused_self, reason = "a page in a browser has these too, and more to do in them")]
impl Shell {
    /// Physics has its own thread.
    pub(super) const PUMPS: bool = false;

    pub(super) fn attributes(&self, name: &str) -> WindowAttributes {
        let size = winit::dpi::LogicalSize::new(1280.0, 800.0);
        Window::default_attributes().with_title(name).with_inner_size(size)
    }

    /// Waits for the device.
    pub(super) fn wait_for<F>(&self, stage: F) -> Option<Result<Stage, ViewError>>
    where
        F: Future<Output = Result<Stage, ViewError>>,
    {
        Some(pollster::block_on(stage))
    }

    /// Nothing was left to arrive.
    pub(super) const fn arrived(&self) -> Option<Result<Stage, ViewError>> {
        None
    }

    pub(super) const fn pump(&self, _: &Slot) -> bool {
        false
    }

    pub(super) const fn failed(&self, _: &ViewError) {}
}
