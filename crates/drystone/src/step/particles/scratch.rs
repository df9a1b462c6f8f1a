//! Memory of the stage `particles`.

use super::meet::Meeting;
use super::pace::Pace;
use super::tied::Tied;
use super::{settle, tied};
use crate::state::bodies::Bodies;
use crate::state::events::LinkTear;
use crate::state::particles::Particles;

/// What a chunk of particles found, in the order of their lines.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Found {
    /// This line is solved with substeps.
    Tied(u32),
    /// It meets this: follows its `Tied`.
    Meets(Meeting),
    /// A body to wake.
    Wakes(u32),
    /// A frozen particle whose strand is to wake.
    Thaws(u32),
    /// Its state became non-finite.
    Fault(u32),
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub(crate) found: Vec<Vec<Found>>,
    /// Lines that are solved with substeps, ascending.
    pub(crate) tied: Vec<u32>,
    /// What they meet, in the order of lines, then of shapes.
    pub(crate) meetings: Vec<Meeting>,
    /// Lines that were put aside in this step.
    pub(crate) faults: Vec<u32>,
    pub(crate) thawed: Vec<u32>,
    pub(crate) pace: tied::Scratch,
    pub(crate) settle: settle::Scratch,
}

impl Scratch {
    /// See [`crate::step::Scratch::start_from`]. In the copy no body is marked as dragged, as in a world that was restored.
    pub(crate) fn start_from(&mut self, from: &Self, bodies: &mut Bodies) {
        self.pace.dragged.clear();
        for row in &from.pace.dragged {
            if let Some(body) = bodies.rows.at_mut(*row) {
                body.dragged = false;
            }
        }
    }

    /// Links that tore in the last step.
    pub(crate) fn torn(&self) -> &[LinkTear] {
        &self.settle.torn
    }

    /// Lines of particles that were put aside in the last step, ascending.
    pub(crate) fn faults(&self) -> &[u32] {
        &self.faults
    }

    /// The tied particles, for the solver.
    pub(crate) fn tied<'a>(&'a mut self, pace: Pace, particles: &'a mut Particles) -> Tied<'a> {
        let Self { tied, meetings, pace: scratch, .. } = self;
        Tied { pace, particles, tied, meetings, scratch }
    }
}
