//! Why there is no window.

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
        /// The message of the window system.
        reason: String,
    },
    /// The window cannot be drawn on.
    #[error(transparent)]
    Render(#[from] drystone_render::RenderError),
}
