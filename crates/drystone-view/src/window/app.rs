//! Events of a window in, pictures out.

use std::sync::PoisonError;
use std::sync::mpsc::Sender;

use winit::application::ApplicationHandler;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::WindowId;

use super::news::News;
use super::shell::Shell;
use super::stage::Stage;
use crate::error::ViewError;
use crate::overlay::Overlays;
use crate::sim::{Command, Slot};

/// The state of a window.
pub(super) struct App {
    pub(super) name: String,
    pub(super) overlays: Overlays,
    pub(super) panel: Option<bool>,
    pub(super) sender: Sender<Command>,
    pub(super) slot: Slot,
    /// The part that differs between a window on a desktop and a page in a browser.
    pub(super) shell: Shell,
    pub(super) stage: Option<Stage>,
    pub(super) failure: Option<ViewError>,
}

impl App {
    fn fail(&mut self, events: &ActiveEventLoop, why: ViewError) {
        self.shell.failed(&why);
        self.failure = Some(why);
        events.exit();
    }

    fn set_up(&mut self, events: &ActiveEventLoop, opened: Result<Stage, ViewError>) {
        match opened {
            Ok(stage) => {
                stage.window.request_redraw();
                self.stage = Some(stage);
            }
            Err(e) => self.fail(events, e),
        }
    }

    fn draw(&mut self, events: &ActiveEventLoop) {
        let again = self.shell.pump(&self.slot);
        let Some(stage) = &mut self.stage else { return };
        if let Some(shown) = self.slot.lock().unwrap_or_else(PoisonError::into_inner).take() {
            stage.learn(shown);
        }
        let sender = &self.sender;
        let mut sent = false;
        let drawn = stage.draw(&mut |command| {
            sent = true;
            // Physics that has gone takes no commands.
            drop(sender.send(command));
        });
        if Shell::PUMPS && (again || sent) {
            stage.window.request_redraw();
        }
        match drawn {
            Ok(None) => events.set_control_flow(ControlFlow::Wait),
            Ok(Some(at)) => events.set_control_flow(ControlFlow::WaitUntil(at)),
            Err(e) => self.fail(events, e.into()),
        }
    }
}

impl ApplicationHandler<News> for App {
    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(stage)) = (cause, &self.stage) {
            stage.window.request_redraw();
        }
    }

    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.stage.is_some() {
            return;
        }
        let window = Stage::window(events, self.shell.attributes(&self.name));
        let opened = window
            .map(|window| self.shell.wait_for(Stage::open(window, self.overlays, self.panel)));
        match opened {
            Ok(Some(opened)) => self.set_up(events, opened),
            Ok(None) => {}
            Err(e) => self.fail(events, e),
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, _: News) {
        if let Some(opened) = self.shell.arrived() {
            self.set_up(events, opened);
        }
        if let Some(stage) = &self.stage {
            stage.window.request_redraw();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(stage) = &mut self.stage else { return };
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::RedrawRequested => self.draw(events),
            WindowEvent::DroppedFile(path) => {
                let _ = self.sender.send(Command::Open(path.to_string_lossy().into_owned()));
            }
            other => stage.take_in(&other),
        }
    }
}
