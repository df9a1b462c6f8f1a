//! A scene as a world that runs, with its script; saved and resumed.

mod resume;
mod running;

pub use self::resume::{ResumeError, SavedRun};
pub use self::running::{BuildError, Running};
