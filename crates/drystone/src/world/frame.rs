//! Calls that a game makes in each frame. They return nothing: a value that cannot be computed with changes nothing, and is a
//! fault of the next step that names the call ([`FaultKind::Refused`]).

use super::World;
use super::body::BodyMut;
use super::joint_axis::AxisMut;
use super::joint_mut::JointMut;
use super::particle::{LinkMut, ParticleMut};
use super::shape::ShapeMut;
use super::told::Told as _;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::state::events::FrameCall;
use crate::state::sixdof::JointSpring;

impl World {
    /// Replaces gravity [m/s², world] and wakes all bodies.
    ///
    /// # Faults
    /// A component is not finite or beyond 1e6 m/s².
    pub fn set_gravity(&mut self, gravity: impl Into<Vec3>) {
        let _ = self.told(FrameCall::SetGravity, |of| of.try_set_gravity(gravity));
    }
}

impl BodyMut<'_> {
    /// Puts its origin somewhere else at once [m, world], keeping its velocity. It pushes and carries nobody: a lift is moved by
    /// [`Self::move_to`]. To keep its rotation: `Pose { position, ..body.get().pose() }`.
    ///
    /// # Faults
    /// A number is not finite or too large, or the rotation is not a unit quaternion; then nothing is
    /// changed.
    pub fn set_pose(&mut self, pose: Pose) {
        let _ = self.told(FrameCall::SetPose, |of| of.try_set_pose(pose));
    }

    /// Sets the velocity of the center of mass [m/s, world]. No effect on static bodies.
    ///
    /// # Faults
    /// A number is not finite or too large.
    pub fn set_linear_velocity(&mut self, v: impl Into<Vec3>) {
        let _ = self.told(FrameCall::SetLinearVelocity, |of| of.try_set_linear_velocity(v));
    }

    /// Sets the angular velocity [rad/s, world]. No effect on static bodies.
    ///
    /// # Faults
    /// A number is not finite or too large.
    pub fn set_angular_velocity(&mut self, w: impl Into<Vec3>) {
        let _ = self.told(FrameCall::SetAngularVelocity, |of| of.try_set_angular_velocity(w));
    }

    /// Gives a kinematic body the velocity that takes it to `pose` in one step of `dt` [s]; for other
    /// kinds of bodies nothing is changed.
    ///
    /// The velocity lasts: if it is not told another one, it goes on beyond the pose in the steps after. A lift that is to stand gets
    /// velocity 0, or is moved to where it is in every step. The manual: [bodies](crate::manual::bodies).
    ///
    /// # Faults
    /// A number is not finite or too large, `dt` is not from 1e-6 to 10 s, or the velocity would be beyond 1e6 m/s or
    /// rad/s.
    pub fn move_to(&mut self, pose: Pose, dt: f32) {
        let _ = self.told(FrameCall::MoveTo, |of| of.try_move_to(pose, dt));
    }

    /// Changes the velocity of the center of mass at once by an impulse [N s, world]. Dynamic bodies
    /// only.
    ///
    /// # Faults
    /// A number is not finite, or the velocity would be beyond 1e6 m/s.
    pub fn apply_impulse(&mut self, impulse: impl Into<Vec3>) {
        let _ = self.told(FrameCall::ApplyImpulse, |of| of.try_apply_impulse(impulse));
    }

    /// An impulse [N s, world] at a point [m, world]: changes linear and angular velocity at once.
    ///
    /// # Faults
    /// A number is not finite, or a velocity would be beyond 1e6 m/s or rad/s.
    pub fn apply_impulse_at(&mut self, impulse: impl Into<Vec3>, point: impl Into<Vec3>) {
        let _ = self.told(FrameCall::ApplyImpulseAt, |of| of.try_apply_impulse_at(impulse, point));
    }

    /// Changes the angular velocity at once by an angular impulse [N m s, world]. Dynamic bodies only.
    ///
    /// # Faults
    /// A number is not finite, or the angular velocity would be beyond 1e6 rad/s.
    pub fn apply_angular_impulse(&mut self, impulse: impl Into<Vec3>) {
        let _ =
            self.told(FrameCall::ApplyAngularImpulse, |of| of.try_apply_angular_impulse(impulse));
    }

    /// Adds a force [N, world] at the center of mass for the next step only. Dynamic bodies only.
    ///
    /// # Faults
    /// A number is not finite, or all forces for the step together accelerate it by more than 1e10 m/s².
    pub fn add_step_force(&mut self, force: impl Into<Vec3>) {
        let _ = self.told(FrameCall::AddStepForce, |of| of.try_add_step_force(force));
    }

    /// Adds a force [N, world] at a point [m, world] for the next step only. Dynamic bodies only.
    ///
    /// # Faults
    /// As of [`Self::add_step_force`] and [`Self::add_step_torque`].
    pub fn add_step_force_at(&mut self, force: impl Into<Vec3>, point: impl Into<Vec3>) {
        let _ = self.told(FrameCall::AddStepForceAt, |of| of.try_add_step_force_at(force, point));
    }

    /// Adds a torque [N m, world] for the next step only. Dynamic bodies only.
    ///
    /// # Faults
    /// A number is not finite, or all torques for the step together accelerate it by more than 1e10 rad/s².
    pub fn add_step_torque(&mut self, torque: impl Into<Vec3>) {
        let _ = self.told(FrameCall::AddStepTorque, |of| of.try_add_step_torque(torque));
    }

    /// Sets the lasting force [N, world] at the center of mass: acts in every step until it is set
    /// anew. Dynamic bodies only.
    ///
    /// # Faults
    /// A number is not finite, or accelerates it by more than 1e10 m/s².
    pub fn set_lasting_force(&mut self, force: impl Into<Vec3>) {
        let _ = self.told(FrameCall::SetLastingForce, |of| of.try_set_lasting_force(force));
    }

    /// Sets the lasting torque [N m, world]. Dynamic bodies only.
    ///
    /// # Faults
    /// A number is not finite, or accelerates it by more than 1e10 rad/s².
    pub fn set_lasting_torque(&mut self, torque: impl Into<Vec3>) {
        let _ = self.told(FrameCall::SetLastingTorque, |of| of.try_set_lasting_torque(torque));
    }

    /// How many times gravity counts.
    ///
    /// # Faults
    /// The number is not within -1000 to 1000.
    pub fn set_gravity_scale(&mut self, scale: f32) {
        let _ = self.told(FrameCall::SetGravityScale, |of| of.try_set_gravity_scale(scale));
    }

    /// Rates at which linear and angular velocity decay [1/s].
    ///
    /// # Faults
    /// A number is not within 0 to 1e9 1/s.
    pub fn set_damping(&mut self, linear: f32, angular: f32) {
        let _ = self.told(FrameCall::SetDamping, |of| of.try_set_damping(linear, angular));
    }
}

impl ShapeMut<'_> {
    /// Lets its surface move over it, as a conveyor belt does [m/s, frame of the shape]; what it
    /// touches wakes.
    ///
    /// # Faults
    /// A number is not finite or too large.
    pub fn set_surface_velocity(&mut self, v: impl Into<Vec3>) {
        let _ = self.told(FrameCall::SetSurfaceVelocity, |of| of.try_set_surface_velocity(v));
    }

    /// Lets its surface turn over it, about its origin [rad/s, frame of the shape]; what it touches
    /// wakes.
    ///
    /// # Faults
    /// A number is not finite or too large.
    pub fn set_surface_spin(&mut self, spin: impl Into<Vec3>) {
        let _ = self.told(FrameCall::SetSurfaceSpin, |of| of.try_set_surface_spin(spin));
    }
}

impl ParticleMut<'_> {
    /// Puts it somewhere else [m, world], at the velocity it has.
    ///
    /// # Faults
    /// A number that is not finite, or beyond 1e7 m.
    pub fn set_position(&mut self, x: impl Into<Vec3>) {
        let _ = self.told(FrameCall::SetParticlePosition, |of| of.try_set_position(x));
    }

    /// Gives it a velocity [m/s, world].
    ///
    /// # Faults
    /// A number that is not finite, or beyond 1e6 m/s.
    pub fn set_velocity(&mut self, v: impl Into<Vec3>) {
        let _ = self.told(FrameCall::SetParticleVelocity, |of| of.try_set_velocity(v));
    }

    /// Adds an impulse [N s, world]. Does nothing to one that is pinned.
    ///
    /// # Faults
    /// A number that is not finite, or a velocity beyond 1e6 m/s.
    pub fn apply_impulse(&mut self, impulse: impl Into<Vec3>) {
        let _ = self.told(FrameCall::ApplyParticleImpulse, |of| of.try_apply_impulse(impulse));
    }
}

impl LinkMut<'_> {
    /// Gives it another length [m], and wakes its particles: a rope that is reeled in.
    ///
    /// # Faults
    /// A length that is not from 1e-5 to 1e7 m.
    pub fn set_length(&mut self, length: f32) {
        let _ = self.told(FrameCall::SetLinkLength, |of| of.try_set_length(length));
    }
}

impl JointMut<'_> {
    /// Drives its free axis at this speed [m/s; rad/s] with at most this force [N; N m]. With speed 0 it is a brake.
    ///
    /// # Faults
    /// A number out of range; a joint with another number of free axes than one.
    pub fn set_motor(&mut self, speed: f32, max_force: f32) {
        let _ = self.told(FrameCall::SetMotor, |of| of.try_set_motor(speed, max_force));
    }

    /// Pulls its free axis to this position [m; rad] with at most this force [N; N m].
    ///
    /// # Faults
    /// As [`Self::set_motor`].
    pub fn set_servo(&mut self, position: f32, spring: JointSpring, max_force: f32) {
        let _ = self.told(FrameCall::SetServo, |of| of.try_set_servo(position, spring, max_force));
    }

    /// Drives all turns of a joint that leaves three to this rotation of the second frame in the first: a ball joint of six
    /// axes, a cone-twist, a muscle of a figure. Each torque is at most `max_torque` [N m; may be ∞].
    ///
    /// # Faults
    /// A rotation that is not a unit quaternion, a number out of range; a joint that locks a turn.
    pub fn set_target_rotation(&mut self, rotation: Quat, spring: JointSpring, max_torque: f32) {
        let _ = self.told(FrameCall::SetTargetRotation, |of| {
            of.try_set_target_rotation(rotation, spring, max_torque)
        });
    }

    /// Changes how long a distance joint, a rope or a spring is [m]: at least and at most.
    ///
    /// # Faults
    /// A length that is not from 0 to 1e9 m, a greatest one below the least; a joint of another kind.
    pub fn set_lengths(&mut self, min: f32, max: f32) {
        let _ = self.told(FrameCall::SetLengths, |of| of.try_set_lengths(min, max));
    }
}

impl AxisMut<'_, '_> {
    /// Drives it at this speed [m/s; rad/s] with at most this force [N; N m]. With speed 0 it is a brake.
    ///
    /// # Faults
    /// A number out of range; a swing of a joint with a cone, of which both change at once ([`JointMut::set_axes`]).
    pub fn set_motor(&mut self, speed: f32, max_force: f32) {
        let _ = self.told(FrameCall::SetMotor, |of| of.try_set_motor(speed, max_force));
    }

    /// Pulls it to this position [m; rad] with at most this force [N; N m].
    ///
    /// # Faults
    /// As [`Self::set_motor`].
    pub fn set_servo(&mut self, position: f32, spring: JointSpring, max_force: f32) {
        let _ = self.told(FrameCall::SetServo, |of| of.try_set_servo(position, spring, max_force));
    }
}
