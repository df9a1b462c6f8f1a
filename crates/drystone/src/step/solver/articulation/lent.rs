//! Memory of articulations in the solver, and the table as it is lent to the workers of a phase.

use super::group::TreeGroup;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::state::articulations::{ArticulationRow, Articulations};
use crate::step::solver::plan::Plan;

/// Memory of groups with articulations, kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct ArticulationScratch {
    groups: Vec<TreeGroup>,
}

/// Rows of articulations, and the memory of each group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArticulationRows<'a> {
    pub(crate) table: Rows<'a, Option<ArticulationRow>>,
    /// One for each group; empty without articulations.
    pub(crate) groups: Rows<'a, TreeGroup>,
}

impl ArticulationScratch {
    pub(crate) fn lend<'a>(
        &'a mut self,
        plan: &Plan,
        table: &'a mut Articulations,
        apart: Apart,
    ) -> ArticulationRows<'a> {
        let count = if plan.articulations.is_empty() { 0 } else { plan.groups.len() };
        self.groups.resize_with(count, TreeGroup::default);
        ArticulationRows {
            table: Rows::new(table.rows.values_mut(), apart),
            groups: Rows::new(&mut self.groups, apart),
        }
    }
}
