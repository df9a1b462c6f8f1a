//! Memory of the narrowphase.

use super::change::Change;
use super::motion::Motions;
use super::{motion, placed, seams};
use crate::geometry::collide::MeshScratch;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub(crate) changes: Vec<Vec<Change>>,
    /// What ghosts of seams lose comes after.
    pub(super) ghosts: Vec<Change>,
    pub(super) workers: Vec<Worker>,
    pub(super) seams: seams::Scratch,
    pub(super) placed: placed::Scratch,
}

/// What a worker needs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Worker {
    pub(super) mesh: MeshScratch,
    pub(super) moving: motion::Pairs,
    pub(super) motions: Motions,
}

impl Scratch {
    /// In lists of any lengths, which together are in the order of what is watched; then what ghosts lose.
    pub(crate) fn changes(&self) -> [&[Vec<Change>]; 2] {
        [&self.changes, core::slice::from_ref(&self.ghosts)]
    }

    /// The contacts whose bodies turn far.
    pub(crate) fn turning(&self) -> impl Iterator<Item = u32> {
        self.changes.iter().flatten().filter_map(|change| match change {
            Change::Turns(row) => Some(*row),
            _ => None,
        })
    }

    /// Contacts that were ghosts of seams: they lost their points, or have the normal of what carries beside them.
    pub(crate) fn ghosts(&self) -> impl Iterator<Item = u32> {
        self.seams.hidden()
    }

    /// The contacts that close fast.
    pub(crate) fn closing(&self) -> impl Iterator<Item = u32> {
        self.changes.iter().flatten().filter_map(|change| match change {
            Change::Closes(row) => Some(*row),
            _ => None,
        })
    }
}
