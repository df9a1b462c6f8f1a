//! Solves bodies together with particles.
//!
//! Groups with a body that particles touch or hold run each pass together with the particles. A
//! group's result is the same as alone. With a classic method, particles follow the bodies' whole
//! step.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use super::body::integrate;
use super::body::solved::Solved;
use super::body::state::BodyState;
use super::lent::Solver;
use super::pass::PassStep;
use super::plan::Plan;
use crate::base::math::Vec3;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, for_ranges};
use crate::state::bodies::Bodies;
use crate::state::def::method::Pass;
use crate::step::context::StepContext;
use crate::step::particles::pace::SolverBodies;
use crate::step::particles::tied;
use crate::step::particles::tied::Tied;
use crate::step::solver_body::three;

/// Finds the groups with a dragged body.
pub(super) fn find_groups(plan: &Plan, solver_row_of: &[u32], tied: &mut tied::Scratch) {
    tied.groups.clear();
    for row in &tied.dragged {
        let solver_row = solver_row_of[*row as usize];
        debug_assert!(solver_row != 0, "dragged bodies have solver_rows");
        if solver_row != 0 {
            tied.groups.push(plan.group_of(solver_row));
        }
    }
    tied.groups.sort_unstable();
    tied.groups.dedup();
}

impl Solver<'_> {
    /// Solves the groups of dragged bodies and the particles for the step.
    pub(super) fn solve_with_particles(&self, tied: &mut Tied<'_>, jobs: &Jobs<'_>) {
        if tied.is_idle() {
            tied.particles.touches.clear();
            tied.scratch.groups.clear();
            return;
        }
        let groups = core::mem::take(&mut tied.scratch.groups);
        self.for_groups(&groups, jobs, &|i, number, jobs| {
            *self.progress.row(i) = self.begin(number, jobs);
        });
        let to = SolverBodies {
            solver_row_of: self.body.solver_row_of,
            solver_bodies: self.body.solver_bodies,
            whitening: self.body.whitening,
        };
        tied.begin(self.bodies, &to, jobs);
        for step in self.pass_steps() {
            self.for_groups(&groups, jobs, &|i, number, jobs| {
                self.run_pass(number, step, self.progress.row(i), jobs);
            });
            self.run_particle_pass(step, tied, jobs);
        }
        tied.end(self.body.solver_bodies, jobs);
        self.for_groups(&groups, jobs, &|i, number, jobs| {
            self.end(number, self.progress.read(i), jobs);
        });
        tied.scratch.groups = groups;
    }

    /// Calls `f` with each group's index in the list and its number. Shared groups run one after
    /// another.
    fn for_groups(
        &self,
        groups: &[usize],
        jobs: &Jobs<'_>,
        f: &(dyn Fn(usize, usize, &Jobs<'_>) + Sync),
    ) {
        let shared = groups.partition_point(|number| *number < self.plan.shared);
        for (i, number) in groups[..shared].iter().enumerate() {
            f(i, *number, jobs);
        }
        for_ranges(jobs, groups.len() - shared, 1, |range| {
            for i in range {
                f(shared + i, groups[shared + i], &Jobs::Inline);
            }
        });
    }

    fn run_particle_pass(&self, step: PassStep, tied: &mut Tied<'_>, jobs: &Jobs<'_>) {
        let PassStep { substep, pass, kicks } = step;
        match pass {
            Pass::Velocities => tied.velocities(substep == 0, jobs),
            Pass::Solve { .. } => tied.solve(substep, self.body.solver_bodies, jobs),
            Pass::Positions => {
                tied.positions(jobs);
                if kicks {
                    tied.velocities(false, jobs);
                }
            }
            Pass::Relax => {
                #[expect(clippy::cast_precision_loss, reason = "at most 256")]
                let moved = (substep + 1).min(self.ctx.substeps) as f32 * self.ctx.h;
                tied.relax(moved, self.body.solver_bodies, jobs);
            }
            _ => {}
        }
    }
}

/// Steps particles after a classic method, and whitens the solver bodies of dragged bodies for
/// this.
pub(super) fn follow(
    ctx: &StepContext,
    bodies: &Bodies,
    solved: &mut Solved,
    tied: &mut Tied<'_>,
    jobs: &Jobs<'_>,
) {
    if tied.is_idle() {
        tied.particles.touches.clear();
        return;
    }
    for row in &tied.scratch.dragged {
        let (solver_row, body) = (solved.solver_row_of[*row as usize] as usize, bodies.at(*row));
        let was = solved.solver_bodies[solver_row];
        let start = BodyState::of(body);
        let velocity = BodyState { v: three(was.v), w: three(was.w), ..start };
        let (mut to, whitening, ..) = integrate::whiten(ctx, body, 1.0, &velocity, Vec3::ZERO);
        let motion = BodyState { v: three(was.x), w: three(was.t), ..start };
        let (progress, ..) = integrate::whiten(ctx, body, 1.0, &motion, Vec3::ZERO);
        (to.x, to.t) = (progress.v, progress.w);
        (solved.solver_bodies[solver_row], solved.whitening[solver_row], solved.free[solver_row]) =
            (to, whitening, Some(false));
    }
    // SAFETY: particles are solved by colors, whose rows share no body that can be pushed.
    let apart = unsafe { Apart::promise() };
    let to = SolverBodies {
        solver_row_of: &solved.solver_row_of,
        solver_bodies: Rows::new(&mut solved.solver_bodies, apart),
        whitening: Rows::new(&mut solved.whitening, apart),
    };
    tied.follow(bodies, &to, jobs);
}
