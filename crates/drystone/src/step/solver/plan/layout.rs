//! Arranges the constraints of one kind in blocks, and orders these.
//!
//! A color's list is sorted by keys and cut into runs where a key begins another group or another
//! kernel. Runs become batches of blocks. The order within a color never affects the result.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use core::ops::Range;

use crate::base::simd::wide::LANES;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, for_each_with, for_series};
use crate::state::bodies::NONE;
use crate::state::colors::{Coloring, Place};

/// Bit positions of group and class in a sort key; the solver body is below.
pub(crate) const GROUP: u32 = 40;

pub(crate) const CLASS: u32 = 32;

/// Blocks of one color of a group.
#[derive(Clone, Debug)]
pub(crate) struct Batch {
    pub(crate) blocks: Range<usize>,
    /// One body of every constraint cannot be pushed.
    pub(crate) fixed: bool,
    /// Class from the key.
    pub(crate) class: u8,
}

/// Blocks of contacts or of joints.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    pub(crate) batches: Vec<Batch>,
    /// Rows of the constraints of each block, lane by lane; [`NONE`]: an idle lane.
    pub(crate) owners: Vec<[u32; LANES]>,
    pub(crate) runs: Vec<Run>,
}

/// Constraints of one group in a color's list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) group: u64,
    pub(crate) class: u8,
    fixed: bool,
    color: usize,
    first: usize,
    end: usize,
}

impl Run {
    /// The rows of its constraints.
    pub(crate) fn members<'c>(&self, [free, fixed]: [&'c Coloring; 2]) -> &'c [u32] {
        let coloring = if self.fixed { fixed } else { free };
        &coloring.colors[self.color].members[self.first..self.end]
    }
}

impl Layout {
    /// Turns runs into batches of blocks, with the batches of a group side by side.
    pub(crate) fn lay_out(&mut self, colorings: [&Coloring; 2]) {
        // Colors keep their order within a group. (A stable sort would allocate.)
        self.runs.sort_unstable_by_key(|run| (run.group, run.fixed, run.color, run.class));
        self.batches.clear();
        self.owners.clear();
        for run in &self.runs {
            let first = self.owners.len();
            for members in run.members(colorings).chunks(LANES) {
                let mut owners = [NONE; LANES];
                owners[..members.len()].copy_from_slice(members);
                self.owners.push(owners);
            }
            let blocks = first..self.owners.len();
            self.batches.push(Batch { blocks, fixed: run.fixed, class: run.class });
        }
    }

    /// Calls `f(batch, blocks)` for the blocks of a group, one batch after another. All workers
    /// share the blocks of a batch.
    pub(crate) fn for_blocks(
        &self,
        batches: &Range<usize>,
        jobs: &Jobs<'_>,
        minimum: usize,
        f: impl Fn(&Batch, Range<usize>) + Sync,
    ) {
        let batches = &self.batches[batches.clone()];
        for_series(
            jobs,
            batches.len(),
            |k| batches[k].blocks.len(),
            minimum,
            |k, part| {
                let first = batches[k].blocks.start;
                f(&batches[k], first + part.start..first + part.end);
            },
        );
    }

    /// The contiguous range of blocks of a group's batches.
    pub(crate) fn blocks_of(&self, batches: &Range<usize>) -> Range<usize> {
        match &self.batches[batches.clone()] {
            [] => 0..0,
            [first, .., last] => first.blocks.start..last.blocks.end,
            [one] => one.blocks.clone(),
        }
    }

    /// The batches of a group.
    pub(crate) fn batches_of(&self, group: u64) -> Range<usize> {
        let first = self.runs.partition_point(|run| run.group < group);
        first..self.runs.partition_point(|run| run.group <= group)
    }
}

/// Makes the sort key of a constraint of two bodies: group, then class, then solver body, so that
/// nearby constraints read nearby solver bodies.
///
/// The upper part of a contact's class is its share of the solver bodies of a shared group. Workers
/// share a color's blocks in order, so each worker finds solver bodies in its own cache. The lower
/// part is the number of points, so that the lanes of a block have equal counts.
pub(crate) fn row_key(group_of_row: &[u32]) -> impl Fn(u64, usize) -> u64 {
    move |class, solver_row| {
        u64::from(group_of_row[solver_row]) << GROUP | class << CLASS | solver_row as u64
    }
}

/// The higher solver body of two bodies.
pub(crate) fn last_row(solver_row_of: &[u32], a: u32, b: u32) -> usize {
    solver_row_of[a as usize].max(solver_row_of[b as usize]) as usize
}

/// The class in a sort key.
const fn class_in(key: u64) -> u8 {
    (key >> CLASS).to_le_bytes()[0]
}

/// Prefetch distance, in constraints, while keys are made: each constraint is on another cache
/// line.
const PREFETCH: usize = 8;

/// Sorts all colors of one kind of constraint in parallel.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sorter {
    /// One list for each worker.
    keys: Vec<Vec<(u64, u32)>>,
    /// One list for each color.
    runs: Vec<Vec<Run>>,
}

impl Sorter {
    /// Sorts the lists of all colors by key, records the place of each member, and cuts the lists
    /// into runs where a key's bits from `shift` up change. The order within a color never affects
    /// the result. `ask` prefetches the data that `key_of` reads.
    pub(crate) fn sort(
        &mut self,
        shift: u32,
        colorings: [&mut Coloring; 2],
        ask: impl Fn(u32) + Sync,
        key_of: impl Fn(u32) -> Option<u64> + Sync,
        set_place: impl Fn(u32, Place) + Sync,
        out: &mut Vec<Run>,
        jobs: &Jobs<'_>,
    ) {
        let [free, fixed] = colorings;
        let (firsts, n) = (free.colors.len(), free.colors.len() + fixed.colors.len());
        self.runs.resize_with(n.max(self.runs.len()), Vec::new);
        // SAFETY: each color, with its list of runs, belongs to one chunk.
        let apart = unsafe { Apart::promise() };
        let all_runs = Rows::new(&mut self.runs, apart);
        let [free, fixed] = [free, fixed].map(|coloring| Rows::new(&mut coloring.colors, apart));
        for_each_with(jobs, n, &mut self.keys, |keys, k| {
            let (colors, is_fixed, index) = match k.checked_sub(firsts) {
                None => (&free, false, k),
                Some(index) => (&fixed, true, index),
            };
            let runs = all_runs.row(k);
            let members = &mut colors.row(index).members;
            keys.clear();
            for (k, row) in members.iter().enumerate() {
                if let Some(soon) = members.get(k + PREFETCH) {
                    ask(*soon);
                }
                keys.extend(key_of(*row).map(|key| (key, *row)));
            }
            sort_members(members, keys, index, &set_place);
            runs.clear();
            find_runs(keys, shift, is_fixed, index, runs);
        });
        out.clear();
        out.extend(self.runs[..n].iter().flatten());
    }
}

/// Cuts a sorted color where the key's bits from `shift` up change.
fn find_runs(keys: &[(u64, u32)], shift: u32, fixed: bool, color: usize, runs: &mut Vec<Run>) {
    let mut first = 0;
    while let Some((key, _)) = keys.get(first) {
        let n = keys[first..].partition_point(|(k, _)| k >> shift == key >> shift);
        let class = class_in(*key);
        let (group, end) = (key >> GROUP, first + n);
        runs.push(Run { group, class, fixed, color, first, end });
        first = end;
    }
}

/// Sorts a color's list by key and records the place of each member. The order within a color never
/// affects the result.
fn sort_members(
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
