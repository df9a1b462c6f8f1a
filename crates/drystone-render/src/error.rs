//! Errors of the renderer.

/// The reason a picture could not be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The machine has no graphics device that can draw.
    #[error(
        "no graphics device: neither a GPU with a Vulkan, Metal or Direct3D 12 driver nor a software \
         renderer was found ({reason}). Without a GPU Debian and Ubuntu draw in software with `apt-get \
         install mesa-vulkan-drivers libvulkan1`, Fedora with `dnf install mesa-vulkan-drivers \
         vulkan-loader`"
    )]
    NoDevice {
        /// The graphics library's message.
        reason: String,
    },
    /// A picture of this size cannot be drawn.
    #[error(
        "the picture size must be from 1x1 to {most}x{most} with at most {points} points in all (got {width}x{height})"
    )]
    Size {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Maximum width and height.
        most: u32,
        /// Maximum number of pixels.
        points: u64,
    },
    /// The device failed while drawing.
    #[error("the graphics device failed: {0}")]
    Device(String),
}
