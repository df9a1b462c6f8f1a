//! Overlaps of links: rows of the position pass that ends a substep, which leaves no speed.

use super::group::{NO_LINK, TreeGroup};
use super::rows::Jacobian;
use crate::step::solver::lent::Solver;

/// Compliance of a position row, as a part of the response of free links. It bounds the motion of a
/// tree whose links hardly move along the row.
const COMPLIANCE: f64 = 1.0e-3;

impl Solver<'_> {
    /// Gives each tree a row for each point of its links that overlaps, beside those of its limits.
    pub(super) fn add_overlaps(&self, trees: &mut TreeGroup) {
        // A little of the overlap stays, so that a resting point keeps its contact.
        let kept = f64::from(self.ctx.margin) * KEPT;
        for index in 0..trees.contacts.len() {
            let contact = trees.contacts[index];
            let block = self.contact.blocks.read(contact.block);
            if self.contact.has_extras {
                let extra = self.contact.extras.read(contact.block);
                if extra.softens && extra.soft_mass[contact.lane] > 0.0 {
                    continue;
                }
            }
            let of = contact
                .links
                .map(|link| (link != NO_LINK).then(|| trees.links[link as usize].tree as usize));
            let share =
                if let [Some(a), Some(b)] = of { if a == b { 1.0 } else { 0.5 } } else { 1.0 };
            for k in 0..contact.count {
                let jacobian = Jacobian::of(block, contact.lane, k, contact.count);
                // The other body has moved since the rows were made.
                let gap = self.separation(block, &contact, &jacobian, k) + kept;
                if gap >= 0.0 {
                    continue;
                }
                for (end, tree) in of.into_iter().enumerate() {
                    let Some(tree) = tree.filter(|tree| end == 0 || of[0] != Some(*tree)) else {
                        continue;
                    };
                    self.add_overlap(trees, (tree, contact.first + k), gap * share);
                }
            }
        }
    }

    fn add_overlap(&self, trees: &mut TreeGroup, (tree, row): (usize, usize), gap: f64) {
        let TreeGroup { trees, rows, sparse, dense, .. } = trees;
        let (tree, row) = (&trees[tree], &rows[row]);
        let range = tree.first..tree.first + tree.count;
        for i in row.begin..row.end {
            let dof = sparse.dofs[i] as usize;
            if range.contains(&dof) {
                dense[dof] = sparse.numbers[i];
            }
        }
        if let Some(articulation) = self.articulation.table.row(tree.row as usize) {
            let free = if row.part > 0.0 { 1.0 / (row.mass * row.part * row.part) } else { 0.0 };
            let numbers = &dense[range.clone()];
            articulation.model.work.add_gap(numbers, gap, COMPLIANCE * free);
        }
        dense[range].fill(0.0);
    }
}

/// Part of the margin of contacts that stays as an overlap.
const KEPT: f64 = 0.01;
