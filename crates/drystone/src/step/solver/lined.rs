//! The bodies that have lines.

use crate::base::jobs::{Executor, collect_ranges, grain};
use crate::state::bodies::{Bodies, Body, NONE};

/// What of a body with a line tells its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lined {
    pub(super) row: u32,
    pub(super) island: u32,
    /// Ends of constraints, at least 1.
    pub(super) ends: u32,
}

/// Lists them in the order of the awake bodies, one list after the other.
pub(super) fn find(bodies: &Bodies, lined: &mut Vec<Vec<Lined>>, jobs: &dyn Executor) {
    let awake = &bodies.awake;
    collect_ranges(jobs, awake.len(), grain(jobs, awake.len(), 256), lined, |range, lined| {
        for row in &awake[range] {
            let body = bodies.at(*row);
            if has_line(body) {
                debug_assert!(body.island != NONE, "every dynamic body is in an island");
                // What only particles act on takes a place too.
                let ends = body.constraints.max(1);
                lined.push(Lined { row: *row, island: body.island, ends });
            }
        }
    });
}

/// Dynamic bodies that some constraint acts on, or a particle, have a line; the others fly (finalize).
pub(super) fn has_line(body: &Body) -> bool {
    body.is_dynamic() && (body.constraints > 0 || body.dragged)
}
