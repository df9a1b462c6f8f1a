//! Setters for every frame of a game. They return nothing. An argument that is out of range changes
//! nothing, and the next step reports a fault that names the call ([`FaultKind::Refused`]).

use super::World;
use super::body::BodyMut;
use super::joint::axis::AxisMut;
use super::joint::change::JointMut;
use super::particle::{LinkMut, ParticleMut};
use super::refused::Told as _;
use super::shape::ShapeMut;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::state::def::six_dof::JointSpring;
use crate::state::events::FrameCall;

impl World {
    /// Replaces gravity [m/s², world] and wakes all bodies.
    ///
    /// # Faults
    /// A component is not finite, or beyond 1e6 m/s².
    pub fn set_gravity(&mut self, gravity: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::SetGravity, |of| of.try_set_gravity(gravity));
    }
}

impl BodyMut<'_> {
    /// Moves the body's origin to another pose at once [m, world] and keeps its velocity. It pushes
    /// and carries no other body: use [`Self::move_to`] to move a lift. To keep the rotation: `Pose
    /// { position, ..body.get().pose() }`.
    ///
    /// # Faults
    /// A number is not finite or too large, or the rotation is not a unit quaternion. Then nothing
    /// is changed.
    pub fn set_pose(&mut self, pose: Pose) {
        let _ = self.attempt(FrameCall::SetPose, |of| of.try_set_pose(pose));
    }

    /// Sets the velocity of the center of mass [m/s, world]. No effect on static bodies.
    ///
    /// # Faults
    /// A number is not finite or too large.
    pub fn set_linear_velocity(&mut self, v: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::SetLinearVelocity, |of| of.try_set_linear_velocity(v));
    }

    /// Sets the angular velocity [rad/s, world]. No effect on static bodies.
    ///
    /// # Faults
    /// A number is not finite or too large.
    pub fn set_angular_velocity(&mut self, w: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::SetAngularVelocity, |of| of.try_set_angular_velocity(w));
    }

    /// Gives a kinematic body the velocity that takes it to `pose` [m, world] in one step of `dt`
    /// [s], 1e-6 to 10. No effect on other kinds of bodies.
    ///
    /// The velocity lasts: without another call, the body moves on beyond the pose in later steps.
    /// To stop a lift, set its velocity to 0, or move it to its own pose in every step. The manual:
    /// [bodies](crate::manual::bodies).
    ///
    /// # Faults
    /// A number is not finite or too large, `dt` is not from 1e-6 to 10 s, or the velocity would be
    /// beyond 1e6 m/s or rad/s.
    pub fn move_to(&mut self, pose: Pose, dt: f32) {
        let _ = self.attempt(FrameCall::MoveTo, |of| of.try_move_to(pose, dt));
    }

    /// Changes the velocity of the center of mass at once by an impulse [N s, world]. Dynamic
    /// bodies only.
    ///
    /// # Faults
    /// A number is not finite, or the velocity would be beyond 1e6 m/s.
    pub fn apply_impulse(&mut self, impulse: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::ApplyImpulse, |of| of.try_apply_impulse(impulse));
    }

    /// Applies an impulse [N s, world] at a point [m, world]: changes linear and angular velocity
    /// at once. Dynamic bodies only.
    ///
    /// # Faults
    /// A number is not finite, or a velocity would be beyond 1e6 m/s or rad/s.
    pub fn apply_impulse_at(&mut self, impulse: impl Into<Vec3>, point: impl Into<Vec3>) {
        let _ =
            self.attempt(FrameCall::ApplyImpulseAt, |of| of.try_apply_impulse_at(impulse, point));
    }

    /// Changes the angular velocity at once by an angular impulse [N m s, world]. Dynamic bodies
    /// only.
    ///
    /// # Faults
    /// A number is not finite, or the angular velocity would be beyond 1e6 rad/s.
    pub fn apply_angular_impulse(&mut self, impulse: impl Into<Vec3>) {
        let _ = self
            .attempt(FrameCall::ApplyAngularImpulse, |of| of.try_apply_angular_impulse(impulse));
    }

    /// Adds a force [N, world] at the center of mass for the next step only. Dynamic bodies only.
    ///
    /// # Faults
    /// A number is not finite, or all forces for the step together accelerate the body by more than
    /// 1e10 m/s².
    pub fn add_step_force(&mut self, force: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::AddStepForce, |of| of.try_add_step_force(force));
    }

    /// Adds a force [N, world] at a point [m, world] for the next step only. Dynamic bodies only.
    ///
    /// # Faults
    /// The same faults as those of [`Self::add_step_force`] and [`Self::add_step_torque`].
    pub fn add_step_force_at(&mut self, force: impl Into<Vec3>, point: impl Into<Vec3>) {
        let _ =
            self.attempt(FrameCall::AddStepForceAt, |of| of.try_add_step_force_at(force, point));
    }

    /// Adds a torque [N m, world] for the next step only. Dynamic bodies only.
    ///
    /// # Faults
    /// A number is not finite, or all torques for the step together accelerate the body by more
    /// than 1e10 rad/s².
    pub fn add_step_torque(&mut self, torque: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::AddStepTorque, |of| of.try_add_step_torque(torque));
    }

    /// Sets the lasting force [N, world] at the center of mass. It acts in every step until it is
    /// set again. Dynamic bodies only.
    ///
    /// # Faults
    /// A number is not finite, or the force accelerates the body by more than 1e10 m/s².
    pub fn set_lasting_force(&mut self, force: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::SetLastingForce, |of| of.try_set_lasting_force(force));
    }

    /// Sets the lasting torque [N m, world]. It acts in every step until it is set again. Dynamic
    /// bodies only.
    ///
    /// # Faults
    /// A number is not finite, or the torque accelerates the body by more than 1e10 rad/s².
    pub fn set_lasting_torque(&mut self, torque: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::SetLastingTorque, |of| of.try_set_lasting_torque(torque));
    }

    /// Sets the factor by which gravity acts on the body, -1000 to 1000.
    ///
    /// # Faults
    /// The number is not from -1000 to 1000.
    pub fn set_gravity_scale(&mut self, scale: f32) {
        let _ = self.attempt(FrameCall::SetGravityScale, |of| of.try_set_gravity_scale(scale));
    }

    /// Sets the rates at which linear and angular velocity decay [1/s], 0 to 1e9.
    ///
    /// # Faults
    /// A number is not from 0 to 1e9 1/s.
    pub fn set_damping(&mut self, linear: f32, angular: f32) {
        let _ = self.attempt(FrameCall::SetDamping, |of| of.try_set_damping(linear, angular));
    }
}

impl ShapeMut<'_> {
    /// Sets the velocity of the surface along the shape, as of a conveyor belt [m/s, frame of the
    /// shape]. Touching bodies wake.
    ///
    /// # Faults
    /// A number is not finite or too large.
    pub fn set_surface_velocity(&mut self, v: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::SetSurfaceVelocity, |of| of.try_set_surface_velocity(v));
    }

    /// Sets the angular velocity of the surface about the shape's origin [rad/s, frame of the
    /// shape]. Touching bodies wake.
    ///
    /// # Faults
    /// A number is not finite or too large.
    pub fn set_surface_spin(&mut self, spin: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::SetSurfaceSpin, |of| of.try_set_surface_spin(spin));
    }
}

impl ParticleMut<'_> {
    /// Moves the particle to another position [m, world] and keeps its velocity.
    ///
    /// # Faults
    /// A number is not finite, or beyond 1e7 m.
    pub fn set_position(&mut self, x: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::SetParticlePosition, |of| of.try_set_position(x));
    }

    /// Sets the velocity of the particle [m/s, world].
    ///
    /// # Faults
    /// A number is not finite, or beyond 1e6 m/s.
    pub fn set_velocity(&mut self, v: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::SetParticleVelocity, |of| of.try_set_velocity(v));
    }

    /// Adds an impulse [N s, world]. No effect on pinned particles.
    ///
    /// # Faults
    /// A number is not finite, or the velocity would be beyond 1e6 m/s.
    pub fn apply_impulse(&mut self, impulse: impl Into<Vec3>) {
        let _ = self.attempt(FrameCall::ApplyParticleImpulse, |of| of.try_apply_impulse(impulse));
    }
}

impl LinkMut<'_> {
    /// Sets the length of the link [m] and wakes its particles, for example to reel in a rope.
    ///
    /// # Faults
    /// The length is not from 1e-5 to 1e7 m.
    pub fn set_length(&mut self, length: f32) {
        let _ = self.attempt(FrameCall::SetLinkLength, |of| of.try_set_length(length));
    }
}

impl JointMut<'_> {
    /// Drives the joint's free axis at this speed [m/s; rad/s] with at most this force [N; N m].
    /// Speed 0 makes it a brake.
    ///
    /// # Faults
    /// A number is out of range, or the joint does not have exactly one free axis.
    pub fn set_motor(&mut self, speed: f32, max_force: f32) {
        let _ = self.attempt(FrameCall::SetMotor, |of| of.try_set_motor(speed, max_force));
    }

    /// Drives the joint's free axis to this position [m; rad] with at most this force [N; N m].
    ///
    /// # Faults
    /// The same faults as those of [`Self::set_motor`].
    pub fn set_servo(&mut self, position: f32, spring: JointSpring, max_force: f32) {
        let _ =
            self.attempt(FrameCall::SetServo, |of| of.try_set_servo(position, spring, max_force));
    }

    /// Drives the rotation of the second frame in the first to `rotation`. The joint must have
    /// three free rotations: a ball joint of six axes or a cone-twist, for example a muscle of a
    /// figure. Each torque is at most `max_torque` [N m; may be ∞].
    ///
    /// # Faults
    /// The rotation is not a unit quaternion, a number is out of range, or the joint locks a
    /// rotation.
    pub fn set_target_rotation(&mut self, rotation: Quat, spring: JointSpring, max_torque: f32) {
        let _ = self.attempt(FrameCall::SetTargetRotation, |of| {
            of.try_set_target_rotation(rotation, spring, max_torque)
        });
    }

    /// Sets the minimum and maximum length of a distance joint, a rope or a spring [m].
    ///
    /// # Faults
    /// A length is not from 0 to 1e9 m, the maximum is below the minimum, or the joint has another
    /// kind.
    pub fn set_lengths(&mut self, min: f32, max: f32) {
        let _ = self.attempt(FrameCall::SetLengths, |of| of.try_set_lengths(min, max));
    }
}

impl AxisMut<'_, '_> {
    /// Drives the axis at this speed [m/s; rad/s] with at most this force [N; N m]. Speed 0 makes
    /// it a brake.
    ///
    /// # Faults
    /// A number is out of range, or the axis is a swing of a joint with a cone. Both swings of a
    /// cone change together ([`JointMut::set_axes`]).
    pub fn set_motor(&mut self, speed: f32, max_force: f32) {
        let _ = self.attempt(FrameCall::SetMotor, |of| of.try_set_motor(speed, max_force));
    }

    /// Drives the axis to this position [m; rad] with at most this force [N; N m].
    ///
    /// # Faults
    /// The same faults as those of [`Self::set_motor`].
    pub fn set_servo(&mut self, position: f32, spring: JointSpring, max_force: f32) {
        let _ =
            self.attempt(FrameCall::SetServo, |of| of.try_set_servo(position, spring, max_force));
    }
}
