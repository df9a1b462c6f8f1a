//! Pictures of drystone's worlds: one small renderer for a window, for files without a display or a
//! GPU, and for a browser.
//!
//! A picture is made in three parts. [`Subject`] determines the subject of a world's picture and
//! gives a [`Camera`] that shows it. [`Drawing`] gathers the content: shapes by form, rods, lines.
//! [`Renderer`] draws it on a texture. [`Canvas`] is a renderer with its own picture in memory; a
//! browser has none, because a page must not block on the device.
//!
//! ```no_run
//! use drystone_render::{Canvas, Drawing, Look, Subject};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = drystone_scene::named("pyramid")?.build()?;
//! let subject = Subject::of(&scene.world);
//! let camera = subject.camera(subject.angles(), 16.0 / 9.0);
//! let mut canvas = Canvas::new(1280, 720)?;
//! let picture = canvas.draw(&Drawing::of(&scene.world, &subject, &Look::default()), &camera)?;
//! assert_eq!(picture.rgba.len(), 1280 * 720 * 4);
//! # Ok(())
//! # }
//! ```
//!
//! The same drawing and camera give the same bytes on the same device and driver.

mod camera;
// It blocks on the device, which a page in a browser must not do.
#[cfg(not(target_arch = "wasm32"))]
mod canvas;
mod color;
mod drawing;
mod error;
mod form;
mod framing;
mod groups;
mod renderer;
mod sheet;

pub use camera::{Camera, FIELD_OF_VIEW};
#[cfg(not(target_arch = "wasm32"))]
pub use canvas::{Canvas, Picture};
pub use color::{Color, body_color};
pub use drawing::{Drawing, Gatherer, Look};
pub use error::RenderError;
pub use framing::{Follow, Subject, ViewAngles};
pub use groups::Groups;
pub use renderer::{Area, Renderer, limits};
pub use wgpu;
