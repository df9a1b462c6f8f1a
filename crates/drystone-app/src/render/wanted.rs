//! The look of pictures.

/// The look of pictures, as far as a user says it.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "render"), expect(dead_code, reason = "such a build makes no pictures"))]
pub(crate) struct Wanted {
    /// Width and height [pixels]; `None`: those usual for the kind of file.
    pub(crate) size: Option<(u32, u32)>,
    /// Whether collision shapes are drawn in place of visuals.
    pub(crate) colliders: bool,
    /// Frames a second of a film; `None`: those usual for the kind of file.
    pub(crate) fps: Option<f64>,
}
