//! Public access to one axis of a joint of six axes.

use super::JointRef;
use super::change::JointMut;
use crate::base::math::{Vec3, bounded};
use crate::state::coupling::coordinate;
use crate::state::def::DefError;
use crate::state::def::axis::Axis;
use crate::state::def::six_dof::{JointAxis, JointDrive, JointMotion, JointSpring};
use crate::state::joints::JointModel;
use crate::state::six_dof::{JointAngles, SixDofJoint};

/// One axis of a joint of six axes, read-only: a hinge's rotation, a slider's translation, the
/// spring of a wheel.
///
/// Coordinates, speeds and forces are those of the second body relative to the first, along the
/// axis or about it by the right-hand rule. If a hinge axis points to you, a positive speed turns
/// the second body counterclockwise relative to the first.
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
    six_dof: &'w SixDofJoint,
    axis: Axis,
}

impl<'w> AxisRef<'w> {
    pub(crate) fn new(joint: JointRef<'w>, axis: Axis) -> Option<Self> {
        let JointModel::SixDof(six_dof) = &joint.joint.model else { return None };
        Some(Self { joint, six_dof, axis })
    }

    /// The name of the axis.
    #[must_use]
    pub const fn axis(&self) -> Axis {
        self.axis
    }

    /// Its limits, its drive and its friction.
    #[must_use]
    pub const fn def(&self) -> &'w JointAxis {
        self.six_dof.def.axis(self.axis)
    }

    /// Coordinate of the second frame in the first one [m; rad]. The angle of a joint with one free
    /// rotation counts full turns while the world steps. Angles of joints with more free rotations
    /// are within ±π.
    #[must_use]
    pub fn position(&self) -> f32 {
        let (i, bodies) = (self.axis.index(), &self.joint.tables.bodies);
        if i > 3 && self.six_dof.def.cone.is_some() {
            let turns = self.joint_angles();
            return turns.angles[1] * turns.swing[i - 4];
        }
        #[expect(clippy::cast_possible_truncation, reason = "a coordinate, as all of them are")]
        let x = coordinate(self.joint.joint, self.six_dof, bodies, i) as f32;
        x
    }

    /// Rate of its position [m/s; rad/s]. For a swing of a joint with three free rotations it is
    /// the relative angular velocity about the axis of the first frame.
    #[must_use]
    pub fn speed(&self) -> f32 {
        let bodies = &self.joint.tables.bodies;
        let [a, b] = [self.joint.joint.body_a, self.joint.joint.body_b].map(|row| bodies.at(row));
        let speed = if self.axis.is_turn() {
            self.direction().dot(b.w - a.w)
        } else {
            // The axis turns with the first body, whose relevant point is at the second anchor.
            let at = self.joint.anchor_b();
            let v = b.velocity_at(at - b.center) - a.velocity_at(at - a.center);
            self.direction().dot(v)
        };
        bounded(speed)
    }

    /// Its direction [world]: translations are along it, rotations about it. It has unit length,
    /// except for the twist of a joint with a swing. There its dot product with the relative
    /// angular velocity is the rate of the twist.
    #[must_use]
    pub fn direction(&self) -> Vec3 {
        let i = self.axis.index();
        if !self.axis.is_turn() {
            let a = self.joint.tables.bodies.at(self.joint.joint.body_a);
            return (a.rotation * self.six_dof.def.frame_a).rotate([Vec3::X, Vec3::Y, Vec3::Z][i]);
        }
        let JointAngles { rows, swing: [y, z], .. } = self.joint_angles();
        match (self.axis, self.six_dof.def.cone) {
            (Axis::TurnY, Some(_)) => rows[1] * y - rows[2] * z,
            (Axis::TurnZ, Some(_)) => rows[1] * z + rows[2] * y,
            _ => rows[i - 3],
        }
    }

    /// Minimum and maximum position [m; rad]; `None` where it is free. Both are 0 where it is
    /// locked.
    #[must_use]
    pub const fn limits(&self) -> Option<(f32, f32)> {
        self.def().limits()
    }

    /// The motor, servo or spring that drives it; `None` if it has none.
    #[must_use]
    pub const fn drive(&self) -> Option<JointDrive> {
        self.def().drive
    }

    /// Total force on the second body along it, or torque about it, in the last substep [N; N m]:
    /// lock, limits, drive and friction together.
    #[must_use]
    pub fn force(&self) -> f32 {
        let on_b = if self.axis.is_turn() { self.joint.torque() } else { self.joint.force() };
        bounded(on_b.dot(self.direction().normalize_or(Vec3::ZERO)))
    }

    /// The part of [`Self::force`] that its drive supplied [N; N m]: the load of a motor. 0 where
    /// it is locked or has no drive.
    #[must_use]
    pub fn drive_force(&self) -> f32 {
        let (def, i) = (self.def(), self.axis.index());
        if def.locked_at().is_some() || def.drive.is_none() {
            return 0.0;
        }
        let held = &self.six_dof.state.lock_or_drive;
        let [y, z] = self.joint_angles().swing;
        let impulse = match (self.axis, self.six_dof.def.cone) {
            (Axis::TurnY, Some(_)) => held[4] * y - held[5] * z,
            (Axis::TurnZ, Some(_)) => held[4] * z + held[5] * y,
            _ => held[i],
        };
        self.joint.per_time(Vec3::X * impulse).x
    }

    fn joint_angles(&self) -> JointAngles {
        let bodies = &self.joint.tables.bodies;
        let [a, b] = [self.joint.joint.body_a, self.joint.joint.body_b].map(|row| bodies.at(row));
        self.six_dof.joint_angles(a.rotation, b.rotation)
    }
}

/// One axis of a joint of six axes, for changes. After an error everything is unchanged.
///
/// ```
/// # use drystone::{Axis, JointId, World};
/// # use drystone::joint::JointSpring;
/// fn steer(world: &mut World, wheel: JointId, angle: f32) {
///     let Some(mut joint) = world.joint_mut(wheel) else { return };
///     let Some(mut steering) = joint.axis(Axis::TurnX) else { return };
///     steering.set_servo(angle, JointSpring::hertz(8.0, 1.0), 2000.0);
/// }
/// ```
#[derive(Debug)]
pub struct AxisMut<'j, 'w> {
    pub(crate) joint: &'j mut JointMut<'w>,
    axis: Axis,
}

impl AxisMut<'_, '_> {
    /// The axis, read-only.
    #[must_use]
    pub fn get(&self) -> AxisRef<'_> {
        self.joint.get().axis(self.axis).expect("made of joints of six axes only")
    }

    /// Replaces all settings of the axis.
    ///
    /// # Errors
    /// A field is out of range; the axis would become locked while a coupling refers to it; the
    /// axis is a swing of a joint with a cone. Both swings of a cone change together
    /// ([`JointMut::set_axes`]).
    pub fn set(&mut self, axis: JointAxis) -> Result<(), DefError> {
        let six_dof = self.joint.six_dof()?.with_axis(self.axis, axis);
        self.joint.put_six_dof(six_dof)
    }

    /// Sets its motion: free, locked or limited. Its drive and friction stay unchanged.
    ///
    /// # Errors
    /// The same errors as those of [`Self::set`].
    pub fn set_motion(&mut self, motion: JointMotion) -> Result<(), DefError> {
        self.set(JointAxis { motion, ..*self.get().def() })
    }

    /// Sets minimum and maximum as hard stops [m; rad].
    ///
    /// # Errors
    /// The same errors as those of [`Self::set`].
    pub fn set_limits(&mut self, min: f32, max: f32) -> Result<(), DefError> {
        self.set_motion(JointMotion::Limited { min, max, spring: None })
    }

    /// Sets or removes its drive. No effect on a locked axis.
    ///
    /// # Errors
    /// The same errors as those of [`Self::set`].
    pub fn set_drive(&mut self, drive: Option<JointDrive>) -> Result<(), DefError> {
        self.set(JointAxis { drive, ..*self.get().def() })
    }

    /// See [`Self::set_motor`].
    pub(crate) fn try_set_motor(&mut self, speed: f32, max_force: f32) -> Result<(), DefError> {
        self.set_drive(Some(JointDrive::motor(speed, max_force)))
    }

    /// See [`Self::set_servo`].
    pub(crate) fn try_set_servo(
        &mut self,
        position: f32,
        spring: JointSpring,
        max_force: f32,
    ) -> Result<(), DefError> {
        self.set_drive(Some(JointDrive::servo(position, spring, max_force)))
    }

    /// Sets the maximum force of dry friction along it [N; N m].
    ///
    /// # Errors
    /// The same errors as those of [`Self::set`].
    pub fn set_friction(&mut self, friction: f32) -> Result<(), DefError> {
        self.set(JointAxis { friction, ..*self.get().def() })
    }
}

impl<'w> JointMut<'w> {
    /// One of its axes, for changes; `None` if it is not a joint of six axes.
    #[must_use]
    pub fn axis(&mut self, axis: Axis) -> Option<AxisMut<'_, 'w>> {
        self.six_dof().ok()?;
        Some(AxisMut { joint: self, axis })
    }

    /// The one free rotation axis, as of a hinge, a cylinder or a wheel, for changes.
    #[must_use]
    pub fn hinge(&mut self) -> Option<AxisMut<'_, 'w>> {
        let axis = self.get().hinge()?.axis();
        self.axis(axis)
    }

    /// The one free translation axis, as of a slider, a cylinder or a wheel, for changes.
    #[must_use]
    pub fn slider(&mut self) -> Option<AxisMut<'_, 'w>> {
        let axis = self.get().slider()?.axis();
        self.axis(axis)
    }

    pub(crate) fn only(&mut self) -> Result<AxisMut<'_, 'w>, DefError> {
        let axis = self.only_axis()?;
        Ok(AxisMut { joint: self, axis })
    }

    /// Sets hard stops on its free axis [m; rad].
    ///
    /// # Errors
    /// A number is out of range, or the joint does not have exactly one free axis.
    pub fn set_limits(&mut self, min: f32, max: f32) -> Result<(), DefError> {
        self.only()?.set_limits(min, max)
    }

    /// Sets the motion of its free axis; `JointMotion::Free` removes the limits.
    ///
    /// # Errors
    /// The same errors as those of [`Self::set_limits`].
    pub fn set_motion(&mut self, motion: JointMotion) -> Result<(), DefError> {
        self.only()?.set_motion(motion)
    }

    /// Sets the drive of its free axis; `None` removes it.
    ///
    /// # Errors
    /// The same errors as those of [`Self::set_limits`].
    pub fn set_drive(&mut self, drive: Option<JointDrive>) -> Result<(), DefError> {
        self.only()?.set_drive(drive)
    }

    /// See [`Self::set_motor`].
    pub(crate) fn try_set_motor(&mut self, speed: f32, max_force: f32) -> Result<(), DefError> {
        self.only()?.try_set_motor(speed, max_force)
    }

    /// See [`Self::set_servo`].
    pub(crate) fn try_set_servo(
        &mut self,
        position: f32,
        spring: JointSpring,
        max_force: f32,
    ) -> Result<(), DefError> {
        self.only()?.try_set_servo(position, spring, max_force)
    }

    /// Sets the maximum force of dry friction along its free axis [N; N m].
    ///
    /// # Errors
    /// The same errors as those of [`Self::set_limits`].
    pub fn set_friction(&mut self, friction: f32) -> Result<(), DefError> {
        self.only()?.set_friction(friction)
    }
}
