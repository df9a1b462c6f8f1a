//! Drives of slow bodies: a driven body must not sleep, however slow it is.

use super::BodyKind;
use super::six_dof::{JointDrive, JointMotion};
use crate::base::math::Vec3;
use crate::state::bodies::Bodies;
use crate::state::bodies::body::Body;
use crate::state::bodies::stillness::{rounding, size};
use crate::state::contacts::{Contact, Contacts, Point, Traits};
use crate::state::coupling::coordinate;
use crate::state::joints::{Joint, JointModel, Joints};
use crate::state::shapes::{ShapeRow, Shapes};
use crate::state::six_dof::SixDofJoint;

/// Displacement between two marks below which a sprung body counts as at rest, as a fraction of its
/// size. It may be this far from its target.
const SPRUNG: f32 = 1.0e-3;

/// The same for a body driven at a speed. It is smaller because a weak motor starts slowly.
const HELD: f32 = 1.0e-5;

/// Fraction of a drive's target speed below which it is stalled: the driven body has stopped
/// against an obstacle.
const STALLED: f32 = 1.0e-3;

/// The cause that drives a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Driver {
    /// A moving kinematic body.
    Body(u32),
    /// A body with a moving surface.
    Belt(u32),
    /// A body that is pressed against it and moves relative to it.
    Load(u32),
    /// A joint whose drive or spring still moves the body.
    Joint(u32),
}

/// The tables that are read.
#[derive(Clone, Copy)]
pub(crate) struct Drives<'a> {
    pub(crate) bodies: &'a Bodies,
    pub(crate) shapes: &'a Shapes,
    pub(crate) joints: &'a Joints,
    pub(crate) contacts: &'a Contacts,
    /// Length of a typical body [m].
    pub(crate) length: f32,
    /// Time between two marks [s].
    pub(crate) spacing: f32,
}

/// True for a moving kinematic body.
fn moves(body: &Body) -> bool {
    body.kind == BodyKind::Kinematic && (body.v != Vec3::ZERO || body.w != Vec3::ZERO)
}

impl Drives<'_> {
    /// The first cause that drives a dynamic body: its contacts, then its joints, in the order of
    /// its lists.
    pub(crate) fn driver(&self, row: u32) -> Option<Driver> {
        let body = self.bodies.at(row);
        for (contact, side) in self.contacts.of_body(body) {
            let c = self.contacts.at(contact);
            // A contact without load or overlap does not drive.
            let presses = |p: &Point| p.impulse > 0.0 || p.separation <= 0.0;
            if c.sensor || !c.points().iter().any(presses) {
                continue;
            }
            let other = if side == 0 { c.body_b } else { c.body_a };
            if moves(self.bodies.at(other)) {
                return Some(Driver::Body(other));
            }
            if c.traits.any(Traits::SETTLES) {
                return Some(Driver::Load(other));
            }
            if c.traits.any(Traits::BELT)
                && c.friction > 0.0
                && !self.is_held(row, self.belt_speed(c))
            {
                return Some(Driver::Belt(other));
            }
        }
        for &joint_row in &body.ties.joints {
            let joint = self.joints.at(joint_row);
            if !joint.is_on() {
                continue;
            }
            let other = if joint.body_a == row { joint.body_b } else { joint.body_a };
            if moves(self.bodies.at(other)) {
                return Some(Driver::Body(other));
            }
            if self.acts(joint) {
                return Some(Driver::Joint(joint_row));
            }
        }
        None
    }

    /// True if a body has stopped although a surface drives it at this speed [m/s].
    fn is_held(&self, row: u32, speed: f32) -> bool {
        let body = self.bodies.at(row);
        let maximum = (HELD * size(body, self.length)).min(STALLED * speed * self.spacing)
            + rounding(body, self.length);
        let means = self.bodies.stillness[row as usize].means;
        means.iter().all(|mean| mean.length(size(body, self.length)) * self.spacing <= maximum)
    }

    /// Sum of the surface speeds of a contact [m/s].
    fn belt_speed(&self, c: &Contact) -> f32 {
        let point = self.bodies.at(c.body_a).center + c.points[0].r_a;
        let of = |shape: &ShapeRow| {
            let arm = point - shape.placed(self.bodies.at(shape.body)).position;
            shape.surface_velocity.length() + shape.surface_spin.length() * arm.length()
        };
        of(self.shapes.at(c.shape_a)) + of(self.shapes.at(c.shape_b))
    }

    /// True if a drive or spring of a joint still moves its bodies relative to each other.
    fn acts(&self, joint: &Joint) -> bool {
        match &joint.model {
            JointModel::Distance { spring: Some(_), .. } => {
                let speeds = self.meets(joint).map(|meet| meet.apart());
                self.goes(joint, Asked::Place(f32::INFINITY), 1.0, speeds)
            }
            JointModel::SixDof(six_dof)
                if six_dof.laws.flags.drives | six_dof.laws.flags.yields != 0 =>
            {
                (0..6).any(|axis| self.acts_along(joint, six_dof, axis))
            }
            _ => false,
        }
    }

    /// The same for one axis of a joint of six axes.
    fn acts_along(&self, joint: &Joint, six_dof: &SixDofJoint, i: usize) -> bool {
        let axis = six_dof.def.axes()[i];
        if axis.locked_at().is_some() {
            return false;
        }
        let size = self.size_of(joint);
        let reach = if i < 3 { 1.0 } else { size };
        let driven = axis.drive.and_then(|drive| {
            let error = || drive.position - coordinate_of(joint, six_dof, self.bodies, i);
            drive_asks(&drive, SPRUNG * size / reach, error)
        });
        let springs = matches!(axis.motion, JointMotion::Limited { spring: Some(_), .. });
        let Some(asked) = driven.or(springs.then_some(Asked::Place(f32::INFINITY))) else {
            return false;
        };
        let (a, b) = (self.bodies.at(joint.body_a), self.bodies.at(joint.body_b));
        let frame = a.rotation * six_dof.def.frame_a;
        let speeds = self.meets(joint).map(|meet| {
            if i < 3 {
                return frame.rotate([Vec3::X, Vec3::Y, Vec3::Z][i]).dot(meet.moves).abs();
            }
            // With a cone the swings have no rows of their own.
            let swings = i > 3 && six_dof.def.cone.is_some();
            let row = six_dof.joint_angles(a.rotation, b.rotation).rows[i - 3];
            if swings { meet.turns.length() } else { row.dot(meet.turns).abs() }
        });
        self.goes(joint, asked, reach, speeds)
    }

    /// True if a coordinate with these speeds between marks has not stopped [m/s; rad/s]. `reach`:
    /// displacement per unit of the coordinate [m].
    fn goes(&self, joint: &Joint, asked: Asked, reach: f32, speeds: [f32; 2]) -> bool {
        let size = self.size_of(joint);
        let (part, speed) = match asked {
            Asked::Speed(speed) => (HELD, speed),
            Asked::Place(speed) => (SPRUNG, speed),
        };
        let ends = [joint.body_a, joint.body_b].map(|row| self.bodies.at(row));
        let rounding: f32 =
            ends.iter().filter(|b| b.is_dynamic()).map(|b| rounding(b, self.length)).sum();
        let maximum = (part * size / reach).min(STALLED * speed * self.spacing) + rounding / reach;
        speeds.iter().any(|speed| speed * self.spacing > maximum)
    }

    /// Size of the smaller dynamic body of a joint [m].
    fn size_of(&self, joint: &Joint) -> f32 {
        let sizes = [joint.body_a, joint.body_b].map(|row| {
            let body = self.bodies.at(row);
            if body.is_dynamic() { size(body, self.length) } else { f32::INFINITY }
        });
        sizes[0].min(sizes[1])
    }

    /// Average motion of the second anchor of a joint relative to the first, between the last marks
    /// of its bodies.
    fn meets(&self, joint: &Joint) -> [Meeting; 2] {
        let (a, b) = (self.bodies.at(joint.body_a), self.bodies.at(joint.body_b));
        let [r_a, r_b] = [a.rotation.rotate(joint.anchor_a), b.rotation.rotate(joint.anchor_b)];
        let gap = (b.center + r_b) - (a.center + r_a);
        let mean = |row: u32, k: usize| self.bodies.stillness[row as usize].means[k];
        [0, 1].map(|k| {
            let (of_a, of_b) = (mean(joint.body_a, k), mean(joint.body_b, k));
            let at_b = of_b.moved + of_b.turned.cross(r_b);
            // The first frame turns with its body, and the gap is measured in it.
            let at_a = of_a.moved + of_a.turned.cross(r_a + gap);
            Meeting { gap, moves: at_b - at_a, turns: of_b.turned - of_a.turned }
        })
    }
}

/// Relative motion of two anchors.
#[derive(Clone, Copy)]
struct Meeting {
    /// Vector from the first anchor to the second [m, world].
    gap: Vec3,
    /// Rate of change of the gap, measured in the first frame [m/s, world], and the relative
    /// angular velocity [rad/s, world].
    moves: Vec3,
    turns: Vec3,
}

impl Meeting {
    /// Rate of change of the distance [m/s].
    fn apart(&self) -> f32 {
        self.gap.try_normalize().map_or(0.0, |n| n.dot(self.moves).abs())
    }
}

/// The motion that an unobstructed drive or spring would cause.
#[derive(Clone, Copy)]
enum Asked {
    /// Motion at this speed [m/s; rad/s].
    Speed(f32),
    /// Motion to a target, at this initial speed [m/s; rad/s].
    Place(f32),
}

/// The motion that a drive demands; `None` if it moves nothing. It has reached its target within
/// `near` [m; rad].
fn drive_asks(drive: &JointDrive, near: f32, error: impl Fn() -> f32) -> Option<Asked> {
    let JointDrive { velocity, spring, max_force, .. } = *drive;
    if max_force <= 0.0 {
        return None;
    }
    let asked = if spring.damping > 0.0 { velocity.abs() } else { 0.0 };
    if asked > 0.0 {
        return Some(Asked::Speed(asked));
    }
    if spring.stiffness <= 0.0 {
        return None;
    }
    // An overdamped drive approaches its target at this rate [1/s]; others are faster.
    let rate = if spring.damping > 0.0 { spring.stiffness / spring.damping } else { f32::INFINITY };
    let error = error().abs();
    Some(Asked::Place(if error <= near { f32::INFINITY } else { rate * error }))
}

/// A coordinate of a joint of six axes [m; rad]. With a cone, the swings are the y and z components
/// of the swing vector.
fn coordinate_of(joint: &Joint, six_dof: &SixDofJoint, bodies: &Bodies, axis: usize) -> f32 {
    if axis > 3 && six_dof.def.cone.is_some() {
        let (a, b) = (bodies.at(joint.body_a), bodies.at(joint.body_b));
        let turns = six_dof.joint_angles(a.rotation, b.rotation);
        return turns.swing[axis - 4] * turns.angles[1];
    }
    #[expect(clippy::cast_possible_truncation, reason = "an angle or a length")]
    let x = coordinate(joint, six_dof, bodies, axis) as f32;
    x
}
