//! Begin and end events of active contacts of shapes whose reports change. Each reported begin gets
//! an end, and no end is reported without its begin.

use super::World;
use crate::state::events::{ContactEvent, Events};
use crate::step::touches::contact_event;

fn is_pair(a: &ContactEvent, b: &ContactEvent) -> bool {
    (a.shape_a, a.shape_b) == (b.shape_a, b.shape_b)
}

/// Removes an event of the same pair from a list; false if there is none.
fn take_out(events: &mut Vec<ContactEvent>, event: &ContactEvent) -> bool {
    let found = events.iter().position(|other| is_pair(other, event));
    if let Some(at) = found {
        events.remove(at);
    }
    found.is_some()
}

impl World {
    /// Starts or stops reports of a shape's contacts, as its new `reports` say. Active contacts
    /// report their begin or end with the next step. A change that is undone before it cancels out.
    pub(super) fn turn_touches(&mut self, shape: u32) {
        let tables = &self.tables;
        let is_reported = tables.shapes.at(shape).reports.touches;
        let body = tables.bodies.at(tables.shapes.at(shape).body);
        for (row, _) in tables.contacts.of_body(body) {
            let c = tables.contacts.at(row);
            let other = if c.shape_a == shape { c.shape_b } else { c.shape_a };
            let is_of = c.shape_a == shape || c.shape_b == shape;
            let is_touch = c.touching && !c.sensor && !c.is_part;
            if !is_of || !is_touch || !tables.shapes.at(other).reports.touches {
                continue;
            }
            let event = contact_event(c, &tables.shapes, &tables.bodies);
            let Events { contact_begin, contact_end, .. } = &mut self.pending;
            let (events, back) = if is_reported {
                (contact_begin, contact_end)
            } else {
                (contact_end, contact_begin)
            };
            if !take_out(back, &event) {
                events.push(event);
            }
        }
    }

    /// Removes the last pending end and the pending begin of the same contact, if there is one.
    /// Neither is reported.
    pub(super) fn cancel_last_end(&mut self) {
        let Events { contact_begin, contact_end, .. } = &mut self.pending;
        if let Some(end) = contact_end.last().copied()
            && take_out(contact_begin, &end)
        {
            contact_end.pop();
        }
    }

    /// Adds begin events that were pending for the step, after the step. A contact that ended in it
    /// is not reported.
    pub(super) fn tell_begun(&mut self, begun: Vec<ContactEvent>) {
        if begun.is_empty() {
            return;
        }
        let Events { contact_begin, contact_end, .. } = &mut self.tables.events;
        for event in begun {
            if !take_out(contact_end, &event) {
                contact_begin.push(event);
            }
        }
        contact_begin.sort_unstable_by_key(|e| (e.shape_a, e.shape_b));
    }
}
