//! The window: events in, pictures out.

mod stage;

use std::panic::{self, AssertUnwindSafe};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use winit::application::ApplicationHandler;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::WindowId;

use self::stage::Stage;
use crate::sim::{Command, Simulation, Slot};
use crate::{Options, ViewError};

/// There is something new to show.
#[derive(Clone, Copy, Debug)]
struct News;

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
    let overlays = options.overlays;
    let name = options.opened.name.clone();
    let simulation = Simulation::new(options.opened, options.open, options.playing);
    let physics = thread::spawn(move || {
        // A window that has gone needs no news.
        simulation.run(&receiver, &shared, &|| {
            let _ = proxy.send_event(News);
        });
    });
    let _ = sender.send(Command::Overlays(overlays));
    let mut app = App { name, overlays, sender, slot, stage: None, failure: None };
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

struct App {
    name: String,
    overlays: crate::overlay::Overlays,
    sender: Sender<Command>,
    slot: Slot,
    stage: Option<Stage>,
    failure: Option<ViewError>,
}

impl ApplicationHandler<News> for App {
    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(stage)) = (cause, &self.stage) {
            stage.window.request_redraw();
        }
    }

    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.stage.is_none() {
            match Stage::open(events, &self.name, self.overlays) {
                Ok(stage) => self.stage = Some(stage),
                Err(e) => {
                    self.failure = Some(e);
                    events.exit();
                }
            }
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, _: News) {
        if let Some(stage) = &self.stage {
            stage.window.request_redraw();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(stage) = &mut self.stage else { return };
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::RedrawRequested => {
                if let Some(shown) = take(&self.slot) {
                    stage.learn(shown);
                }
                let sender = &self.sender;
                // Physics that has gone takes no commands.
                let mut send = |command| drop(sender.send(command));
                match stage.draw(&mut send) {
                    Ok(None) => events.set_control_flow(ControlFlow::Wait),
                    Ok(Some(at)) => events.set_control_flow(ControlFlow::WaitUntil(at)),
                    Err(e) => {
                        self.failure = Some(e.into());
                        events.exit();
                    }
                }
            }
            WindowEvent::DroppedFile(path) => {
                let _ = self.sender.send(Command::Open(path.to_string_lossy().into_owned()));
            }
            other => stage.take_in(&other),
        }
    }
}

fn take(slot: &Mutex<Option<crate::sim::Shown>>) -> Option<crate::sim::Shown> {
    slot.lock().unwrap_or_else(PoisonError::into_inner).take()
}
