//! Progress of a group through the passes of a step.

use crate::state::def::method::Pass;

/// How far a group is in its step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Progress {
    /// Substeps that positions have advanced.
    pub(crate) done: u16,
    /// Velocities have the forces of the next one.
    pub(crate) kicked: bool,
    /// A translation of one of its bodies is locked.
    pub(crate) locked: bool,
}

/// A pass in a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassStep {
    pub(crate) substep: u32,
    pub(crate) pass: Pass,
    /// The velocities of the next substep follow at once.
    pub(crate) kicks: bool,
}
