//! Solver bodies at the end of a step: the motion of bodies, for `finalize`.

use super::island_motion::Frames;
use super::lent::BodyRows;
use super::row::Aux;
use super::squeeze::Squeeze;
use super::state::BodyState;
use crate::base::grow;
use crate::base::math::Vec3;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::state::bodies::body::Subdivision;
use crate::step::solver::plan::Plan;
use crate::step::solver_body::{SolverBody, Whitening};

/// Solver bodies of a step, from the default methods and the classic ones alike. The first one
/// stands for all bodies that cannot be pushed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solved {
    /// Solver body of each row of the table of bodies; 0: none.
    pub(crate) solver_row_of: Vec<u32>,
    pub(crate) solver_bodies: Vec<SolverBody>,
    pub(crate) whitening: Vec<Whitening>,
    pub(crate) aux: Vec<Aux>,
    pub(crate) squeezes: Vec<Squeeze>,
    /// States of bodies that are solved in rounds or turn far; at the step's end the end states of
    /// solver bodies that have [`Aux::ended`]. Empty unless some body may have one.
    pub(crate) states: Vec<BodyState>,
    /// Whether the solver body flew freely in this step, where known; or empty: see [`Self::flew`].
    pub(crate) free: Vec<Option<bool>>,
    /// Acceleration by forces [m/s²]; only the solver reads it.
    acceleration: Vec<Vec3>,
    /// One for each group; only the solver reads them.
    frames: Vec<Frames>,
}

impl Solved {
    /// Allocates the rows of a step. `bounces`: some surface has restitution.
    pub(crate) fn allocate(&mut self, plan: &Plan, bounces: bool) {
        let n = plan.members.len() + 1;
        grow::resize(&mut self.solver_bodies, n, SolverBody::default());
        grow::resize(&mut self.whitening, n, Whitening::default());
        grow::resize(&mut self.aux, n, Aux::default());
        grow::resize(&mut self.acceleration, n, Vec3::ZERO);
        grow::resize(&mut self.squeezes, n, Squeeze::default());
        let in_rounds = plan.groups.iter().any(|group| group.subdivision == Subdivision::Tumbling);
        // Bodies on one ball joint have end states as well.
        let on_joints = !plan.joints.owners.is_empty();
        let states = in_rounds
            || on_joints
            || !plan.articulations.is_empty()
            || !plan.turning.solver_rows.is_empty();
        grow::resize(&mut self.states, if states { n } else { 0 }, BodyState::default());
        self.frames.resize_with(plan.groups.len().max(self.frames.len()), Frames::default);
        self.free.clear();
        self.free.resize(if bounces { n } else { 0 }, None);
    }

    pub(crate) fn lend(&mut self, apart: Apart) -> BodyRows<'_> {
        BodyRows {
            solver_row_of: &self.solver_row_of,
            solver_bodies: Rows::new(&mut self.solver_bodies, apart),
            whitening: Rows::new(&mut self.whitening, apart),
            aux: Rows::new(&mut self.aux, apart),
            acceleration: Rows::new(&mut self.acceleration, apart),
            squeezes: Rows::new(&mut self.squeezes, apart),
            states: Rows::new(&mut self.states, apart),
            free: Rows::new(&mut self.free, apart),
            frames: Rows::new(&mut self.frames, apart),
        }
    }

    /// Discards the rows, but not the solver body of each row of the table.
    pub(crate) fn discard(&mut self) {
        (self.solver_bodies, self.whitening, self.aux) = Default::default();
        (self.squeezes, self.acceleration) = Default::default();
    }

    /// True if nothing pushed this solver body although a surface with restitution was near. The
    /// body flew and must keep its energy.
    pub(crate) fn flew(&self, solver_row: usize) -> bool {
        matches!(self.free.get(solver_row), Some(Some(true)))
    }

    /// End state of a solver body that does not hold the body's motion.
    pub(crate) fn end(&self, solver_row: usize) -> Option<&BodyState> {
        if self.aux[solver_row].ended { self.states.get(solver_row) } else { None }
    }

    /// Speed at which overlap correction moves the body of a row [m/s].
    pub(crate) fn parting(&self, is_dynamic: bool, row: u32) -> f32 {
        let solver_row = if is_dynamic { self.solver_row_of[row as usize] as usize } else { 0 };
        self.aux.get(solver_row).map_or(0.0, Aux::parting)
    }
}
