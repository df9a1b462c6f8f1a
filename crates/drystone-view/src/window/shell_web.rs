//! The part of a window that only a page in a browser has.

use std::cell::RefCell;
use std::future::Future;
use std::rc::Rc;
use std::sync::mpsc::Receiver;
use std::time::Duration;

use web_sys::HtmlCanvasElement;
use winit::event_loop::EventLoopProxy;
use winit::platform::web::WindowAttributesExtWebSys;
use winit::window::{Window, WindowAttributes};

use super::news::News;
use super::stage::Stage;
use crate::error::ViewError;
use crate::pace::Pace;
use crate::sim::{Command, Simulation, Slot};

/// Time for physics between two pictures; the rest of a sixtieth of a second is for drawing.
const BUDGET: Duration = Duration::from_millis(9);

/// The part of a window that only a page in a browser has.
pub(super) struct Shell {
    pub(super) simulation: Simulation,
    pub(super) commands: Receiver<Command>,
    pub(super) pace: Pace,
    pub(super) proxy: EventLoopProxy<News>,
    pub(super) canvas: Option<HtmlCanvasElement>,
    pub(super) arrived: Rc<RefCell<Option<Result<Stage, ViewError>>>>,
    pub(super) failed: Box<dyn Fn(&str)>,
}

impl Shell {
    /// There is one thread.
    pub(super) const PUMPS: bool = true;

    pub(super) fn attributes(&mut self, _: &str) -> WindowAttributes {
        Window::default_attributes().with_canvas(self.canvas.take()).with_prevent_default(true)
    }

    /// Goes on when the device is there.
    pub(super) fn wait_for<F>(&self, stage: F) -> Option<Result<Stage, ViewError>>
    where
        F: Future<Output = Result<Stage, ViewError>> + 'static,
    {
        let (arrived, proxy) = (Rc::clone(&self.arrived), self.proxy.clone());
        wasm_bindgen_futures::spawn_local(async move {
            let opened = stage.await;
            *arrived.borrow_mut() = Some(opened);
            let _ = proxy.send_event(News);
        });
        None
    }

    pub(super) fn arrived(&self) -> Option<Result<Stage, ViewError>> {
        self.arrived.borrow_mut().take()
    }

    /// Returns whether there is a next picture to come by itself.
    pub(super) fn pump(&mut self, slot: &Slot) -> bool {
        self.simulation.pump(&self.commands, slot, &mut self.pace, BUDGET);
        self.simulation.is_playing()
    }

    pub(super) fn failed(&self, why: &ViewError) {
        (self.failed)(&why.to_string());
    }
}
