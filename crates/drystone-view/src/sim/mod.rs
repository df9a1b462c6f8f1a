//! The worlds that are shown: they carry out commands and give pictures. `pace` says when.

mod command;
mod grab;
mod opened;
mod picture;
mod shown;
mod simulation;

#[cfg(test)]
pub(crate) mod tests;

pub use self::command::{Command, Deed};
pub use self::opened::{Opened, Opener};
pub use self::shown::{Shown, Slot, View};
pub use self::simulation::Simulation;
pub use crate::side::Sample;
