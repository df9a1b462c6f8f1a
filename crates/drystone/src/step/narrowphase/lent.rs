//! Tables that the workers of the narrowphase share.

use crate::base::threads::disjoint::Rows;
use crate::state::bodies::Bodies;
use crate::state::contacts::{Probe, Slots, Softened, Watch};
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;
use crate::step::hooks::Hooks;

/// Tables for the narrowphase's workers: awake pairs to write, and the data needed to update them.
pub(crate) struct Pairs<'a> {
    pub(crate) ctx: &'a StepContext,
    pub(crate) bodies: &'a Bodies,
    pub(crate) shapes: &'a Shapes,
    pub(crate) slots: Slots<'a>,
    pub(crate) watches: Rows<'a, Watch>,
    pub(crate) probes: Rows<'a, Probe>,
    pub(crate) asked: Asked<'a>,
    /// Minimum approach of two bodies in a step for a point to land: see [`Track::ahead`].
    pub(crate) landing: u32,
}

/// Hooks of the step, and the softness that they set, by contact row; empty without hooks.
#[derive(Clone, Copy)]
pub(crate) struct Asked<'a> {
    pub(crate) hooks: Option<&'a Hooks<'a>>,
    pub(crate) softened: Rows<'a, Softened>,
}
