//! Where blocks of contacts stand. A group that one worker takes through the whole step needs its blocks only
//! meanwhile, so all groups of a worker use one room, as large as the largest of them asks for: many small islands
//! take no more of memory than one, and their blocks stay in the worker's cache. What several workers share, or
//! takes its passes in turn with particles, or is asked for after the step, has blocks of its own.

use super::block::ContactBlock;
use crate::base::grow;
use crate::base::threads::disjoint::{Apart, Next, Rows};
use crate::step::solver::plan::Plan;

/// Blocks by their numbers in the plan: all, or those of a group that is in a room.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks<'a> {
    rows: Rows<'a, ContactBlock>,
    /// Number of the first one.
    first: usize,
}

impl<'a> Blocks<'a> {
    /// These, of which the first has that number.
    pub(crate) fn new(blocks: &'a mut [ContactBlock], first: usize, apart: Apart) -> Self {
        Self { rows: Rows::new(blocks, apart), first }
    }

    /// Block `i`.
    #[inline(always)]
    pub(crate) fn row(&self, i: usize) -> &mut ContactBlock {
        self.rows.row(i - self.first)
    }

    /// Block `i`, to read.
    #[inline(always)]
    pub(crate) fn read(&self, i: usize) -> &ContactBlock {
        self.rows.read(i - self.first)
    }

    /// What stands behind block `i`.
    #[inline(always)]
    pub(crate) fn after(&self, i: usize) -> Next<'_, ContactBlock> {
        self.rows.after(i - self.first)
    }
}

/// Which blocks have a place of their own, and the workers' rooms.
#[derive(Debug)]
pub(crate) struct Arena<'a> {
    /// The first blocks of the plan.
    pub(crate) own: &'a mut [ContactBlock],
    /// One for each worker, for those of a group that it solves alone.
    pub(crate) rooms: &'a mut [ContactBlock],
    /// Blocks in a room.
    pub(crate) size: usize,
}

impl<'a> Arena<'a> {
    /// Makes room in `blocks` for the groups of `plan` and this many workers. `keep`: all blocks keep what they
    /// say until the next step.
    pub(crate) fn new(
        plan: &Plan,
        blocks: &'a mut Vec<ContactBlock>,
        workers: usize,
        keep: bool,
    ) -> Self {
        let (shared, single) = plan.groups.split_at(plan.shared);
        let layout = &plan.contacts;
        let own = shared.iter().map(|group| layout.blocks_of(&group.contacts).end).max();
        let size = single.iter().map(|group| layout.blocks_of(&group.contacts).len()).max();
        // Any worker may take any group: no more groups than workers would not need less.
        let (own, size) = if keep || single.len() <= workers {
            (layout.owners.len(), 0)
        } else {
            (own.unwrap_or(0), size.unwrap_or(0))
        };
        let n = own + size * workers;
        // What is there is not taken back: rooms grow and shrink from step to step.
        if blocks.len() < n {
            let more = n - blocks.len();
            grow::make_room(blocks, more);
            blocks.resize_with(n, ContactBlock::default);
        }
        let (own, rooms) = blocks.split_at_mut(own);
        Self { own, rooms: &mut rooms[..size * workers], size }
    }
}
