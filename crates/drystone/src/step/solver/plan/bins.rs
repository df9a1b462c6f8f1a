//! Numbers the islands that have joints, group by group, for the bound on their energy
//! (`solver/bound.rs`).

use super::group::{Group, number};
use crate::base::grow;
use crate::state::bodies::{Bodies, NONE};
use crate::state::joints::Joints;
use crate::step::solver::work::Bound;

/// Maximum number of bodies of a bounded island. One limb is no reason to scale down all impulses
/// of a thousand bodies. Checking the bound twice per substep would cost as much as solving them.
const MOST: usize = 1000;

/// The islands that have joints, group by group.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bins {
    pub(crate) count: usize,
    /// Number of each solver body's island, or [`NONE`].
    pub(crate) of_line: Vec<u32>,
    /// Solver bodies of these islands, island by island, in the order of the rows in the table of
    /// bodies. (The order of solver bodies differs in a world that continues from a snapshot.)
    pub(crate) lines: Vec<u32>,
    /// Number of each island, used while numbering.
    of_island: Vec<u32>,
}

impl Bins {
    /// Makes one empty bound for each island.
    pub(crate) fn begin(&self, bounds: &mut Vec<Bound>) {
        bounds.clear();
        grow::resize(bounds, self.count, Bound::default());
    }

    /// Numbers the islands that have joints. `members` are the table rows of solver bodies 1 and
    /// up.
    pub(crate) fn place(
        &mut self,
        bodies: &Bodies,
        joints: &Joints,
        members: &[u32],
        groups: &mut [Group],
    ) {
        self.count = 0;
        self.lines.clear();
        if joints.rows.is_empty() {
            self.of_line.clear();
            groups.iter_mut().for_each(|group| (group.bins, group.bin_lines) = (0..0, 0..0));
            return;
        }
        grow::resize(&mut self.of_line, members.len() + 1, NONE);
        self.of_line.fill(NONE);
        let body = |line: usize| bodies.at(members[line - 1]);
        for group in groups {
            let (first, begin) = (self.count, self.lines.len());
            let kinds = [&group.joints, &group.sixdofs, &group.couplings, &group.trees];
            let has_joints = kinds.iter().any(|kind| !kind.is_empty());
            let lines = if has_joints { group.lines.clone() } else { 0..0 };
            for line in lines.clone().filter(|line| !body(*line).ties.joints.is_empty()) {
                let island = body(line).sleep.island as usize;
                if self.of_island.len() <= island {
                    self.of_island.resize(island + 1, NONE);
                }
                if self.of_island[island] == NONE {
                    self.of_island[island] = number(self.count);
                    self.count += 1;
                }
            }
            for line in lines.clone() {
                let island = body(line).sleep.island as usize;
                if let Some(bin) = self.of_island.get(island).filter(|bin| **bin != NONE) {
                    self.of_line[line] = *bin;
                    self.lines.push(number(line));
                }
            }
            let of_line = &self.of_line;
            self.lines[begin..].sort_unstable_by_key(|line| {
                (of_line[*line as usize], members[*line as usize - 1])
            });
            self.leave_out_large(begin);
            for line in lines {
                if let Some(bin) = self.of_island.get_mut(body(line).sleep.island as usize) {
                    *bin = NONE;
                }
            }
            (group.bins, group.bin_lines) = (first..self.count, begin..self.lines.len());
        }
    }

    /// Removes the islands that are too large from `lines[begin..]`.
    fn leave_out_large(&mut self, begin: usize) {
        let of_line = &self.of_line;
        let same = |a: &u32, b: &u32| of_line[*a as usize] == of_line[*b as usize];
        let large = self.lines[begin..].chunk_by(same).filter(|lines| lines.len() > MOST);
        let large: Vec<u32> = large.flatten().copied().collect();
        large.iter().for_each(|line| self.of_line[*line as usize] = NONE);
        if !large.is_empty() {
            let of_line = &self.of_line;
            self.lines.retain(|line| of_line[*line as usize] != NONE);
        }
    }
}
