//! Rows of solver bodies, as they are lent to the workers of a phase.

use super::island_motion::Frames;
use super::row::Aux;
use super::squeeze::Squeeze;
use super::state::BodyState;
use crate::base::math::Vec3;
use crate::base::threads::disjoint::Rows;
use crate::step::solver_body::{SolverBody, Whitening};

/// One row for each solver body, if nothing else is said.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyRows<'a> {
    /// Solver body of each row of the table of bodies; 0: none.
    pub(crate) solver_row_of: &'a [u32],
    pub(crate) solver_bodies: Rows<'a, SolverBody>,
    pub(crate) whitening: Rows<'a, Whitening>,
    pub(crate) aux: Rows<'a, Aux>,
    /// Acceleration by forces [m/s²].
    pub(crate) acceleration: Rows<'a, Vec3>,
    pub(crate) squeezes: Rows<'a, Squeeze>,
    /// States at the start of a round, and at the step's end of bodies that have [`Aux::ended`];
    /// empty unless some body may need one.
    pub(crate) states: Rows<'a, BodyState>,
    /// Whether it flew freely, where known; or empty.
    pub(crate) free: Rows<'a, Option<bool>>,
    /// One for each group.
    pub(crate) frames: Rows<'a, Frames>,
}
