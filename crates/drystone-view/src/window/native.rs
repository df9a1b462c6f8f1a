//! The window on a desktop: physics has a thread of its own.

use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::thread;

use winit::event_loop::EventLoop;

use super::app::App;
use super::news::News;
use super::shell::Shell;
use crate::error::ViewError;
use crate::options::Options;
use crate::sim::{Command, Simulation, Slot};

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
    // A panic there has printed its own message already.
    let _ = physics.join();
    result.map_err(|e| ViewError::NoDisplay { reason: e.to_string() })?;
    app.failure.map_or(Ok(()), Err)
}

/// Connects to the display.
fn open_display() -> Result<EventLoop<News>, ViewError> {
    // Where a library of the window system is missing, the window crate panics: that is no display
    // too.
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
