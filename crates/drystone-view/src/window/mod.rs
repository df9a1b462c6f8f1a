//! The window: events in, pictures out.

mod app;
#[cfg(not(target_arch = "wasm32"))]
mod native;
mod news;
#[cfg_attr(target_arch = "wasm32", path = "shell_web.rs")]
mod shell;
mod stage;
#[cfg(target_arch = "wasm32")]
pub mod web;

#[cfg(not(target_arch = "wasm32"))]
pub use self::native::show;
