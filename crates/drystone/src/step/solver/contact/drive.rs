//! Runs the passes over contact blocks: fills, sweeps and stores them, and sums impulses where
//! needed.

use core::sync::atomic::{AtomicBool, Ordering};
use fearless_simd::dispatch;

use super::sweep::ContactSweep;
use super::{kernel, prepare, raw};
use crate::base::simd::wide::LANES;
use crate::base::threads::jobs::Jobs;
use crate::state::contacts::Contact;
use crate::step::context::StepContext;
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::group::Group;
use crate::step::solver::plan::joint_class::{TURNING, is_linked};
use crate::step::solver_body;

impl Solver<'_> {
    /// Records the solver bodies that nothing pushed, among those near a surface with restitution.
    pub(crate) fn find_free(&self, group: &Group) {
        let batches = &self.plan.contacts.batches[group.contacts.clone()];
        let free = batches.iter().filter(|batch| !is_linked(batch.class));
        for i in free.flat_map(|batch| batch.blocks.clone()) {
            let (block, extra) = (self.contact.blocks.read(i), self.contact.extras.read(i));
            if !extra.bounces {
                continue;
            }
            for lane in 0..LANES {
                for solver_row in [block.row_a[lane] as usize, block.row_b[lane] as usize] {
                    let bounces = solver_row != 0 && extra.restitution[lane] > 0.0;
                    if bounces && self.body.free.read(solver_row).is_none() {
                        let body = self.bodies.at(self.plan.members[solver_row - 1]);
                        let start = solver_body::whitened(
                            body.v,
                            self.body.whitening.read(solver_row).alpha(),
                        );
                        let (aux, end) = (
                            self.body.aux.read(solver_row),
                            self.body.solver_bodies.read(solver_row),
                        );
                        let ctx = self.ctx;
                        *self.body.free.row(solver_row) =
                            Some(aux.flew(end, start, ctx.substeps, ctx.h));
                    }
                }
            }
        }
    }
}

impl Solver<'_> {
    /// The tables from which blocks are filled.
    pub(crate) fn pack_source<'s>(&'s self, ctx: &'s StepContext) -> raw::Source<'s> {
        raw::Source {
            ctx,
            bodies: self.bodies,
            solver_row_of: self.body.solver_row_of,
            whitening: &self.body.whitening,
            acceleration: &self.body.acceleration,
            contacts: &self.contacts,
            softened: self.softened,
            shapes: self.shapes,
            parts: self.contact.parts,
            may_impact: self.contact.has_impacts,
            is_renewed: false,
            turning: self.contact.turning,
        }
    }

    /// The blocks of contacts of links, in ascending order.
    pub(crate) fn link_blocks(&self, group: &Group) -> impl Iterator<Item = usize> {
        let batches = &self.plan.contacts.batches[group.contacts.clone()];
        batches.iter().filter(|batch| is_linked(batch.class)).flat_map(|b| b.blocks.clone())
    }

    /// Fills the blocks; true if some contact bounces or gets an impact in this step.
    pub(crate) fn prepare_contacts(&self, group: &Group, jobs: &Jobs<'_>) -> bool {
        let source = self.pack_source(self.ctx);
        let arrives = AtomicBool::new(false);
        self.plan.contacts.for_blocks(&group.contacts, jobs, 4, |batch, blocks| {
            let mut any = false;
            dispatch!(self.ctx.level, simd => {
                for i in blocks {
                    let owners = &self.plan.contacts.owners[i];
                    self.prefetch_contacts(i + 1);
                    let block = self.contact.blocks.row(i);
                    let extra = if self.contact.has_extras { Some(self.contact.extras.row(i)) } else { None };
                    if is_linked(batch.class) {
                        prepare::build::<_, false>(simd, &source.for_links(), owners, block, extra);
                        (block.parting, block.arrives) = (0, 0);
                    } else if batch.fixed {
                        prepare::pack::<_, true>(simd, &source, owners, block, extra, &self.body.solver_bodies);
                    } else {
                        prepare::pack::<_, false>(simd, &source, owners, block, extra, &self.body.solver_bodies);
                    }
                    if self.round == 0 {
                        self.watch(i, batch.class & TURNING != 0);
                    }
                    any |= block.arrives != 0;
                }
            });
            if any {
                arrives.store(true, Ordering::Relaxed);
            }
        });
        arrives.into_inner()
    }

    /// Prefetches the parts of a block's contacts that the solver reads and writes, if there is
    /// such a block.
    #[inline(always)]
    pub(crate) fn prefetch_contacts(&self, block: usize) {
        let Some(owners) = self.plan.contacts.owners.get(block) else { return };
        for &owner in owners {
            if owner != u32::MAX {
                self.contacts.prefetch(owner as usize, Contact::SOLVER_LINES);
            }
        }
    }

    /// `sweeps`: for contacts of two bodies, and for contacts with fixed bodies.
    pub(crate) fn sweep_contacts(
        &self,
        group: &Group,
        sweeps: &[ContactSweep; 2],
        relaxes: bool,
        jobs: &Jobs<'_>,
    ) {
        self.plan.contacts.for_blocks(&group.contacts, jobs, 4, |batch, blocks| {
            if is_linked(batch.class) {
                return;
            }
            let sweep = &sweeps[usize::from(batch.fixed)];
            dispatch!(self.ctx.level, simd => {
                for i in blocks {
                    let (block, next) = (self.contact.blocks.row(i), self.contact.blocks.after(i));
                    let extra = if self.contact.has_extras { Some(self.contact.extras.row(i)) } else { None };
                    let mut tally = self.tally(i);
                    if relaxes && let Some(tally) = &mut tally {
                        tally.add(block, -1.0);
                    }
                    if batch.fixed {
                        kernel::solve::<_, true>(simd, block, extra, next, &self.body.solver_bodies, sweep);
                    } else {
                        kernel::solve::<_, false>(simd, block, extra, next, &self.body.solver_bodies, sweep);
                    }
                    if let Some(tally) = tally {
                        tally.add(block, 1.0);
                        if !relaxes && self.sum_requests.any() {
                            self.contact.peaks.row(i).note(block);
                        }
                    }
                }
            });
        });
    }
}
