//! Stage 7: the step's events are put in order. Sensor overlaps are found by narrowphase like
//! contacts, without margin and without a place in the solver, and entered by partition.
//!
//! Reads: nothing else. Writes: events (order). Runs: serially over events.

use crate::state::events::Events;

/// Sorts every list by the ids in it, so that its order is the same whatever the order of discovery.
pub(crate) fn order_events(events: &mut Events) {
    events.contact_begin.sort_unstable_by_key(|e| (e.shape_a, e.shape_b));
    events.contact_end.sort_unstable_by_key(|e| (e.shape_a, e.shape_b));
    events.hits.sort_unstable_by_key(|e| (e.shape_a, e.shape_b));
    events.sensor_enter.sort_unstable_by_key(|e| (e.sensor, e.visitor));
    events.sensor_exit.sort_unstable_by_key(|e| (e.sensor, e.visitor));
    events.wake.sort_unstable();
}
