//! Load-adaptive inertia: gives bodies under high load a slower response, so that stacks and heavy
//! loads do not sink into their supports.
//!
//! A soft contact under a load N yields by N / (m ω²). In a tall stack the lowest contacts carry a
//! hundred times the weight of one body, and yield a hundred times as much. Shock propagation makes
//! the bodies below infinitely heavy [Guendelman03]; this is a bounded version of it.
//!
//! A body under a squeeze of more than a few times its weight has mass and inertia multiplied by s,
//! 1 to `maximum`, within the solver. Forces on it keep their size, so its acceleration is divided
//! by s. Statics do not depend on mass: loads and the limits of friction and tipping stay exact.
//! Only the response to a change is slower. See docs/decisions/015-load-adaptive-inertia.md for the
//! effect of each number below.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use super::integrate;
use super::island_motion::{Frames, MemberMotion};
use super::state::BodyState;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, for_shares};
use crate::state::bodies::NONE;
use crate::state::bodies::body::Body;
use crate::state::contacts::Contact;
use crate::step::solver::lent::Solver;

/// Prefetch distance, in contacts.
const PREFETCH: usize = 8;

impl Solver<'_> {
    /// Adjusts the velocities of bodies that grow heavier to the motion of their island. Sums run
    /// in the order of bodies and of contact rows, so neither grouping nor the number of workers
    /// changes them.
    pub(crate) fn slow_heavier(&self, number: usize, jobs: &Jobs<'_>) {
        let (group, frames) = (&self.plan.groups[number], self.body.frames.row(number));
        let (first, n) = (group.solver_rows.start, group.solver_rows.len());
        let body_of = |i: usize| self.bodies.at(self.plan.members[i - 1]);
        let read = |k: usize| {
            let body = body_of(first + k);
            MemberMotion {
                island: body.sleep.island,
                mass: body.inertia.mass,
                v: body.v,
                w: body.w,
                heavier: self.body.squeezes.read(first + k).factor > body.history.inertia_factor,
            }
        };
        // Bodies are far apart in memory, so several workers read them into a copy first. A single
        // worker would gain nothing by it.
        let copies = jobs.workers() > 1;
        if copies {
            frames.members.resize(n, MemberMotion::default());
            // SAFETY: each member belongs to one part.
            let members = Rows::new(&mut frames.members, unsafe { Apart::promise() });
            for_shares(jobs, n, 64, |part| part.for_each(|k| *members.row(k) = read(k)));
        }
        let member = |frames: &Frames, k: usize| if copies { frames.members[k] } else { read(k) };
        frames.begin(n, member);
        let mut supports = core::mem::take(&mut frames.supports);
        supports.clear();
        for batch in self.plan.contacts.batches[group.contacts.clone()].iter().filter(|b| b.fixed) {
            let rows = self.plan.contacts.owners[batch.blocks.clone()].iter().flatten();
            supports.extend(rows.copied().filter(|row| *row != NONE));
        }
        supports.sort_unstable();
        for (k, row) in supports.iter().enumerate() {
            if let Some(soon) = supports.get(k + PREFETCH) {
                self.contacts.prefetch(*soon as usize, 4);
            }
            if let Some(contact) = self.contacts.read(*row as usize) {
                self.add_support(contact, frames);
            }
        }
        frames.supports = supports;
        // Joints are far away in memory: read them only where no contact carries the island.
        let members = if frames.frames.iter().all(|frame| frame.held) { 0 } else { n };
        for k in 0..members {
            let island = member(frames, k).island;
            let frame = frames.of(island);
            if !frame.held {
                let joints = &body_of(first + k).ties.joints;
                frame.held = joints.iter().any(|row| self.is_to_fixed(*row));
            }
        }
        for_shares(jobs, n, 64, |part| {
            for k in part.filter(|k| member(frames, *k).heavier) {
                let i = first + k;
                let (body, factor) = (body_of(i), self.body.squeezes.read(i).factor);
                let frame = &frames.frames[frames.place(body.sleep.island)];
                if frame.held {
                    let (v, w) = frame.slowed(body, factor);
                    self.put_slowed(i, body, factor, &BodyState { v, w, ..BodyState::of(body) });
                } else {
                    self.put_slowed(i, body, body.history.inertia_factor, &BodyState::of(body));
                }
            }
        });
    }

    fn put_slowed(&self, i: usize, body: &Body, factor: f32, start: &BodyState) {
        self.put_body(i, body, factor, start, integrate::gyration(self.ctx, body, start));
    }

    /// True for a joint to a body that cannot be pushed.
    fn is_to_fixed(&self, joint: u32) -> bool {
        let free = |row: u32| self.bodies.at(row).is_dynamic();
        let joint = self.joint_slots.read(joint as usize).as_ref();
        joint.is_some_and(|j| !free(j.body_a) || !free(j.body_b))
    }

    /// Adds the motion of the fixed side of a contact to its island's frame.
    fn add_support(&self, c: &Contact, frames: &mut Frames) {
        let (a, b) = (self.bodies.at(c.body_a), self.bodies.at(c.body_b));
        let (support, island) =
            match [c.body_a, c.body_b].map(|row| self.body.solver_row_of[row as usize]) {
                // A contact may still name a body that was deactivated.
                [0, 0] => return,
                [0, _] => (a, b.sleep.island),
                _ => (b, a.sleep.island),
            };
        let frame = frames.of(island);
        for p in c.points() {
            let r = a.center + p.r_a - support.center;
            frame.support.add(p.impulse, support.velocity_at(r), support.w);
            frame.held |= p.impulse > 0.0;
        }
    }
}
