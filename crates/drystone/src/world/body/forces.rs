//! Impulses and forces on a body.

use crate::base::limits;
use crate::base::math::Vec3;
use crate::state::def::{DefError, all_within, finite_vec, position};
use crate::world::body::BodyMut;

impl<'w> BodyMut<'w> {
    /// True for an enabled dynamic body. Forces and impulses act on no other body.
    fn pushable(&mut self) -> bool {
        let body = self.body();
        body.is_dynamic() && !body.out
    }

    /// The body's velocities after these impulses [N s, N m s, world].
    ///
    /// # Errors
    /// The resulting velocity is out of range.
    fn after_impulses(&mut self, linear: Vec3, angular: Vec3) -> Result<[Vec3; 2], DefError> {
        let body = self.body();
        let v = body.v + linear * (1.0 / body.inertia.mass);
        // An impulse without a turning part leaves the bits of the angular velocity unchanged.
        let turns = angular != Vec3::ZERO;
        let w = if turns { body.w + body.turn_by(angular) } else { body.w };
        let fits = |v: Vec3| v.to_array().into_iter().all(|x| limits::SPEED.admits(x));
        if fits(v) && fits(w) {
            return Ok([v, w]);
        }
        let impulse = if fits(v) { angular } else { linear };
        let allowed = "an impulse that leaves the body slower than 1e6 m/s and 1e6 rad/s";
        Err(DefError::of_vec("impulse", impulse, allowed))
    }

    /// See [`Self::apply_impulse`].
    pub(in crate::world) fn try_apply_impulse(
        &mut self,
        impulse: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let impulse = impulse.into();
        finite_vec("impulse", impulse)?;
        self.apply_impulses(impulse, Vec3::ZERO)
    }

    /// See [`Self::apply_impulse_at`].
    pub(in crate::world) fn try_apply_impulse_at(
        &mut self,
        impulse: impl Into<Vec3>,
        point: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let (impulse, point) = (impulse.into(), point.into());
        finite_vec("impulse", impulse)?;
        position("point", point)?;
        let arm = point - self.body().center;
        self.apply_impulses(impulse, arm.cross(impulse))
    }

    /// See [`Self::apply_angular_impulse`].
    pub(in crate::world) fn try_apply_angular_impulse(
        &mut self,
        impulse: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let impulse = impulse.into();
        finite_vec("impulse", impulse)?;
        self.apply_impulses(Vec3::ZERO, impulse)
    }

    fn apply_impulses(&mut self, linear: Vec3, angular: Vec3) -> Result<(), DefError> {
        if self.pushable() {
            let [v, w] = self.after_impulses(linear, angular)?;
            let body = self.body();
            (body.v, body.w) = (v, w);
            self.wake();
        }
        Ok(())
    }

    /// Checks that a force [N] and a torque [N m] accelerate it within the limits of computation.
    pub(in crate::world) fn check_forces(
        &mut self,
        force: Vec3,
        torque: Vec3,
    ) -> Result<(), DefError> {
        let body = self.body();
        let (linear, angular) = (force * (1.0 / body.inertia.mass), body.turn_by(torque));
        all_within("force over mass", linear, &limits::ACCELERATION)?;
        all_within("torque over moment of inertia", angular, &limits::ACCELERATION)
    }

    /// See [`Self::add_step_force`].
    pub(in crate::world) fn try_add_step_force(
        &mut self,
        force: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let force = force.into();
        finite_vec("force", force)?;
        self.add_step_forces(force, Vec3::ZERO)
    }

    /// See [`Self::add_step_force_at`].
    pub(in crate::world) fn try_add_step_force_at(
        &mut self,
        force: impl Into<Vec3>,
        point: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let (force, point) = (force.into(), point.into());
        finite_vec("force", force)?;
        position("point", point)?;
        let arm = point - self.body().center;
        self.add_step_forces(force, arm.cross(force))
    }

    /// See [`Self::add_step_torque`].
    pub(in crate::world) fn try_add_step_torque(
        &mut self,
        torque: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let torque = torque.into();
        finite_vec("torque", torque)?;
        self.add_step_forces(Vec3::ZERO, torque)
    }

    fn add_step_forces(&mut self, force: Vec3, torque: Vec3) -> Result<(), DefError> {
        if self.pushable() {
            let body = self.body();
            let (force, torque) =
                (body.forces.step_force + force, body.forces.step_torque + torque);
            self.check_forces(force, torque)?;
            let body = self.body();
            (body.forces.step_force, body.forces.step_torque) = (force, torque);
            self.wake();
        }
        Ok(())
    }

    /// See [`Self::set_lasting_force`].
    pub(in crate::world) fn try_set_lasting_force(
        &mut self,
        force: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let force = force.into();
        finite_vec("force", force)?;
        if self.pushable() {
            self.check_forces(force, Vec3::ZERO)?;
            self.body().forces.force = force;
            self.wake();
        }
        Ok(())
    }

    /// See [`Self::set_lasting_torque`].
    pub(in crate::world) fn try_set_lasting_torque(
        &mut self,
        torque: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let torque = torque.into();
        finite_vec("torque", torque)?;
        if self.pushable() {
            self.check_forces(Vec3::ZERO, torque)?;
            self.body().forces.torque = torque;
            self.wake();
        }
        Ok(())
    }
}
