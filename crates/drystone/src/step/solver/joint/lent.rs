//! Rows of joints: their memory, kept from step to step, and as they are lent to the workers of a
//! phase.

use super::block::{JointBlock, JointExtra};
use super::coupling_row::CouplingRow;
use super::six_dof::block::SixDofBlock;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::step::solver::plan::Plan;
use crate::step::solver::totals_rows::JointTally;
use crate::step::solver::work::Bound;

/// Blocks of eight joints, and couplings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointRows<'a> {
    /// Ball and distance joints.
    pub(crate) blocks: Rows<'a, JointBlock>,
    pub(crate) extras: Rows<'a, JointExtra>,
    /// Six-axis joints.
    pub(crate) six_dof: Rows<'a, SixDofBlock>,
    pub(crate) couplings: Rows<'a, CouplingRow>,
    /// One for each island that has joints.
    pub(crate) bounds: Rows<'a, Bound>,
    /// Sums for `blocks` and for `six_dof`; empty unless something can break.
    pub(crate) tallies: Rows<'a, JointTally>,
    pub(crate) six_dof_tallies: Rows<'a, JointTally>,
}

/// Memory of the rows of joints. The fields are those of [`JointRows`].
#[derive(Clone, Debug, Default)]
pub(crate) struct JointScratch {
    blocks: Vec<JointBlock>,
    extras: Vec<JointExtra>,
    six_dof: Vec<SixDofBlock>,
    couplings: Vec<CouplingRow>,
    bounds: Vec<Bound>,
    tallies: Vec<JointTally>,
    six_dof_tallies: Vec<JointTally>,
}

impl JointScratch {
    /// Allocates the rows of a step; sums only if something can break.
    pub(crate) fn allocate(&mut self, plan: &Plan, breakage: bool) {
        let (n, six_dof) = (plan.joints.owners.len(), plan.six_dof.owners.len());
        self.blocks.resize_with(n, JointBlock::default);
        self.extras.resize_with(n, JointExtra::default);
        self.six_dof.resize_with(six_dof, SixDofBlock::default);
        self.couplings.resize(plan.couplings.len(), CouplingRow::default());
        plan.bins.begin(&mut self.bounds);
        let sums = |n: usize| if breakage { n } else { 0 };
        self.tallies.resize(sums(n), JointTally::default());
        self.six_dof_tallies.resize(sums(six_dof), JointTally::default());
    }

    pub(crate) fn lend(&mut self, apart: Apart) -> JointRows<'_> {
        JointRows {
            blocks: Rows::new(&mut self.blocks, apart),
            extras: Rows::new(&mut self.extras, apart),
            six_dof: Rows::new(&mut self.six_dof, apart),
            couplings: Rows::new(&mut self.couplings, apart),
            bounds: Rows::new(&mut self.bounds, apart),
            tallies: Rows::new(&mut self.tallies, apart),
            six_dof_tallies: Rows::new(&mut self.six_dof_tallies, apart),
        }
    }
}
