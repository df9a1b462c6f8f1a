//! Solver bodies at the end of a step: the motion of bodies, for `finalize`.

use super::row::Aux;
use super::squeeze::Squeeze;
use super::state::BodyState;
use crate::step::solver_body::{SolverBody, Whitening};

/// Solver bodies of a step, from the default methods and the classic ones alike. The first one
/// stands for all bodies that cannot be pushed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solved {
    /// Solver body of each row of the table of bodies; 0: none.
    pub(crate) line_of: Vec<u32>,
    pub(crate) lines: Vec<SolverBody>,
    pub(crate) whitening: Vec<Whitening>,
    pub(crate) aux: Vec<Aux>,
    pub(crate) squeezes: Vec<Squeeze>,
    /// States of bodies that are solved in rounds or turn far; at the step's end the end states of
    /// solver bodies that have [`Aux::ended`]. Empty unless some body may have one.
    pub(crate) states: Vec<BodyState>,
    /// Whether the solver body flew freely in this step, where known; or empty: see [`Self::flew`].
    pub(crate) free: Vec<Option<bool>>,
}

impl Solved {
    /// True if nothing pushed this solver body although a surface with restitution was near. The
    /// body flew and must keep its energy.
    pub(crate) fn flew(&self, line: usize) -> bool {
        matches!(self.free.get(line), Some(Some(true)))
    }

    /// End state of a solver body that does not hold the body's motion.
    pub(crate) fn end(&self, line: usize) -> Option<&BodyState> {
        if self.aux[line].ended { self.states.get(line) } else { None }
    }

    /// Speed at which overlap correction moves the body of a row [m/s].
    pub(crate) fn parting(&self, is_dynamic: bool, row: u32) -> f32 {
        let line = if is_dynamic { self.line_of[row as usize] as usize } else { 0 };
        self.aux.get(line).map_or(0.0, Aux::parting)
    }
}
