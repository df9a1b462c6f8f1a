//! Prepares, sweeps and stores couplings and pulleys.

use super::coupling_row::{CouplingRow, Part, Start, push};
use super::sweep::JointSweep;
use crate::base::id::JointId;
use crate::base::math::bounded;
use crate::state::joints::JointModel;
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::group::Group;

impl Solver<'_> {
    pub(crate) fn prepare_couplings(&self, group: &Group) {
        for i in group.couplings.clone() {
            let row = self.joint.couplings.row(i);
            *row = CouplingRow::default();
            let Some(joint) = self.joint_slots.read(self.plan.couplings[i].1 as usize) else {
                continue;
            };
            let mass = |body: u32| {
                let solver_row = self.body.solver_row_of[body as usize] as usize;
                let whitening = self.body.whitening.read(solver_row);
                (solver_row, whitening.alpha(), whitening.s())
            };
            let look = |id: JointId| self.joint_slots.read(id.index() as usize).as_ref();
            let Some(start) = Start::new(joint, look, self.bodies, mass) else { continue };
            (row.source, row.c, row.is_slack) = (start.source, start.c, start.is_slack);
            let impulse = start.impulse;
            row.impulse = impulse * self.ctx.impulse_scale;
            let start = JointSweep::solving(self.ctx, 0.0);
            let now = row.now(&self.body.solver_bodies, &start);
            for (part, carried) in now.parts.iter().zip(&mut row.carried) {
                let (v, w) = (part.v * row.impulse, part.w * row.impulse);
                *carried = Part { solver_row: part.solver_row, v, w };
                push(&self.body.solver_bodies, part.solver_row, v, w);
            }
        }
    }

    pub(crate) fn sweep_couplings(&self, group: &Group, sweep: &JointSweep) {
        for i in group.couplings.clone() {
            self.joint.couplings.row(i).solve(&self.body.solver_bodies, sweep);
        }
    }

    pub(crate) fn store_couplings(&self, group: &Group) {
        for i in group.couplings.clone() {
            let Some(joint) = self.joint_slots.row(self.plan.couplings[i].1 as usize) else {
                continue;
            };
            let impulse = bounded(self.joint.couplings.read(i).impulse * self.ctx.store_scale());
            match &mut joint.model {
                JointModel::Coupling(coupling) => coupling.impulse = impulse,
                _ => joint.impulse.x = impulse,
            }
        }
    }
}
