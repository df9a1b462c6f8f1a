//! Memory of the narrowphase, kept from step to step.

use super::change::Change;
use super::motion::Motions;
use super::{motion, placed, seams};
use crate::geometry::collide::MeshScratch;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub(crate) changes: Vec<Vec<Change>>,
    /// Changes of ghosts of seams; they follow `changes`.
    pub(super) ghosts: Vec<Change>,
    pub(super) workers: Vec<Worker>,
    pub(super) seams: seams::Scratch,
    pub(super) placed: placed::Scratch,
}

/// Memory of one worker.
#[derive(Clone, Debug, Default)]
pub(crate) struct Worker {
    pub(super) mesh: MeshScratch,
    pub(super) moving: motion::Pairs,
    pub(super) motions: Motions,
}

impl Scratch {
    /// Changes in lists of any lengths, together in the order of the awake list; then the changes
    /// of ghosts.
    pub(crate) fn changes(&self) -> [&[Vec<Change>]; 2] {
        [&self.changes, core::slice::from_ref(&self.ghosts)]
    }

    /// Contacts whose bodies turn far.
    pub(crate) fn turning(&self) -> impl Iterator<Item = u32> {
        self.changes.iter().flatten().filter_map(|change| match change {
            Change::Turns(row) => Some(*row),
            _ => None,
        })
    }

    /// Contacts that were ghosts of seams: they lost their points, or took the normal of the
    /// contact that carries the body beside them.
    pub(crate) fn ghosts(&self) -> impl Iterator<Item = u32> {
        self.seams.hidden()
    }

    /// Contacts that close fast.
    pub(crate) fn closing(&self) -> impl Iterator<Item = u32> {
        self.changes.iter().flatten().filter_map(|change| match change {
            Change::Closes(row) => Some(*row),
            _ => None,
        })
    }
}
