//! The state of a world after a step, for the oracles, which also need the previous state.

use std::collections::BTreeMap;

use drystone::{BodyId, BodyKind, Pose, Quat, ShapeId, Vec3, World};

use super::facts::Facts;
use crate::apply::Ids;
use crate::op::Label;

/// State of a body after a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    /// Its label in the program.
    pub(super) label: Label,
    pub(super) kind: BodyKind,
    pub(super) pose: Pose,
    pub(super) center: Vec3,
    pub(super) v: Vec3,
    pub(super) w: Vec3,
    pub(super) mass: f32,
    pub(super) is_asleep: bool,
    /// Half its minimum thickness and half its maximum length [m]; infinite for an infinite floor.
    pub(super) thin: f32,
    pub(super) large: f32,
}

impl Body {
    pub(super) fn velocity_at(&self, point: Vec3) -> Vec3 {
        self.v + self.w.cross(point - self.center)
    }

    /// Approximate speed of its fastest point [m/s].
    pub(super) fn speed(&self) -> f32 {
        self.v.length() + self.w.length() * self.large
    }

    pub(super) fn is_dynamic(&self) -> bool {
        self.kind == BodyKind::Dynamic
    }
}

/// A point of a contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) at: Vec3,
    pub(super) separation: f32,
    pub(super) impulse: f32,
}

/// A contact of two shapes.
#[derive(Clone, Debug)]
pub(super) struct Touch {
    pub(super) bodies: [BodyId; 2],
    pub(super) shapes: [ShapeId; 2],
    /// Direction from the first to the second body.
    pub(super) normal: Vec3,
    pub(super) points: Vec<Point>,
}

impl Touch {
    /// The other body, and the normal toward `body`; `None` if it is not part of this contact.
    pub(super) fn toward(&self, body: BodyId) -> Option<(BodyId, Vec3)> {
        match self.bodies {
            [a, b] if a == body => Some((b, -self.normal)),
            [a, b] if b == body => Some((a, self.normal)),
            _ => None,
        }
    }

    /// Its maximum overlap [m].
    pub(super) fn depth(&self) -> f32 {
        self.points.iter().map(|p| -p.separation).fold(0.0, f32::max)
    }

    /// Whether it carries a load.
    pub(super) fn is_pressed(&self) -> bool {
        self.points.iter().any(|p| p.impulse > 0.0)
    }
}

/// State of a world after a step.
#[derive(Clone, Debug, Default)]
pub(super) struct Moment {
    pub(super) bodies: BTreeMap<BodyId, Body>,
    pub(super) touches: Vec<Touch>,
}

impl Moment {
    pub(super) fn of(world: &World, ids: &Ids, facts: &Facts) -> Self {
        let labels: BTreeMap<BodyId, Label> =
            ids.bodies.iter().map(|(label, id)| (*id, *label)).collect();
        let mut bodies = BTreeMap::new();
        for body in world.bodies() {
            let label = labels.get(&body.id()).copied().unwrap_or(0);
            let made = facts.bodies.get(&label);
            let one = Body {
                label,
                kind: body.kind(),
                pose: body.pose(),
                center: body.center_of_mass(),
                v: body.linear_velocity(),
                w: body.angular_velocity(),
                mass: body.mass(),
                is_asleep: body.is_asleep(),
                thin: made.map_or(f32::INFINITY, |m| m.thin),
                large: made.map_or(0.0, |m| m.large),
            };
            bodies.insert(body.id(), one);
        }
        let touches = world.contacts().map(|contact| Touch {
            bodies: [contact.body_a(), contact.body_b()],
            shapes: [contact.shape_a(), contact.shape_b()],
            normal: contact.normal(),
            points: contact
                .points()
                .map(|p| Point { at: p.position, separation: p.separation, impulse: p.impulse })
                .collect(),
        });
        Self { touches: touches.collect(), bodies }
    }

    pub(super) fn dynamic(&self) -> impl Iterator<Item = (BodyId, &Body)> {
        self.bodies.iter().filter(|(_, b)| b.is_dynamic()).map(|(id, b)| (*id, b))
    }

    /// The body of a label.
    pub(super) fn named(&self, label: Label) -> Option<(BodyId, &Body)> {
        self.bodies.iter().find(|(_, b)| b.label == label).map(|(id, b)| (*id, b))
    }
}

/// Input of the oracles after a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look<'a> {
    pub(super) world: &'a World,
    pub(super) facts: &'a Facts,
    pub(super) before: &'a Moment,
    pub(super) now: &'a Moment,
    /// Length of the step [s].
    pub(super) dt: f32,
    /// Time since the start, and since the last call between steps [s].
    pub(super) time: f32,
    pub(super) quiet: f32,
    /// The number of the step.
    pub(super) step: u32,
}

impl Look<'_> {
    /// Approximate speed of a body after a fall by its own length; 0 without gravity [m/s].
    pub(super) fn fall_speed(&self, body: &Body) -> f32 {
        (2.0 * self.facts.gravity * body.large).max(0.0).sqrt()
    }
}

/// The angle between two rotations [rad].
pub(super) fn turn_between(a: Quat, b: Quat) -> f32 {
    (a * b.conjugate()).angle().abs()
}
