//! Finds the groups that solve articulations.

use core::ops::Range;

use super::Plan;
use crate::state::articulations::Articulations;

impl Plan {
    /// Finds the group of each articulation. One whose links are not all in a group, such as one
    /// that sleeps, is in none.
    pub(super) fn place_articulations(
        &mut self,
        articulations: &Articulations,
        solver_row_of: &[u32],
    ) {
        self.articulations.clear();
        for (id, row) in articulations.rows.iter() {
            let moving = (0..).zip(&row.bodies).filter(|(link, _)| row.model.tree.moves(*link));
            let mut groups = moving.map(|(_, body)| match solver_row_of[*body as usize] {
                0 => None,
                solver_row => Some(self.group_of_row[solver_row as usize]),
            });
            if let Some(Some(first)) = groups.next()
                && groups.all(|group| group == Some(first))
            {
                self.articulations.push((u64::from(first), id.index()));
            }
        }
        self.articulations.sort_unstable();
    }
}

/// The articulations of a group, in a list sorted by groups.
pub(super) fn of_group(all: &[(u64, u32)], group: u64) -> Range<usize> {
    all.partition_point(|(of, _)| *of < group)..all.partition_point(|(of, _)| *of <= group)
}
