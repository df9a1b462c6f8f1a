//! Collects the data that the plan of a step needs from the awake bodies. Each body is another
//! cache line, so it is read at most once.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use core::ops::Range;

use super::refine::was_struck;
use crate::base::grow;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, collect_ranges, grain};
use crate::state::bodies::body::Body;
use crate::state::bodies::{Bodies, NONE};

#[derive(Clone, Debug, Default)]
pub(crate) struct Survey {
    is_made: bool,
    /// Island of each awake body, or [`NONE`] if it has no solver body.
    pub(crate) islands: Vec<u32>,
    /// Number of constraints of each awake body.
    pub(crate) ends: Vec<u32>,
    /// Bodies that affect the refinement of their island, one list for each range of bodies.
    marked: Vec<Vec<u32>>,
}

impl Survey {
    /// Discards the data of the last step.
    pub(crate) const fn begin(&mut self) {
        self.is_made = false;
    }

    /// Reads the bodies once per step. It marks links, those that particles act on, that were hit,
    /// or that `wants` selects.
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
        // SAFETY: each index belongs to one range.
        let apart = unsafe { Apart::promise() };
        let islands = Rows::new(&mut self.islands, apart);
        let ends = Rows::new(&mut self.ends, apart);
        let read = |range: Range<usize>, marked: &mut Vec<u32>| {
            for i in range {
                let body = bodies.at(bodies.awake[i]);
                debug_assert!(!has_line(body) || body.sleep.island != NONE, "it is in an island");
                *islands.row(i) = if has_line(body) { body.sleep.island } else { NONE };
                *ends.row(i) = body.ties.constraints;
                let stays_whole = body.record.dragged || body.record.is_link;
                if has_line(body) && (stays_whole || was_struck(body) || wants(body)) {
                    marked.push(bodies.awake[i]);
                }
            }
        };
        collect_ranges(jobs, n, grain(jobs, n, 256), &mut self.marked, read);
    }

    /// The marked bodies; each has a solver body.
    pub(crate) fn marked<'b>(&self, bodies: &'b Bodies) -> impl Iterator<Item = &'b Body> {
        self.marked.iter().flatten().map(|row| bodies.at(*row))
    }
}

/// Dynamic bodies under a constraint or a particle have a solver body, and so have links; the
/// others fly (`finalize`).
fn has_line(body: &Body) -> bool {
    body.is_dynamic() && (body.ties.constraints > 0 || body.record.dragged || body.record.is_link)
}
