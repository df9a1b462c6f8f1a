//! Solves a step in rounds, one for each substep of the world, for islands that turn far in a step
//! and have only joints.
//!
//! Rows use the inertia and the gyroscopic torque of the moment at which they were built, and
//! rotation vectors of a step do not add. For a body that turns by a radian in a step both are
//! wrong, and its joints gain energy from the error. A pendulum of four bodies at 60 Hz went from
//! 0.1 to 10 J in five seconds, then overflowed. So each round starts from the poses at the end of
//! the last one, with new rows. (Contact points stay those of the step's start, so an island that
//! touches something is solved in one round.)

use super::body::state::BodyState;
use super::lent::Solver;
use super::plan::group::Group;
use crate::base::threads::jobs::Jobs;
use crate::state::bodies::body::Body;

impl Solver<'_> {
    /// Solves a group for the whole step, round by round.
    pub(super) fn solve_in_rounds(&self, number: usize, jobs: &Jobs<'_>) {
        let group = &self.plan.groups[number];
        let mut ctx = *self.ctx;
        for round in 0..ctx.rounds {
            let solver = Solver { ctx: &ctx, round, ..*self };
            solver.solve_once(number, jobs);
            solver.move_on(group);
            // A round stores the impulses that the next one starts from, both as impulses of whole
            // substeps.
            ctx.impulse_scale = 1.0 / ctx.store_scale();
        }
        for i in group.solver_rows.clone() {
            self.put_end(i, *self.body.states.read(i));
        }
    }

    /// Stores a body's state at the step's end. Its solver body keeps its motion, which `finalize`
    /// then does not read.
    pub(super) fn put_end(&self, solver_row: usize, end: BodyState) {
        *self.body.states.row(solver_row) = end;
        self.body.aux.row(solver_row).ended = true;
    }

    /// State of a body at the start of the round.
    #[inline(always)]
    pub(super) fn at_start(&self, row: u32) -> BodyState {
        let body = self.bodies.at(row);
        if self.round == 0 { BodyState::of(body) } else { self.moved(row, body) }
    }

    fn moved(&self, row: u32, body: &Body) -> BodyState {
        let solver_row = self.body.solver_row_of[row as usize] as usize;
        if solver_row != 0 {
            return *self.body.states.read(solver_row);
        }
        let start = BodyState::of(body);
        if !body.active() {
            return start;
        }
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let elapsed = self.round as f32 * self.ctx.dt;
        start.drifted(elapsed)
    }

    fn move_on(&self, group: &Group) {
        for i in group.solver_rows.clone() {
            let start = self.at_start(self.plan.members[i - 1]);
            *self.body.states.row(i) =
                start.after(self.body.solver_bodies.read(i), self.body.whitening.read(i));
        }
    }
}
