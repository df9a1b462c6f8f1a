//! Progress of a group through the passes of a step.

use crate::state::def::method::Pass;

/// Passes that a group has completed in this step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Progress {
    /// Substeps by which positions have advanced.
    pub(crate) done: u16,
    /// Velocities already contain the forces of the next substep.
    pub(crate) kicked: bool,
    /// A translation of some body in the group is locked.
    pub(crate) locked: bool,
}

/// One pass of one substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassStep {
    pub(crate) substep: u32,
    pub(crate) pass: Pass,
    /// The same walk over the bodies also adds the forces of the next substep.
    pub(crate) kicks: bool,
}
