//! Tables that the workers of the narrowphase share.

use crate::base::threads::disjoint::Rows;
use crate::state::bodies::Bodies;
use crate::state::contacts::{Probe, Slots, Softened, Watch};
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;
use crate::step::hooks::Hooks;

/// All pairs that are awake, lent to the workers, and what they are read by.
pub(crate) struct Pairs<'a> {
    pub(crate) ctx: &'a StepContext,
    pub(crate) bodies: &'a Bodies,
    pub(crate) shapes: &'a Shapes,
    pub(crate) slots: Slots<'a>,
    pub(crate) watches: Rows<'a, Watch>,
    pub(crate) probes: Rows<'a, Probe>,
    pub(crate) asked: Asked<'a>,
    /// So far two bodies come in a step together whose points land, at least: see [`Track::ahead`].
    pub(crate) landing: u32,
}

/// The hooks of the step, and what they say of softness by contacts' rows; empty without hooks.
#[derive(Clone, Copy)]
pub(crate) struct Asked<'a> {
    pub(crate) hooks: Option<&'a Hooks<'a>>,
    pub(crate) softened: Rows<'a, Softened>,
}
