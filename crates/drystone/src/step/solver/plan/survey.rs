//! What the awake bodies say for the plan of a step, read at most once: each is a cache line elsewhere.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use core::ops::Range;

use super::refine::was_struck;
use crate::base::grow;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, collect_ranges, grain};
use crate::state::bodies::{Bodies, Body, NONE};

#[derive(Clone, Debug, Default)]
pub(crate) struct Survey {
    is_made: bool,
    /// Of each awake body its island, or [`NONE`] if it has no line.
    pub(crate) islands: Vec<u32>,
    /// Of each awake body its constraints.
    pub(crate) ends: Vec<u32>,
    /// Bodies on which it depends how an island takes its substeps, a list for each range of bodies.
    marked: Vec<Vec<u32>>,
}

impl Survey {
    /// Forgets what was read in the last step.
    pub(crate) const fn begin(&mut self) {
        self.is_made = false;
    }

    /// Reads the bodies unless that was done in this step, and marks those that particles act on, that were hit, or that `wants`
    /// wants.
    pub(crate) fn make(
        &mut self,
        bodies: &Bodies,
        wants: impl Fn(&Body) -> bool + Sync,
        jobs: &Jobs<'_>,
    ) {
        if core::mem::replace(&mut self.is_made, true) {
            return;
        }
        let n = bodies.awake.len();
        grow::resize(&mut self.islands, n, NONE);
        grow::resize(&mut self.ends, n, 0);
        // SAFETY: each place is of one range.
        let apart = unsafe { Apart::promise() };
        let islands = Rows::new(&mut self.islands, apart);
        let ends = Rows::new(&mut self.ends, apart);
        let read = |range: Range<usize>, marked: &mut Vec<u32>| {
            for i in range {
                let body = bodies.at(bodies.awake[i]);
                debug_assert!(!has_line(body) || body.island != NONE, "it is in an island");
                *islands.row(i) = if has_line(body) { body.island } else { NONE };
                *ends.row(i) = body.constraints;
                if has_line(body) && (body.dragged || was_struck(body) || wants(body)) {
                    marked.push(bodies.awake[i]);
                }
            }
        };
        collect_ranges(jobs, n, grain(jobs, n, 256), &mut self.marked, read);
    }

    /// Those that were marked; each has a line.
    pub(crate) fn marked<'b>(&self, bodies: &'b Bodies) -> impl Iterator<Item = &'b Body> {
        self.marked.iter().flatten().map(|row| bodies.at(*row))
    }
}

/// Dynamic bodies that some constraint acts on, or a particle, have a line; the others fly (finalize).
fn has_line(body: &Body) -> bool {
    body.is_dynamic() && (body.constraints > 0 || body.dragged)
}
