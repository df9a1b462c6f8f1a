//! Allocates the blocks of contacts.
//!
//! A group that one worker solves for the whole step needs its blocks only during that time. So all
//! groups of a worker share one buffer (`buffers`), as large as the largest group needs. Many small
//! islands then take no more memory than one, and their blocks stay in the worker's cache. Blocks
//! have a place of their own if several workers share them, if they run in step with particles, or
//! if they are read after the step.

use super::block::ContactBlock;
use crate::base::grow;
use crate::base::threads::disjoint::{Apart, Next, Rows};
use crate::step::solver::plan::Plan;

/// Blocks by their numbers in the plan: all blocks, or the blocks of a group in a worker's buffer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks<'a> {
    rows: Rows<'a, ContactBlock>,
    /// Number of the first block.
    first: usize,
}

impl<'a> Blocks<'a> {
    /// Makes the view; `first` is the number of the first block.
    pub(crate) fn new(blocks: &'a mut [ContactBlock], first: usize, apart: Apart) -> Self {
        Self { rows: Rows::new(blocks, apart), first }
    }

    /// Block `i`.
    #[inline(always)]
    pub(crate) fn row(&self, i: usize) -> &mut ContactBlock {
        self.rows.row(i - self.first)
    }

    /// Block `i`, read-only.
    #[inline(always)]
    pub(crate) fn read(&self, i: usize) -> &ContactBlock {
        self.rows.read(i - self.first)
    }

    /// The blocks after block `i`, to prefetch.
    #[inline(always)]
    pub(crate) fn after(&self, i: usize) -> Next<'_, ContactBlock> {
        self.rows.after(i - self.first)
    }
}

/// Blocks with a place of their own, and the workers' buffers.
#[derive(Debug)]
pub(crate) struct Arena<'a> {
    /// The first blocks of the plan.
    pub(super) own: &'a mut [ContactBlock],
    pub(super) buffers: Buffers<'a>,
}

/// One buffer for each worker, for the groups that it solves alone.
#[derive(Debug)]
pub(crate) struct Buffers<'a> {
    /// Number of the plan's blocks with a place of their own; the others need a buffer.
    pub(crate) first: usize,
    /// The blocks of all buffers, and the number of blocks in a buffer.
    pub(crate) blocks: &'a mut [ContactBlock],
    pub(crate) size: usize,
}

impl<'a> Arena<'a> {
    /// Allocates `blocks` for the groups of `plan` and this many workers. `keep`: all blocks keep
    /// their data until the next step.
    pub(super) fn new(
        plan: &Plan,
        blocks: &'a mut Vec<ContactBlock>,
        workers: usize,
        keep: bool,
    ) -> Self {
        let (shared, single) = plan.groups.split_at(plan.shared);
        let layout = &plan.contacts;
        let own = shared.iter().map(|group| layout.blocks_of(&group.contacts).end).max();
        let size = single.iter().map(|group| layout.blocks_of(&group.contacts).len()).max();
        // Any worker may take any group: with no more groups than workers, buffers would not save
        // memory.
        let (own, size) = if keep || single.len() <= workers {
            (layout.owners.len(), 0)
        } else {
            (own.unwrap_or(0), size.unwrap_or(0))
        };
        let n = own + size * workers;
        // Never shrink: the need changes from step to step.
        if blocks.len() < n {
            let more = n - blocks.len();
            grow::make_room(blocks, more);
            blocks.resize_with(n, ContactBlock::default);
        }
        let (own, rest) = blocks.split_at_mut(own);
        let buffers = Buffers { first: own.len(), blocks: &mut rest[..size * workers], size };
        Self { own, buffers }
    }
}
