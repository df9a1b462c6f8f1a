//! Memory of the stage `particles`, kept from step to step.

use super::meet::Meeting;
use super::pace::Pace;
use super::tied::Tied;
use super::{settle, tied};
use crate::state::bodies::Bodies;
use crate::state::events::LinkTear;
use crate::state::particles::Particles;

/// A finding of a chunk of particles, in the order of their rows.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Found {
    /// This line is solved with substeps.
    Tied(u32),
    /// A contact of the particle in the preceding `Tied`.
    Meets(Meeting),
    /// A body to wake.
    Wakes(u32),
    /// A frozen particle whose strand must wake.
    Thaws(u32),
    /// A particle whose state became non-finite.
    Fault(u32),
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub(crate) found: Vec<Vec<Found>>,
    /// Lines that are solved with substeps, ascending.
    pub(crate) tied: Vec<u32>,
    /// Contacts of tied particles, in the order of rows, then of shapes.
    pub(crate) meetings: Vec<Meeting>,
    /// Lines that were set aside in this step.
    pub(crate) faults: Vec<u32>,
    pub(crate) thawed: Vec<u32>,
    pub(crate) pace: tied::Scratch,
    pub(crate) settle: settle::Scratch,
}

impl Scratch {
    /// See [`crate::step::Scratch::start_from`]. In the copy no body is marked as dragged, as in a
    /// restored world.
    pub(crate) fn start_from(&mut self, from: &Self, bodies: &mut Bodies) {
        self.pace.dragged.clear();
        for row in &from.pace.dragged {
            if let Some(body) = bodies.rows.at_mut(*row) {
                body.record.dragged = false;
            }
        }
    }

    /// Links that tore in the last step.
    pub(crate) fn torn(&self) -> &[LinkTear] {
        &self.settle.torn
    }

    /// Lines of particles that were set aside in the last step, ascending.
    pub(crate) fn faults(&self) -> &[u32] {
        &self.faults
    }

    /// The tied particles, for the solver.
    pub(crate) fn tied<'a>(&'a mut self, pace: Pace, particles: &'a mut Particles) -> Tied<'a> {
        let Self { tied, meetings, pace: scratch, .. } = self;
        Tied { pace, particles, tied, meetings, scratch }
    }
}
