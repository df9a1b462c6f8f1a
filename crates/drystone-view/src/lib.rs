//! A window on a world: watch it, stop it, turn time back, pull and shoot at it.
//!
//! Physics runs on a thread of its own ([`sim`]); the window ([`show`]) draws what that thread last
//! gave it and sends back commands. [`history`] lets time go back.

pub mod history;
pub mod overlay;
pub mod sim;

mod control;
mod panel;
mod plot;
mod window;

use drystone_scene::Running;

pub use window::show;

/// What is to be shown.
#[derive(Debug)]
pub struct Options {
    /// The scene's name, for the window's title.
    pub name: String,
    /// The scene at its beginning.
    pub running: Running,
    /// Steps a second.
    pub hz: f32,
    /// Whether it runs from the start.
    pub playing: bool,
    /// What is drawn over bodies at first.
    pub overlays: overlay::Overlays,
}

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// There is no display.
    #[error(
        "there is no display to open a window on ({reason}). Without one `drystone simulate SCENE --render \
         FILE.png` draws pictures and films; `xvfb-run -s '-screen 0 1280x800x24' drystone view SCENE` \
         opens the window on a display in memory (Debian and Ubuntu: `apt-get install xvfb xauth \
         libxcursor1 libxi6 libxrandr2 libxkbcommon-x11-0`)"
    )]
    NoDisplay {
        /// What the window system says.
        reason: String,
    },
    /// The window cannot be drawn on.
    #[error(transparent)]
    Render(#[from] drystone_render::RenderError),
}
