//! Makes the solver bodies of a group when it begins.
//!
//! Reads: bodies, the plan. Writes: the group's solver bodies, with their whitening, forces and
//! squeezes. Runs: parallel over solver bodies.

use core::sync::atomic::{AtomicBool, Ordering};

use super::integrate;
use super::squeeze::Squeeze;
use super::state::BodyState;
use crate::base::math::Vec3;
use crate::base::simd::wide::LANES;
use crate::base::threads::jobs::{Jobs, for_shares};
use crate::state::bodies::body::Body;
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::group::Group;

impl Solver<'_> {
    /// True if a translation of one of the bodies is locked.
    pub(crate) fn prepare_bodies(&self, number: usize, jobs: &Jobs<'_>) -> bool {
        let group = &self.plan.groups[number];
        let n = group.solver_rows.len();
        let found = [false; 2].map(AtomicBool::new);
        for_shares(jobs, n, 64, |part| {
            let mut any = [false; 2];
            let (first, end) =
                (part.start + group.solver_rows.start, part.end + group.solver_rows.start);
            for eight in (first..end).step_by(LANES) {
                let rows = &self.plan.members[eight - 1..(eight + LANES).min(end) - 1];
                let starts: [BodyState; LANES] =
                    core::array::from_fn(|lane| self.at_start(rows[lane.min(rows.len() - 1)]));
                let bodies = rows.iter().map(|row| self.bodies.at(*row));
                let gyrations = integrate::gyrations(self.ctx, bodies.clone().zip(&starts));
                for (lane, body) in bodies.enumerate() {
                    // A group in rounds has no contacts, and without load a body keeps its own
                    // mass.
                    let factor =
                        if self.ctx.rounds > 1 { 1.0 } else { self.ctx.inertia.factor(body) };
                    any[0] |= factor > body.history.inertia_factor;
                    any[1] |=
                        self.put_body(eight + lane, body, factor, &starts[lane], gyrations[lane]);
                }
            }
            for (found, any) in found.iter().zip(any).filter(|(_, any)| *any) {
                found.store(any, Ordering::Relaxed);
            }
        });
        let [heavier, locked] = found.map(AtomicBool::into_inner);
        heavier.then(|| self.slow_heavier(number, jobs));
        locked
    }

    pub(crate) fn put_body(
        &self,
        i: usize,
        body: &Body,
        factor: f32,
        start: &BodyState,
        gyration: Vec3,
    ) -> bool {
        let (solver_body, whitening, aux, acc) =
            integrate::whiten(self.ctx, body, factor, start, gyration);
        let subdivision = self.ctx.subdivision;
        *self.body.squeezes.row(i) = Squeeze { factor, subdivision, impulse: [0.0; 4] };
        (*self.body.solver_bodies.row(i), *self.body.whitening.row(i)) = (solver_body, whitening);
        (*self.body.aux.row(i), *self.body.acceleration.row(i)) = (aux, acc);
        aux.is_locked()
    }

    /// Removes locked translations: a projection after every pass.
    pub(crate) fn hold_locked(&self, group: &Group) {
        for i in group.solver_rows.clone() {
            self.body.aux.read(i).hold_locked(self.body.solver_bodies.row(i));
        }
    }
}
