//! Runs the impact passes of the solver.

use super::candidate::{Moment, STILL, Source};
use crate::base::threads::jobs::Jobs;
use crate::step::narrowphase;
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::group::Group;

impl Solver<'_> {
    /// True if some contact may bounce or get an impact in this step.
    pub(crate) fn collides(&self) -> bool {
        self.contact.has_extras || self.contact.has_impacts
    }

    pub(crate) fn impact_source(&self, group: &Group) -> Source<'_> {
        Source {
            level: self.ctx.level,
            blocks: &self.contact.blocks,
            extras: self.contact.has_extras.then_some(&self.contact.extras),
            owners: &self.plan.contacts.owners,
            solver_bodies: &self.body.solver_bodies,
            aux: &self.body.aux,
            whitening: &self.body.whitening,
            acceleration: &self.body.acceleration,
            dt: self.ctx.dt,
            h: self.ctx.h,
            first_row: group.solver_rows.start,
            members: &self.plan.members,
            bodies: self.bodies,
        }
    }

    pub(crate) fn collide(&self, number: usize, done: u16, kicked: bool, jobs: &Jobs<'_>) {
        let ctx = self.ctx;
        let moment = Moment {
            done,
            substeps: u16::try_from(ctx.substeps).expect("at most 256 substeps"),
            h: ctx.h,
            kicked,
            minimum: ctx.restitution_speed,
            impact_speed: narrowphase::turning::IMPACT_SPEED * ctx.length,
            still: STILL * ctx.length,
            push: ctx.push_speed,
        };
        let source = self.impact_source(&self.plan.groups[number]);
        self.impacts.row(number).collide(&source, &moment, jobs);
    }
}
