//! Why a picture could not be made.

/// Why a picture could not be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// There is no graphics device that can draw.
    #[error(
        "no graphics device: neither a GPU with a Vulkan, Metal or Direct3D 12 driver nor a software \
         renderer was found ({reason}). Without a GPU Debian and Ubuntu draw in software with `apt-get \
         install mesa-vulkan-drivers libvulkan1`, Fedora with `dnf install mesa-vulkan-drivers \
         vulkan-loader`"
    )]
    NoDevice {
        /// What the graphics library says.
        reason: String,
    },
    /// A picture of this size cannot be drawn.
    #[error(
        "the picture size must be from 1x1 to {most}x{most} with at most {points} points in all (got {width}x{height})"
    )]
    Size {
        /// Points across.
        width: u32,
        /// Points down.
        height: u32,
        /// The most on each side.
        most: u32,
        /// The most in all.
        points: u64,
    },
    /// The device failed while drawing.
    #[error("the graphics device failed: {0}")]
    Device(String),
}
