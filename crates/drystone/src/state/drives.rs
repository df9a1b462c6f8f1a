//! What drives a body that is slow: it must not sleep, however slow that is.

use super::bodies::{Bodies, Body};
use super::contacts::{Contact, Contacts};
use super::coupling::coordinate;
use super::def::BodyKind;
use super::joints::{Joint, Joints, Link};
use super::rest::size;
use super::shapes::{ShapeRow, Shapes};
use super::six::Six;
use super::sixdof::{JointAxis, JointDrive, JointMotion};
use crate::base::math::Vec3;

/// Part of its size by which what a spring or a drive acts on may move between two marks and rest.
const HELD: f32 = 1.0e-4;

/// Part of what a drive asks for below which it is stalled: what it acts on has come to a stop against something.
const STALLED: f32 = 1.0e-3;

/// What drives a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Driver {
    /// A kinematic body that moves.
    Body(u32),
    /// A body whose surface moves.
    Belt(u32),
    /// A joint whose drive or spring still moves it.
    Joint(u32),
}

/// The tables that are read.
#[derive(Clone, Copy)]
pub(crate) struct Drives<'a> {
    pub(crate) bodies: &'a Bodies,
    pub(crate) shapes: &'a Shapes,
    pub(crate) joints: &'a Joints,
    pub(crate) contacts: &'a Contacts,
    /// Time between two marks [s].
    pub(crate) spacing: f32,
}

/// True of a kinematic body that moves.
fn moves(body: &Body) -> bool {
    body.kind == BodyKind::Kinematic && (body.v != Vec3::ZERO || body.w != Vec3::ZERO)
}

impl Drives<'_> {
    /// The first thing that drives a dynamic body: what it touches, then its joints, in the order of its lists.
    pub(crate) fn driver(&self, row: u32) -> Option<Driver> {
        let body = self.bodies.at(row);
        for (contact, side) in self.contacts.of_body(body) {
            let c = self.contacts.at(contact);
            if c.count == 0 || c.sensor {
                continue;
            }
            let other = if side == 0 { c.body_b } else { c.body_a };
            if moves(self.bodies.at(other)) {
                return Some(Driver::Body(other));
            }
            if c.belt && c.friction > 0.0 && !self.is_held(row, self.belt_speed(c)) {
                return Some(Driver::Belt(other));
            }
        }
        for &joint_row in &body.joints {
            let joint = self.joints.at(joint_row);
            let other = if joint.body_a == row { joint.body_b } else { joint.body_a };
            if moves(self.bodies.at(other)) {
                return Some(Driver::Body(other));
            }
            if self.acts(joint, row) {
                return Some(Driver::Joint(joint_row));
            }
        }
        None
    }

    /// True if a body has come to a stop though something would move it at this speed [m/s].
    fn is_held(&self, row: u32, speed: f32) -> bool {
        let most = (HELD * size(self.bodies.at(row))).min(STALLED * speed * self.spacing);
        self.bodies.has_stopped(row, most)
    }

    /// How fast the surfaces of a contact move over their shapes, together [m/s].
    fn belt_speed(&self, c: &Contact) -> f32 {
        let point = self.bodies.at(c.body_a).center + c.points[0].r_a;
        let of = |shape: &ShapeRow| {
            let arm = point - shape.placed(self.bodies.at(shape.body)).position;
            shape.surface_velocity.length() + shape.surface_spin.length() * arm.length()
        };
        of(self.shapes.at(c.shape_a)) + of(self.shapes.at(c.shape_b))
    }

    /// True if a drive or spring of a joint still moves this body of it.
    fn acts(&self, joint: &Joint, row: u32) -> bool {
        match &joint.link {
            Link::Distance { spring: Some(_), .. } => !self.is_held(row, f32::INFINITY),
            Link::Six(six) if six.laws.flags.drives | six.laws.flags.yields != 0 => {
                let axes = six.def.axes();
                let speed = (0..6).map(|i| self.speed_of(joint, six, i, &axes[i], row));
                let speeds = speed.flatten().reduce(f32::min);
                speeds.is_some_and(|speed| !self.is_held(row, speed))
            }
            _ => false,
        }
    }

    /// How fast the drive or spring of an axis would move a body if nothing held it [m/s]; `None` if it moves nothing.
    fn speed_of(
        &self,
        joint: &Joint,
        six: &Six,
        i: usize,
        axis: &JointAxis,
        row: u32,
    ) -> Option<f32> {
        if axis.held().is_some() {
            return None;
        }
        let springs = matches!(axis.motion, JointMotion::Limited { spring: Some(_), .. });
        let reach = if i < 3 { 1.0 } else { size(self.bodies.at(row)) };
        let driven = axis.drive.and_then(|drive| {
            let error = || drive.position - coordinate_of(joint, six, self.bodies, i);
            drive_speed(&drive, HELD * size(self.bodies.at(row)) / reach, error)
        });
        match driven {
            Some(speed) => Some(speed * reach),
            None if springs => Some(f32::INFINITY),
            None => None,
        }
    }
}

/// How fast a drive would go if nothing held it [m/s; rad/s]; infinite for one that has only to be still; `None` if it moves nothing.
/// `near`: it has reached its place when it is this near [m; rad].
fn drive_speed(drive: &JointDrive, near: f32, error: impl Fn() -> f32) -> Option<f32> {
    let JointDrive { velocity, spring, max_force, .. } = *drive;
    if max_force <= 0.0 {
        return None;
    }
    let asked = if spring.damping > 0.0 { velocity.abs() } else { 0.0 };
    if spring.stiffness <= 0.0 {
        return (asked > 0.0).then_some(asked);
    }
    let error = error().abs();
    if asked <= 0.0 && error <= near {
        return Some(f32::INFINITY);
    }
    // An overdamped one closes in at this rate [1/s]; others are faster.
    let rate = if spring.damping > 0.0 { spring.stiffness / spring.damping } else { f32::INFINITY };
    Some(asked.max(rate * error))
}

/// A coordinate of a joint of six axes [m; rad]; of the swings behind a cone their parts about y and z.
fn coordinate_of(joint: &Joint, six: &Six, bodies: &Bodies, axis: usize) -> f32 {
    if axis > 3 && six.def.cone.is_some() {
        let (a, b) = (bodies.at(joint.body_a), bodies.at(joint.body_b));
        let turns = six.turns(a.rotation, b.rotation);
        return turns.swing[axis - 4] * turns.angles[1];
    }
    #[expect(clippy::cast_possible_truncation, reason = "an angle or a length")]
    let x = coordinate(joint, six, bodies, axis) as f32;
    x
}
