//! Runs the passes of a step over a group, in order.

use super::lent::Solver;
use super::pass::{PassStep, Progress};
use super::totals_rows::When;
use crate::base::threads::jobs::Jobs;
use crate::state::bodies::body::Subdivision;
use crate::state::def::method::Pass;

impl Solver<'_> {
    /// Solves a group for the whole step.
    pub(super) fn solve(&self, number: usize, jobs: &Jobs<'_>) {
        if self.ctx.rounds > 1 {
            self.solve_in_rounds(number, jobs);
        } else {
            self.solve_once(number, jobs);
        }
    }

    /// Solves a group for the substeps of its context.
    pub(super) fn solve_once(&self, number: usize, jobs: &Jobs<'_>) {
        let mut progress = self.begin(number, jobs);
        for step in self.pass_steps() {
            self.run_pass(number, step, &mut progress, jobs);
        }
        self.end(number, &progress, jobs);
    }

    /// Builds the group's rows and applies the stored impulses.
    pub(super) fn begin(&self, number: usize, jobs: &Jobs<'_>) -> Progress {
        let group = &self.plan.groups[number];
        let locked = self.prepare_bodies(number, jobs);
        self.prepare_joints(group, jobs);
        self.prepare_couplings(group);
        self.prepare_trees(group);
        let arrives = self.prepare_contacts(group, jobs);
        self.begin_articulations(number);
        if self.turns(group) {
            self.begin_turning(group);
        }
        if self.round == 0 {
            self.begin_tallies(group);
        }
        if self.collides() {
            let blocks = self.plan.contacts.blocks_of(&group.contacts);
            let impacts = self.impacts.row(number);
            impacts.begin(&self.impact_source(group), arrives, blocks, group.solver_rows.len());
        }
        Progress { done: 0, kicked: true, locked }
    }

    /// The passes of a step in execution order.
    pub(super) fn pass_steps(&self) -> impl Iterator<Item = PassStep> {
        let (body, finish) = (self.method.substep(), self.method.finish());
        let substeps = self.ctx.substeps;
        let relaxes = self.ctx.subdivision == Subdivision::Struck && !body.contains(&Pass::Relax);
        let relax: &[Pass] = if relaxes { &[Pass::Impacts, Pass::Relax] } else { &[] };
        let passes = move |substep| body.iter().chain(relax).map(move |p| (substep, *p));
        let steps = (0..substeps).flat_map(passes);
        let mut passes = steps.chain(finish.iter().map(move |p| (substeps, *p))).peekable();
        core::iter::from_fn(move || {
            let (substep, pass) = passes.next()?;
            // Fuse positions and the following velocities into one walk over the bodies.
            let kicks = pass == Pass::Positions
                && passes.next_if(|(_, next)| *next == Pass::Velocities).is_some();
            Some(PassStep { substep, pass, kicks })
        })
    }

    /// Runs one pass over a group.
    pub(super) fn run_pass(
        &self,
        number: usize,
        step: PassStep,
        progress: &mut Progress,
        jobs: &Jobs<'_>,
    ) {
        let group = &self.plan.groups[number];
        match step.pass {
            Pass::Velocities => {
                self.accelerate(group, jobs, step.substep == 0);
                self.move_articulations(number);
                // The velocities contain the warm start, too, which the following impacts must not
                // reflect.
                progress.kicked = true;
            }
            Pass::Positions => {
                let turns = self.turns(group);
                if step.kicks && !turns {
                    self.advance(group, jobs);
                } else {
                    self.drift(group, jobs);
                }
                (progress.done, progress.kicked) = (progress.done + 1, step.kicks);
                if turns {
                    self.renew(number, progress.done, jobs);
                    if step.kicks {
                        self.accelerate(group, jobs, false);
                    }
                }
                self.advance_articulations(number);
                if step.kicks {
                    self.move_articulations(number);
                }
            }
            Pass::Impacts if self.collides() => {
                self.collide(number, progress.done, progress.kicked, jobs);
            }
            pass => {
                self.sweep(group, pass, step.substep, jobs);
                self.bound(group, pass, step.substep);
                // Sum after the bound: impulses that it removed never acted.
                match pass {
                    Pass::Solve { .. } => {
                        self.solve_articulations(number, step.substep);
                        self.add_to_tallies(group, When::solved(step.substep, self.ctx.parts));
                    }
                    Pass::Relax => {
                        self.relax_articulations(number, step.substep);
                        self.add_to_tallies(group, When::relaxed());
                    }
                    _ => {}
                }
            }
        }
        if progress.locked {
            self.hold_locked(group);
        }
    }

    /// Corrects overlaps that no load explains, and stores the impulses in the tables.
    pub(super) fn end(&self, number: usize, progress: &Progress, jobs: &Jobs<'_>) {
        let group = &self.plan.groups[number];
        self.end_articulations(number);
        self.part(group, progress.locked, jobs);
        if self.collides() {
            self.add_impacts(number);
        }
        if self.contact.has_extras {
            self.find_free(group);
        }
        self.store(group, jobs);
        if self.turns(group) {
            self.end_turning(group);
        }
    }
}
