//! State of a body within a step.

use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::state::bodies::body::Body;
use crate::step::solver_body::{SolverBody, Whitening, three, unwhitened};

/// Pose and velocities of a body [m, m/s, rad/s; world].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BodyState {
    pub(crate) center: Vec3,
    pub(crate) rotation: Quat,
    pub(crate) v: Vec3,
    pub(crate) w: Vec3,
    /// Rounding error that free rotation removed from the angular velocity [rad/s, world].
    pub(crate) w_low: Vec3,
}

impl BodyState {
    pub(crate) fn of(body: &Body) -> Self {
        let Body { center, rotation, v, w, .. } = *body;
        Self { center, rotation, v, w, w_low: Vec3::ZERO }
    }

    /// State after a time [s] at constant velocities.
    pub(crate) fn drifted(&self, time: f32) -> Self {
        Self {
            center: self.center + self.v * time,
            rotation: self.rotation.turned_by(self.w * time),
            ..*self
        }
    }

    /// State after the motion of a solver body that began in this state.
    #[inline(always)]
    pub(crate) fn after(&self, solver_body: &SolverBody, whitening: &Whitening) -> Self {
        let (alpha, s) = (whitening.alpha(), whitening.s());
        Self {
            center: self.center + three(solver_body.x) * alpha,
            rotation: self.rotation.turned_by(s.mul(three(solver_body.t))),
            v: unwhitened(self.v, solver_body, alpha),
            w: s.mul(three(solver_body.w)),
            w_low: Vec3::ZERO,
        }
    }
}
