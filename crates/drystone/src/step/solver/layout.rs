//! The blocks of a kind of constraint: which stand in them, in what order.
//!
//! A color's list is sorted by keys, and cut into runs where a key says that another group or another kernel begins; runs become
//! batches of blocks. Order within a color never shows in the result.

use core::ops::Range;

use crate::base::jobs::{Executor, for_series};
use crate::base::wide::LANES;
use crate::state::bodies::NONE;
use crate::state::colors::{Coloring, Place};

/// Group, class and line in a sort key.
pub(super) const GROUP: u32 = 40;
pub(super) const CLASS: u32 = 32;

/// Blocks of one color of a group.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    pub(super) blocks: Range<usize>,
    /// One side of every constraint cannot be pushed.
    pub(super) fixed: bool,
    /// What the key's class says.
    pub(super) class: u8,
}

/// Blocks of contacts or of joints.
#[derive(Clone, Debug, Default)]
pub(super) struct Layout {
    pub(super) batches: Vec<Batch>,
    /// Rows of the constraints of each block, lane by lane; [`NONE`]: an idle lane.
    pub(super) owners: Vec<[u32; LANES]>,
    pub(super) runs: Vec<Run>,
}

/// Constraints of one group in a color's list.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    group: u64,
    pub(super) class: u8,
    fixed: bool,
    color: usize,
    first: usize,
    end: usize,
}

impl Layout {
    /// Runs to batches of blocks, those of a group side by side.
    pub(super) fn lay_out(&mut self, [free, fixed]: [&Coloring; 2]) {
        // Within a group the colors keep their order. (A stable sort would allocate.)
        self.runs.sort_unstable_by_key(|run| (run.group, run.fixed, run.color, run.class));
        self.batches.clear();
        self.owners.clear();
        for run in &self.runs {
            let coloring = if run.fixed { fixed } else { free };
            let first = self.owners.len();
            for members in coloring.colors[run.color].members[run.first..run.end].chunks(LANES) {
                let mut owners = [NONE; LANES];
                owners[..members.len()].copy_from_slice(members);
                self.owners.push(owners);
            }
            let blocks = first..self.owners.len();
            self.batches.push(Batch { blocks, fixed: run.fixed, class: run.class });
        }
    }

    /// Calls `f(batch, blocks)` for the blocks of a group, a batch after the other: those of one are shared out among all workers.
    pub(super) fn for_blocks(
        &self,
        batches: &Range<usize>,
        jobs: &dyn Executor,
        least: usize,
        f: impl Fn(&Batch, Range<usize>) + Sync,
    ) {
        let batches = &self.batches[batches.clone()];
        for_series(
            jobs,
            batches.len(),
            |k| batches[k].blocks.len(),
            least,
            |k, part| {
                let first = batches[k].blocks.start;
                f(&batches[k], first + part.start..first + part.end);
            },
        );
    }

    /// The blocks of a group's batches: they stand side by side.
    pub(super) fn blocks_of(&self, batches: &Range<usize>) -> Range<usize> {
        match &self.batches[batches.clone()] {
            [] => 0..0,
            [first, .., last] => first.blocks.start..last.blocks.end,
            [one] => one.blocks.clone(),
        }
    }

    /// The batches of a group.
    pub(super) fn batches_of(&self, group: u64) -> Range<usize> {
        let first = self.runs.partition_point(|run| run.group < group);
        first..self.runs.partition_point(|run| run.group <= group)
    }
}

/// Cuts a sorted color where the key's bits from `shift` on change.
pub(super) fn find_runs(
    keys: &[(u64, u32)],
    shift: u32,
    fixed: bool,
    color: usize,
    runs: &mut Vec<Run>,
) {
    let mut first = 0;
    while let Some((key, _)) = keys.get(first) {
        let n = keys[first..].partition_point(|(k, _)| k >> shift == key >> shift);
        let class = class_in(*key);
        let (group, end) = (key >> GROUP, first + n);
        runs.push(Run { group, class, fixed, color, first, end });
        first = end;
    }
}

/// The sort key of a constraint of two bodies: by group, then by class, then by body, so that lines are near each
/// other. The class of a contact is its part of the lines of a shared group, so that each worker finds lines in its own
/// cache (a color's blocks are shared out in their order), and in that its number of points, so that blocks are even.
pub(super) fn line_key(group_of_line: &[u32]) -> impl Fn(u64, usize) -> u64 {
    move |class, line| u64::from(group_of_line[line]) << GROUP | class << CLASS | line as u64
}

/// The later one of the lines of two bodies.
pub(super) fn last_line(line_of: &[u32], a: u32, b: u32) -> usize {
    line_of[a as usize].max(line_of[b as usize]) as usize
}

/// The class in a sort key.
pub(super) const fn class_in(key: u64) -> u8 {
    (key >> CLASS).to_le_bytes()[0]
}

/// Puts a color's list in the order of its keys, and says where each member stands. Order within a color
/// never shows in the result.
pub(super) fn sort_members(
    members: &mut [u32],
    keys: &mut [(u64, u32)],
    color: usize,
    mut set_place: impl FnMut(u32, Place),
) {
    keys.sort_unstable();
    let color = u32::try_from(color).expect("fewer than 2^32 colors");
    for (row, (member, (_, sorted))) in (0..).zip(members.iter_mut().zip(keys)) {
        *member = *sorted;
        set_place(*member, Place { color, row });
    }
}
