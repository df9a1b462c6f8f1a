//! `Solver`: borrowed views of the tables and of the solver's rows, through which groups are solved
//! in parallel.

use super::articulation::lent::ArticulationRows;
use super::body::lent::BodyRows;
use super::contact::lent::ContactRows;
use super::impact::Impacts;
use super::joint::lent::JointRows;
use super::pass::Progress;
use super::plan::Plan;
use super::totals_rows::SumRequests;
use super::tree::lent::TreeRows;
use crate::base::threads::disjoint::Rows;
use crate::state::bodies::Bodies;
use crate::state::contacts::{Slots, Softened};
use crate::state::def::method::Method;
use crate::state::joints::Joint;
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;

/// Shared access to the solver's rows; each group touches only its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solver<'a> {
    pub(super) ctx: &'a StepContext,
    pub(super) method: &'a Method,
    pub(super) plan: &'a Plan,
    /// See `rounds.rs`; 0 outside of rounds.
    pub(super) round: u32,
    pub(super) sum_requests: SumRequests<'a>,

    // Tables of the world.
    pub(super) bodies: &'a Bodies,
    pub(super) shapes: &'a Shapes,
    pub(super) contacts: Slots<'a>,
    pub(super) softened: &'a [Softened],
    pub(super) joint_slots: Rows<'a, Option<Joint>>,

    // Rows of this step.
    pub(super) body: BodyRows<'a>,
    pub(super) contact: ContactRows<'a>,
    pub(super) joint: JointRows<'a>,
    pub(super) tree: TreeRows<'a>,
    pub(super) articulation: ArticulationRows<'a>,
    /// One for each group; empty unless the step has impacts.
    pub(super) impacts: Rows<'a, Impacts>,
    /// One for each group that runs in step with particles.
    pub(super) progress: Rows<'a, Progress>,
}
