//! Numbers the islands that have joints, group by group, for the bound on their energy
//! (`solver/bound.rs`).

use super::group::{Group, number};
use crate::base::grow;
use crate::state::bodies::{Bodies, NONE};
use crate::state::joints::Joints;
use crate::step::solver::work::Bound;

/// Maximum number of bodies of a bounded island. One limb is no reason to scale down all impulses
/// of a thousand bodies. Checking the bound twice per substep would cost as much as solving them.
const MAX: usize = 1000;

/// The islands that have joints, group by group.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bins {
    pub(crate) count: usize,
    /// Number of each solver body's island, or [`NONE`].
    pub(crate) of_row: Vec<u32>,
    /// Solver bodies of these islands, island by island, in the order of the rows in the table of
    /// bodies. (The order of solver bodies differs in a world that continues from a snapshot.)
    pub(crate) solver_rows: Vec<u32>,
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
        self.solver_rows.clear();
        if joints.rows.is_empty() {
            self.of_row.clear();
            groups.iter_mut().for_each(|group| (group.bins, group.bin_rows) = (0..0, 0..0));
            return;
        }
        grow::resize(&mut self.of_row, members.len() + 1, NONE);
        self.of_row.fill(NONE);
        let body = |solver_body: usize| bodies.at(members[solver_body - 1]);
        for group in groups {
            let (first, begin) = (self.count, self.solver_rows.len());
            let kinds = [&group.joints, &group.six_dof, &group.couplings, &group.trees];
            let has_joints = kinds.iter().any(|kind| !kind.is_empty());
            // Articulations bound their own energy.
            let bounds = has_joints && group.articulations.is_empty();
            let solver_rows = if bounds { group.solver_rows.clone() } else { 0..0 };
            for solver_body in
                solver_rows.clone().filter(|solver_body| !body(*solver_body).ties.joints.is_empty())
            {
                let island = body(solver_body).sleep.island as usize;
                if self.of_island.len() <= island {
                    self.of_island.resize(island + 1, NONE);
                }
                if self.of_island[island] == NONE {
                    self.of_island[island] = number(self.count);
                    self.count += 1;
                }
            }
            for solver_body in solver_rows.clone() {
                let island = body(solver_body).sleep.island as usize;
                if let Some(bin) = self.of_island.get(island).filter(|bin| **bin != NONE) {
                    self.of_row[solver_body] = *bin;
                    self.solver_rows.push(number(solver_body));
                }
            }
            let of_row = &self.of_row;
            self.solver_rows[begin..].sort_unstable_by_key(|solver_body| {
                (of_row[*solver_body as usize], members[*solver_body as usize - 1])
            });
            self.leave_out_large(begin);
            for solver_body in solver_rows {
                if let Some(bin) = self.of_island.get_mut(body(solver_body).sleep.island as usize) {
                    *bin = NONE;
                }
            }
            (group.bins, group.bin_rows) = (first..self.count, begin..self.solver_rows.len());
        }
    }

    /// Removes the islands that are too large from `lines[begin..]`.
    fn leave_out_large(&mut self, begin: usize) {
        let of_row = &self.of_row;
        let same = |a: &u32, b: &u32| of_row[*a as usize] == of_row[*b as usize];
        let large =
            self.solver_rows[begin..].chunk_by(same).filter(|solver_rows| solver_rows.len() > MAX);
        let large: Vec<u32> = large.flatten().copied().collect();
        large.iter().for_each(|solver_row| self.of_row[*solver_row as usize] = NONE);
        if !large.is_empty() {
            let of_row = &self.of_row;
            self.solver_rows.retain(|solver_row| of_row[*solver_row as usize] != NONE);
        }
    }
}
