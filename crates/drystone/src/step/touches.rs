//! Touches that began and ended in a step: records that stages collect for
//! [`report`](super::report).

use crate::state::bodies::Bodies;
use crate::state::contacts::Contact;
use crate::state::def::BodyKind;
use crate::state::events::{ContactEvent, Events, SensorEvent};
use crate::state::shapes::Shapes;

/// Ends of touches, and the begins and ends of overlaps with sensors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Touches {
    pub(crate) ends: Vec<ContactEvent>,
    /// With true for an overlap that began, false for one that ended.
    pub(crate) sensed: Vec<(SensorEvent, bool)>,
}

impl Touches {
    pub(crate) fn clear(&mut self) {
        self.ends.clear();
        self.sensed.clear();
    }

    pub(crate) fn shrink_to(&mut self, enough: usize) {
        self.ends.shrink_to(enough);
        self.sensed.shrink_to(enough);
    }

    /// Appends the events.
    pub(crate) fn report(&self, events: &mut Events) {
        events.contact_end.extend_from_slice(&self.ends);
        for (event, enters) in &self.sensed {
            let list = if *enters { &mut events.sensor_enter } else { &mut events.sensor_exit };
            list.push(*event);
        }
    }
}

/// True if the begin and the end of a touch are reported.
pub(crate) fn reports_touch(c: &Contact, shapes: &Shapes) -> bool {
    shapes.at(c.shape_a).reports.touch(shapes.at(c.shape_b).reports)
}

/// The event of a touch that begins or ends.
pub(crate) fn contact_event(c: &Contact, shapes: &Shapes, bodies: &Bodies) -> ContactEvent {
    ContactEvent {
        shape_a: shapes.id(c.shape_a),
        shape_b: shapes.id(c.shape_b),
        body_a: bodies.id(c.body_a),
        body_b: bodies.id(c.body_b),
    }
}

/// Sensor events of two shapes whose overlap begins or ends: one for each sensor of them that sees
/// the other.
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
