//! One axis of a joint of six axes, as the user sees it.

use super::joint::JointRef;
use super::joint_mut::JointMut;
use crate::base::math::{Vec3, bounded};
use crate::state::axis::Axis;
use crate::state::coupling::coordinate;
use crate::state::def::DefError;
use crate::state::joints::Link;
use crate::state::six::{Six, Turns};
use crate::state::sixdof::{JointAxis, JointDrive, JointMotion, JointSpring};

/// One axis of a joint of six axes, to read: a hinge's turn, a slider's way, the spring of a wheel.
///
/// Coordinates, speeds and forces are those of the second body against the first, along the axis or by the right hand about
/// it. A hinge whose axis points to you has a positive speed if its second body turns counterclockwise against the first.
///
/// ```
/// use drystone::joint::Hinge;
/// use drystone::{BodyDef, JointDef, ShapeDef, World};
///
/// # fn main() -> Result<(), drystone::DefError> {
/// let mut world = World::default();
/// let wall = world.add_body(BodyDef::fixed())?;
/// let wheel = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5)))?;
/// let motor = Hinge::new().with_motor(3.0, 1.0e5);
/// let joint = world.add_joint(JointDef::new(wall, wheel, motor).at([0.0; 3]))?;
/// for _ in 0..300 {
///     world.step(1.0 / 60.0);
/// }
/// let joint = world.joint(joint).expect("nothing removed it");
/// let turn = joint.hinge().expect("it turns about one axis");
/// // Five seconds at 3 rad/s: more than two turns, which are counted.
/// assert!((turn.position() - 15.0).abs() < 0.01 && (turn.speed() - 3.0).abs() < 0.001);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct AxisRef<'w> {
    joint: JointRef<'w>,
    six: &'w Six,
    axis: Axis,
}

impl<'w> AxisRef<'w> {
    pub(super) fn new(joint: JointRef<'w>, axis: Axis) -> Option<Self> {
        let Link::Six(six) = &joint.joint.link else { return None };
        Some(Self { joint, six, axis })
    }

    /// Which axis it is.
    #[must_use]
    pub const fn axis(&self) -> Axis {
        self.axis
    }

    /// Its limits, its drive and its friction.
    #[must_use]
    pub const fn def(&self) -> &'w JointAxis {
        self.six.def.axis(self.axis)
    }

    /// Coordinate of the second frame in the first one [m; rad]. The angle of a joint with one free turn counts full turns
    /// while the world steps; the angles of joints with more free turns are within ±π.
    #[must_use]
    pub fn position(&self) -> f32 {
        let (i, bodies) = (self.axis.index(), &self.joint.tables.bodies);
        if i > 3 && self.six.def.cone.is_some() {
            let turns = self.turns();
            return turns.angles[1] * turns.swing[i - 4];
        }
        #[expect(clippy::cast_possible_truncation, reason = "a coordinate, as all of them are")]
        let x = coordinate(self.joint.joint, self.six, bodies, i) as f32;
        x
    }

    /// Rate of its position [m/s; rad/s]. For the swings of a joint with three free turns it is the relative angular velocity
    /// about the axis of the first frame.
    #[must_use]
    pub fn speed(&self) -> f32 {
        let bodies = &self.joint.tables.bodies;
        let [a, b] = [self.joint.joint.body_a, self.joint.joint.body_b].map(|row| bodies.at(row));
        let speed = if self.axis.is_turn() {
            self.direction().dot(b.w - a.w)
        } else {
            // The axis turns with the first body, whose point is where the second anchor is.
            let at = self.joint.anchor_b();
            let v = b.velocity_at(at - b.center) - a.velocity_at(at - a.center);
            self.direction().dot(v)
        };
        bounded(speed)
    }

    /// Its direction [world]: motions are along it, turns about it. It has unit length, except for the twist of a joint that
    /// is swung: there its product with the relative angular velocity is the rate of the twist.
    #[must_use]
    pub fn direction(&self) -> Vec3 {
        let i = self.axis.index();
        if !self.axis.is_turn() {
            let a = self.joint.tables.bodies.at(self.joint.joint.body_a);
            return (a.rotation * self.six.def.frame_a).rotate([Vec3::X, Vec3::Y, Vec3::Z][i]);
        }
        let Turns { rows, swing: [y, z], .. } = self.turns();
        match (self.axis, self.six.def.cone) {
            (Axis::TurnY, Some(_)) => rows[1] * y - rows[2] * z,
            (Axis::TurnZ, Some(_)) => rows[1] * z + rows[2] * y,
            _ => rows[i - 3],
        }
    }

    /// Least and greatest position [m; rad]; `None` where it is free. Both are 0 where it is locked.
    #[must_use]
    pub const fn limits(&self) -> Option<(f32, f32)> {
        self.def().limits()
    }

    /// The motor, servo or spring that drives it; `None` if nothing does.
    #[must_use]
    pub const fn drive(&self) -> Option<JointDrive> {
        self.def().drive
    }

    /// Force on the second body along it, or torque about it, by all that the joint does there in the last substep: what
    /// holds it, limits, drive and friction [N; N m].
    #[must_use]
    pub fn force(&self) -> f32 {
        let on_b = if self.axis.is_turn() { self.joint.torque() } else { self.joint.force() };
        bounded(on_b.dot(self.direction().normalize_or(Vec3::ZERO)))
    }

    /// The part of [`Self::force`] that its drive gave [N; N m]: what a motor needs. 0 where it is locked or not driven.
    #[must_use]
    pub fn drive_force(&self) -> f32 {
        let (def, i) = (self.def(), self.axis.index());
        if def.held().is_some() || def.drive.is_none() {
            return 0.0;
        }
        let held = &self.six.state.held;
        let [y, z] = self.turns().swing;
        let impulse = match (self.axis, self.six.def.cone) {
            (Axis::TurnY, Some(_)) => held[4] * y - held[5] * z,
            (Axis::TurnZ, Some(_)) => held[4] * z + held[5] * y,
            _ => held[i],
        };
        self.joint.per_time(Vec3::X * impulse).x
    }

    fn turns(&self) -> Turns {
        let bodies = &self.joint.tables.bodies;
        let [a, b] = [self.joint.joint.body_a, self.joint.joint.body_b].map(|row| bodies.at(row));
        self.six.turns(a.rotation, b.rotation)
    }
}

/// One axis of a joint of six axes, to change. An error leaves everything as it was.
///
/// ```
/// # use drystone::{Axis, DefError, JointId, World};
/// # use drystone::joint::JointSpring;
/// fn steer(world: &mut World, wheel: JointId, angle: f32) -> Result<(), DefError> {
///     let Some(mut joint) = world.joint_mut(wheel) else { return Ok(()) };
///     let Some(mut steering) = joint.axis(Axis::TurnX) else { return Ok(()) };
///     steering.set_servo(angle, JointSpring::hertz(8.0, 1.0), 2000.0)
/// }
/// ```
#[derive(Debug)]
pub struct AxisMut<'j, 'w> {
    joint: &'j mut JointMut<'w>,
    axis: Axis,
}

impl AxisMut<'_, '_> {
    /// The axis, to read.
    #[must_use]
    pub fn get(&self) -> AxisRef<'_> {
        self.joint.get().axis(self.axis).expect("made of joints of six axes only")
    }

    /// Changes all of it.
    ///
    /// # Errors
    /// A field is out of range; an axis that becomes locked while a coupling names it; a swing of a joint with a cone, of
    /// which both change at once ([`JointMut::set_axes`]).
    pub fn set(&mut self, axis: JointAxis) -> Result<(), DefError> {
        let six = self.joint.six()?.with_axis(self.axis, axis);
        self.joint.put_six(six)
    }

    /// Changes how far it lets the bodies move. Its drive and friction stay.
    ///
    /// # Errors
    /// As [`Self::set`].
    pub fn set_motion(&mut self, motion: JointMotion) -> Result<(), DefError> {
        self.set(JointAxis { motion, ..*self.get().def() })
    }

    /// Sets two hard stops [m; rad].
    ///
    /// # Errors
    /// As [`Self::set`].
    pub fn set_limits(&mut self, min: f32, max: f32) -> Result<(), DefError> {
        self.set_motion(JointMotion::Limited { min, max, spring: None })
    }

    /// Changes what drives it; nothing on a locked axis.
    ///
    /// # Errors
    /// As [`Self::set`].
    pub fn set_drive(&mut self, drive: Option<JointDrive>) -> Result<(), DefError> {
        self.set(JointAxis { drive, ..*self.get().def() })
    }

    /// Drives it at this speed [m/s; rad/s] with at most this force [N; N m]. With speed 0 it is a brake.
    ///
    /// # Errors
    /// As [`Self::set`].
    pub fn set_motor(&mut self, speed: f32, max_force: f32) -> Result<(), DefError> {
        self.set_drive(Some(JointDrive::motor(speed, max_force)))
    }

    /// Pulls it to this position [m; rad] with at most this force [N; N m].
    ///
    /// # Errors
    /// As [`Self::set`].
    pub fn set_servo(
        &mut self,
        position: f32,
        spring: JointSpring,
        max_force: f32,
    ) -> Result<(), DefError> {
        self.set_drive(Some(JointDrive::servo(position, spring, max_force)))
    }

    /// Sets the greatest force of dry friction along it [N; N m].
    ///
    /// # Errors
    /// As [`Self::set`].
    pub fn set_friction(&mut self, friction: f32) -> Result<(), DefError> {
        self.set(JointAxis { friction, ..*self.get().def() })
    }
}

impl<'w> JointMut<'w> {
    /// One of its axes, to change; `None` if it is no joint of six axes.
    #[must_use]
    pub fn axis(&mut self, axis: Axis) -> Option<AxisMut<'_, 'w>> {
        self.six().ok()?;
        Some(AxisMut { joint: self, axis })
    }

    /// The one turn that it leaves free, as of a hinge, a cylinder or a wheel, to change.
    #[must_use]
    pub fn hinge(&mut self) -> Option<AxisMut<'_, 'w>> {
        let axis = self.get().hinge()?.axis();
        self.axis(axis)
    }

    /// The one motion that it leaves free, as of a slider, a cylinder or a wheel, to change.
    #[must_use]
    pub fn slider(&mut self) -> Option<AxisMut<'_, 'w>> {
        let axis = self.get().slider()?.axis();
        self.axis(axis)
    }

    pub(super) fn only(&mut self) -> Result<AxisMut<'_, 'w>, DefError> {
        let axis = self.only_axis()?;
        Ok(AxisMut { joint: self, axis })
    }

    /// Sets the hard stops of its free axis [m; rad].
    ///
    /// # Errors
    /// A number out of range; a joint with another number of free axes than one.
    pub fn set_limits(&mut self, min: f32, max: f32) -> Result<(), DefError> {
        self.only()?.set_limits(min, max)
    }

    /// Changes how far its free axis lets the bodies move: `JointMotion::Free` takes the limits away.
    ///
    /// # Errors
    /// As [`Self::set_limits`].
    pub fn set_motion(&mut self, motion: JointMotion) -> Result<(), DefError> {
        self.only()?.set_motion(motion)
    }

    /// Changes what drives its free axis; `None` lets it go.
    ///
    /// # Errors
    /// As [`Self::set_limits`].
    pub fn set_drive(&mut self, drive: Option<JointDrive>) -> Result<(), DefError> {
        self.only()?.set_drive(drive)
    }

    /// Drives its free axis at this speed [m/s; rad/s] with at most this force [N; N m]. With speed 0 it is a brake.
    ///
    /// # Errors
    /// As [`Self::set_limits`].
    pub fn set_motor(&mut self, speed: f32, max_force: f32) -> Result<(), DefError> {
        self.only()?.set_motor(speed, max_force)
    }

    /// Pulls its free axis to this position [m; rad] with at most this force [N; N m].
    ///
    /// # Errors
    /// As [`Self::set_limits`].
    pub fn set_servo(
        &mut self,
        position: f32,
        spring: JointSpring,
        max_force: f32,
    ) -> Result<(), DefError> {
        self.only()?.set_servo(position, spring, max_force)
    }

    /// Sets the greatest force of dry friction along its free axis [N; N m].
    ///
    /// # Errors
    /// As [`Self::set_limits`].
    pub fn set_friction(&mut self, friction: f32) -> Result<(), DefError> {
        self.only()?.set_friction(friction)
    }
}
