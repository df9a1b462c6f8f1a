//! The window in a page: a canvas, and physics between its pictures.

use std::cell::RefCell;
use std::fmt;
use std::rc::Rc;
use std::sync::mpsc::{Sender, channel};

use web_sys::HtmlCanvasElement;
use winit::application::ApplicationHandler;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop, EventLoopProxy};
use winit::platform::web::EventLoopExtWebSys;
use winit::window::WindowId;

use super::app::App;
use super::news::News;
use super::shell::Shell;
use crate::error::ViewError;
use crate::options::Options;
use crate::pace::Pace;
use crate::places::Place;
use crate::sim::{Command, Shown, Simulation, Slot};

/// A window in a page.
#[derive(Clone)]
pub struct Page {
    app: Rc<RefCell<App>>,
    sender: Sender<Command>,
    proxy: EventLoopProxy<News>,
}

impl fmt::Debug for Page {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Page").finish_non_exhaustive()
    }
}

/// Opens a scene on a canvas and returns at once; `failed` gets the reason if it cannot be drawn
/// on.
///
/// # Errors
/// The browser gives no events.
pub fn show(
    options: Options,
    canvas: HtmlCanvasElement,
    failed: Box<dyn Fn(&str)>,
) -> Result<Page, ViewError> {
    let none = |e: winit::error::EventLoopError| ViewError::NoDisplay { reason: e.to_string() };
    let events = EventLoop::with_user_event().build().map_err(none)?;
    let (sender, commands) = channel();
    let slot = Slot::default();
    let (overlays, panel) = (options.overlays, options.panel);
    let name = options.opened.name.clone();
    let mut simulation = Simulation::new(options.opened, options.open, options.playing);
    simulation.show(&slot, &|| (), 1.0);
    let _ = sender.send(Command::Overlays(overlays));
    let proxy = events.create_proxy();
    let shell = Shell {
        simulation,
        commands,
        pace: Pace::new(),
        proxy: proxy.clone(),
        canvas: Some(canvas),
        arrived: Rc::default(),
        failed,
    };
    let app = App {
        name,
        overlays,
        panel,
        sender: sender.clone(),
        slot,
        shell,
        stage: None,
        failure: None,
    };
    let app = Rc::new(RefCell::new(app));
    events.spawn_app(Shared(Rc::clone(&app)));
    Ok(Page { app, sender, proxy })
}

impl Page {
    /// Asks for something, as the window does.
    pub fn send(&self, command: Command) {
        let _ = self.sender.send(command);
        let _ = self.proxy.send_event(News);
    }

    /// Gives `look` what is shown; nothing before the first picture.
    pub fn look<T>(&self, look: impl FnOnce(&Shown, &[Place]) -> T) -> Option<T> {
        let app = self.app.try_borrow().ok()?;
        let stage = app.stage.as_ref()?;
        stage.look(look)
    }
}

/// The window's events come while the page may hold it too.
struct Shared(Rc<RefCell<App>>);

impl ApplicationHandler<News> for Shared {
    fn new_events(&mut self, events: &ActiveEventLoop, cause: StartCause) {
        self.0.borrow_mut().new_events(events, cause);
    }

    fn resumed(&mut self, events: &ActiveEventLoop) {
        self.0.borrow_mut().resumed(events);
    }

    fn user_event(&mut self, events: &ActiveEventLoop, news: News) {
        self.0.borrow_mut().user_event(events, news);
    }

    fn window_event(&mut self, events: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        self.0.borrow_mut().window_event(events, id, event);
    }
}
