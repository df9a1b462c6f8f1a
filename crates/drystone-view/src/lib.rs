//! A window on a world: watch it, stop it, turn time back, pull and shoot at it.
//!
//! Physics runs on a thread of its own ([`sim`]); the window (`show`) draws what that thread last
//! gave it and sends back commands. [`history`] lets time go back. In a browser (`web`) there is one
//! thread, and physics runs between the pictures.

pub mod history;
pub mod overlay;
pub mod places;
pub mod sim;

mod control;
mod pace;
mod panel;
mod picked;
mod plot;
mod settings;
mod side;
mod window;

pub use pace::Pace;
pub use picked::Picked;
#[cfg(not(target_arch = "wasm32"))]
pub use window::show;
#[cfg(target_arch = "wasm32")]
pub use window::web;

/// What is to be shown.
pub struct Options {
    /// The scene at its beginning.
    pub opened: sim::Opened,
    /// Opens other scenes.
    pub open: sim::Opener,
    /// Whether it runs from the start.
    pub playing: bool,
    /// What is drawn over bodies at first.
    pub overlays: overlay::Overlays,
    /// Whether the panel is seen at first; if left open, in windows that are wide enough.
    pub panel: Option<bool>,
}

impl std::fmt::Debug for Options {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Options").field("opened", &self.opened.name).finish_non_exhaustive()
    }
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
