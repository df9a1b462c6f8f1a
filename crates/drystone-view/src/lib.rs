//! A window on a world: watch it, stop it, turn time back, pull and shoot at it.
//!
//! Physics runs on a thread of its own ([`sim`]); the window (`show`) draws what that thread last
//! gave it and sends back commands. [`history`] lets time go back. In a browser (`web`) there is
//! one thread, and physics runs between the pictures.

pub mod history;
pub mod overlay;
pub mod places;
pub mod sim;

mod control;
mod error;
mod options;
mod pace;
mod panel;
mod picked;
mod plot;
mod settings;
mod side;
mod window;

pub use error::ViewError;
pub use options::Options;
pub use pace::Pace;
pub use picked::Picked;
#[cfg(not(target_arch = "wasm32"))]
pub use window::show;
#[cfg(target_arch = "wasm32")]
pub use window::web;
