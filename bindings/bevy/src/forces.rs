//! Forces and impulses, applied at the beginning of the next step.

use bevy_ecs::component::Component;
use bevy_ecs::query::QueryData;
use bevy_math::Vec3;
use drystone::BodyMut;

use crate::body::{AngularVelocity, LinearVelocity};
use crate::convert::to_vec;

/// Forces and impulses on dynamic bodies, as the data of a query:
///
/// ```
/// use bevy_drystone::{Forces, RigidBody};
/// use bevy_ecs::prelude::*;
/// use bevy_math::Vec3;
///
/// fn lift(mut bodies: Query<Forces, With<RigidBody>>) {
///     for mut body in &mut bodies {
///         body.apply_force(Vec3::Y * 100.0);
///     }
/// }
/// ```
///
/// They act in the next step, and wake the body. Forces act for that step only: apply them in
/// `FixedUpdate`. They are applied after the velocities that the user wrote.
#[derive(Debug, QueryData)]
#[query_data(mutable)]
pub struct Forces {
    pending: &'static mut PendingForces,
    linear: &'static LinearVelocity,
    angular: &'static AngularVelocity,
}

/// Forces and impulses that wait for the next step.
#[derive(Component, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct PendingForces {
    pub(crate) pushes: Vec<Push>,
}

/// A force or an impulse [N, N m, N s, N m s, world].
#[derive(Clone, Copy, Debug)]
pub(crate) enum Push {
    Force(Vec3),
    ForceAt(Vec3, Vec3),
    Torque(Vec3),
    Impulse(Vec3),
    ImpulseAt(Vec3, Vec3),
    AngularImpulse(Vec3),
    Wake,
}

impl Push {
    /// The engine reports a push that is out of range as a fault.
    pub(crate) fn apply(self, body: &mut BodyMut<'_>) {
        match self {
            Self::Force(force) => body.add_step_force(to_vec(force)),
            Self::ForceAt(force, point) => body.add_step_force_at(to_vec(force), to_vec(point)),
            Self::Torque(torque) => body.add_step_torque(to_vec(torque)),
            Self::Impulse(impulse) => body.apply_impulse(to_vec(impulse)),
            Self::ImpulseAt(impulse, at) => body.apply_impulse_at(to_vec(impulse), to_vec(at)),
            Self::AngularImpulse(impulse) => body.apply_angular_impulse(to_vec(impulse)),
            Self::Wake => body.wake(),
        }
    }
}

impl ForcesItem<'_, '_> {
    fn push(&mut self, push: Push) {
        self.pending.pushes.push(push);
    }

    /// Adds a force at the center of mass [N, world].
    pub fn apply_force(&mut self, force: Vec3) {
        self.push(Push::Force(force));
    }

    /// Adds a force [N, world] at a point [m, world].
    pub fn apply_force_at_point(&mut self, force: Vec3, point: Vec3) {
        self.push(Push::ForceAt(force, point));
    }

    /// Adds a torque [N m, world].
    pub fn apply_torque(&mut self, torque: Vec3) {
        self.push(Push::Torque(torque));
    }

    /// Adds an impulse at the center of mass [N s, world].
    pub fn apply_linear_impulse(&mut self, impulse: Vec3) {
        self.push(Push::Impulse(impulse));
    }

    /// Adds an impulse [N s, world] at a point [m, world].
    pub fn apply_linear_impulse_at_point(&mut self, impulse: Vec3, point: Vec3) {
        self.push(Push::ImpulseAt(impulse, point));
    }

    /// Adds an angular impulse [N m s, world].
    pub fn apply_angular_impulse(&mut self, impulse: Vec3) {
        self.push(Push::AngularImpulse(impulse));
    }

    /// Wakes the body.
    pub fn wake(&mut self) {
        self.push(Push::Wake);
    }

    /// Velocity of the center of mass after the last step, or as the user wrote it since [m/s,
    /// world].
    #[must_use]
    pub fn linear_velocity(&self) -> Vec3 {
        self.linear.0
    }

    /// Angular velocity after the last step, or as the user wrote it since [rad/s, world].
    #[must_use]
    pub fn angular_velocity(&self) -> Vec3 {
        self.angular.0
    }
}
