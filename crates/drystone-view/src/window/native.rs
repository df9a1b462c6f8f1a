//! The window on a desktop: physics has a thread of its own.

use std::future::Future;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::thread;

use winit::event_loop::EventLoop;
use winit::window::{Window, WindowAttributes};

use super::stage::Stage;
use super::{App, News};
use crate::sim::{Command, Simulation, Slot};
use crate::{Options, ViewError};

/// Opens a window on a scene and returns when it is closed. Must be called on the main thread.
///
/// # Errors
/// There is no display, or nothing that can draw on it.
pub fn show(options: Options) -> Result<(), ViewError> {
    let events = open_display()?;
    let (sender, receiver) = channel();
    let slot = Slot::default();
    let proxy = events.create_proxy();
    let shared = Arc::clone(&slot);
    let (overlays, panel) = (options.overlays, options.panel);
    let name = options.opened.name.clone();
    let simulation = Simulation::new(options.opened, options.open, options.playing);
    let physics = thread::spawn(move || {
        // A window that has gone needs no news.
        simulation.run(&receiver, &shared, &|| {
            let _ = proxy.send_event(News);
        });
    });
    let _ = sender.send(Command::Overlays(overlays));
    let (shell, stage, failure) = (Shell, None, None);
    let mut app = App { name, overlays, panel, sender, slot, shell, stage, failure };
    let result = events.run_app(&mut app);
    let _ = app.sender.send(Command::Quit);
    // A panic there was already told by its own message.
    let _ = physics.join();
    result.map_err(|e| ViewError::NoDisplay { reason: e.to_string() })?;
    app.failure.map_or(Ok(()), Err)
}

/// Connects to the display.
fn open_display() -> Result<EventLoop<News>, ViewError> {
    // Where a library of the window system is missing, the window crate panics: that is no display too.
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let opened = panic::catch_unwind(AssertUnwindSafe(|| EventLoop::with_user_event().build()));
    panic::set_hook(hook);
    let none = |reason: String| ViewError::NoDisplay { reason };
    match opened {
        Ok(result) => result.map_err(|e| none(e.to_string())),
        Err(panic) => {
            let said = panic.downcast_ref::<String>().map(String::as_str);
            let said = said.or(panic.downcast_ref::<&str>().copied());
            Err(none(said.unwrap_or("the window system's libraries are missing").to_owned()))
        }
    }
}

/// What a desktop needs beside the window: nothing.
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
