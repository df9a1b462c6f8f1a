//! The stage `sensor`: what the step found out becomes events, in order. Sensor overlaps are found by narrowphase
//! like contacts, without margin and without a place in the solver, and entered by partition; contacts
//! that the solver found pressed together for the first time are entered here.
//!
//! Reads: contacts, shapes. Writes: contacts (touching), events. Runs: serially over changes and events.

use super::partition;
use crate::state::bodies::Bodies;
use crate::state::def::BodyKind;
use crate::state::events::SensorEvent;
use crate::state::sets::Sets;
use crate::state::shapes::Shapes;

/// Reports new touches and what went through sensors within the step, and sorts every list of events by the ids in it, so
/// that its order is the same whatever the order of discovery.
pub(crate) fn report_touches(
    (begun, crossed): (impl Iterator<Item = u32> + Clone, &[SensorEvent]),
    shapes: &Shapes,
    sets: &mut Sets<'_>,
) {
    partition::report_begun(begun, shapes, sets);
    let events = &mut *sets.events;
    events.sensor_enter.extend_from_slice(crossed);
    events.sensor_exit.extend_from_slice(crossed);
    events.contact_begin.sort_unstable_by_key(|e| (e.shape_a, e.shape_b));
    events.contact_end.sort_unstable_by_key(|e| (e.shape_a, e.shape_b));
    events.sensor_enter.sort_unstable_by_key(|e| (e.sensor, e.visitor));
    events.sensor_exit.sort_unstable_by_key(|e| (e.sensor, e.visitor));
    events.wake.sort_unstable();
    events.wake.dedup();
}

/// What enters or leaves a sensor where two shapes begin or cease to overlap: one event for each of them that sees the other.
pub(crate) fn events_between(
    [a, b]: [u32; 2],
    shapes: &Shapes,
    bodies: &Bodies,
) -> impl Iterator<Item = SensorEvent> + use<> {
    let is_static = |shape: u32| bodies.at(shapes.at(shape).body).kind == BodyKind::Static;
    let fixed = is_static(a) && is_static(b);
    let event = |sensor: u32, visitor: u32| {
        let [seer, seen] = [sensor, visitor].map(|shape| shapes.at(shape));
        seer.sees(seen, fixed).then(|| SensorEvent {
            sensor: shapes.id(sensor),
            visitor: shapes.id(visitor),
            sensor_body: bodies.id(seer.body),
            visitor_body: bodies.id(seen.body),
        })
    };
    [event(a, b), event(b, a)].into_iter().flatten()
}
