//! Rows of joint trees: their memory, kept from step to step, and as they are lent to the workers
//! of a phase.

use super::rows::{TreeBody, TreeRow};
use crate::base::threads::disjoint::{Apart, Rows};
use crate::step::solver::plan::Plan;
use crate::step::solver::totals_rows::TreeTally;

/// Rows of all trees, one tree after another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeRows<'a> {
    /// Gains of eliminated rows.
    pub(crate) gains: Rows<'a, f64>,
    /// One for each body.
    pub(crate) bodies: Rows<'a, TreeBody>,
    /// One for each joint.
    pub(crate) rows: Rows<'a, TreeRow>,
    /// One for each joint; empty unless something can break.
    pub(crate) tallies: Rows<'a, TreeTally>,
}

/// Memory of the rows of trees. The fields are those of [`TreeRows`].
#[derive(Clone, Debug, Default)]
pub(crate) struct TreeScratch {
    gains: Vec<f64>,
    bodies: Vec<TreeBody>,
    rows: Vec<TreeRow>,
    tallies: Vec<TreeTally>,
}

impl TreeScratch {
    /// Allocates the rows of a step; sums only if something can break.
    pub(crate) fn allocate(&mut self, plan: &Plan, breakage: bool) {
        let joints = plan.forest.joints.len();
        self.gains.resize(plan.forest.trees.last().map_or(0, |tree| tree.gains.end), 0.0);
        self.bodies.resize(plan.forest.bodies.len(), TreeBody::default());
        self.rows.resize(joints, TreeRow::default());
        self.tallies.resize(if breakage { joints } else { 0 }, TreeTally::default());
    }

    pub(crate) fn lend(&mut self, apart: Apart) -> TreeRows<'_> {
        TreeRows {
            gains: Rows::new(&mut self.gains, apart),
            bodies: Rows::new(&mut self.bodies, apart),
            rows: Rows::new(&mut self.rows, apart),
            tallies: Rows::new(&mut self.tallies, apart),
        }
    }
}
