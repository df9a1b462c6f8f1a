//! A body as the user sees it.

use super::World;
use super::breakage::{BondRef, bonds_of};
use super::hashes::feed_state;
use crate::base::hash::StateHash;
use crate::base::id::{BodyId, JointId, ShapeId};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::base::sym3::Sym3;
use crate::state::bodies::{Body, NONE};
use crate::state::def::{
    AxisLocks, BodyKind, DefError, Fracture, at_least_zero, finite, finite_vec, position, unit,
    velocity,
};
use crate::state::tables::Tables;

/// A body, to read.
#[derive(Clone, Copy, Debug)]
pub struct BodyRef<'w> {
    tables: &'w Tables,
    body: &'w Body,
    id: BodyId,
}

impl<'w> BodyRef<'w> {
    pub(super) fn new(tables: &'w Tables, id: BodyId) -> Option<Self> {
        let row = tables.bodies.rows.row(id)?;
        Some(Self { tables, body: tables.bodies.at(row), id })
    }

    /// Its id.
    #[must_use]
    pub const fn id(&self) -> BodyId {
        self.id
    }

    /// What moves it.
    #[must_use]
    pub const fn kind(&self) -> BodyKind {
        self.body.kind
    }

    /// Position of its origin [m, world].
    #[must_use]
    pub fn position(&self) -> Vec3 {
        self.pose().position
    }

    /// Its rotation.
    #[must_use]
    pub const fn rotation(&self) -> Quat {
        self.body.rotation
    }

    /// Pose of its origin [m, world].
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.body.pose()
    }

    /// Its center of mass [m, world].
    #[must_use]
    pub const fn center_of_mass(&self) -> Vec3 {
        self.body.center
    }

    /// Velocity of its center of mass [m/s, world].
    #[must_use]
    pub const fn linear_velocity(&self) -> Vec3 {
        self.body.v
    }

    /// Its angular velocity [rad/s, world].
    #[must_use]
    pub const fn angular_velocity(&self) -> Vec3 {
        self.body.w
    }

    /// Velocity of the body's matter at a point [m/s, world; point in m, world].
    #[must_use]
    pub fn velocity_at(&self, point: impl Into<Vec3>) -> Vec3 {
        self.body.velocity_at(point.into() - self.body.center)
    }

    /// Its mass [kg]; 0 unless it is dynamic.
    #[must_use]
    pub const fn mass(&self) -> f32 {
        self.body.mass
    }

    /// Its inertia about the center of mass [kg m², world axes].
    #[must_use]
    pub fn inertia(&self) -> Sym3 {
        Sym3::rotated_diagonal(self.body.rotation * self.body.principal, self.body.moments)
    }

    /// Its kinetic energy [J]; 0 unless it is dynamic.
    #[must_use]
    pub fn kinetic_energy(&self) -> f32 {
        if !self.body.is_dynamic() {
            return 0.0;
        }
        let (v, w) = (self.body.v, self.body.w);
        0.5 * (self.body.mass * v.length_squared() + w.dot(self.inertia().mul(w)))
    }

    /// Its potential energy in the world's gravity [J], zero at the origin; 0 unless it is dynamic.
    #[must_use]
    pub fn potential_energy(&self) -> f32 {
        let g = self.tables.config.gravity * self.body.gravity_scale;
        -self.body.mass * g.dot(self.body.center)
    }

    /// 64 bits over the bits of its pose and velocity: equal where two runs are equal.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let mut hash = StateHash::default();
        feed_state(&mut hash, self.body);
        hash.finish()
    }

    /// True if it takes no part in steps until something wakes it. Static bodies are not asleep.
    #[must_use]
    pub fn is_asleep(&self) -> bool {
        self.body.is_dynamic() && !self.body.active()
    }

    /// True if its state became non-finite and it waits for a new pose or velocity.
    #[must_use]
    pub const fn is_faulted(&self) -> bool {
        self.body.faulted
    }

    /// Its level in the contact graph: how many contacts lie between it and a static or kinematic body,
    /// at least. 0 for these themselves, `None` for a body that nothing holds. Follows changes one level
    /// a step.
    #[must_use]
    pub fn support_level(&self) -> Option<u32> {
        (self.body.level != NONE).then_some(self.body.level)
    }

    /// Its shapes.
    pub fn shapes(&self) -> impl Iterator<Item = ShapeId> {
        self.body.shapes.iter().map(|row| self.tables.shapes.id(*row))
    }

    /// Its joints.
    pub fn joints(&self) -> impl Iterator<Item = JointId> {
        self.body.joints.iter().filter_map(|row| self.tables.joints.rows.id_at(*row))
    }

    /// The bonds between its shapes; none unless it is glued.
    pub fn bonds(&self) -> impl Iterator<Item = BondRef> + use<'w> {
        bonds_of(self.tables, self.id.index())
    }

    /// How it breaks where it is hit; `None`: it does not.
    #[must_use]
    pub fn fracture(&self) -> Option<Fracture> {
        self.tables.breakage.fractures.get(&self.id.index()).copied()
    }

    /// Axes it cannot move along or about.
    #[must_use]
    pub const fn locks(&self) -> AxisLocks {
        self.body.locks
    }

    /// The user's number.
    #[must_use]
    pub const fn user_data(&self) -> u64 {
        self.body.user_data
    }
}

/// A body, to change. What is set is checked; what matters to others wakes it.
#[derive(Debug)]
pub struct BodyMut<'w> {
    world: &'w mut World,
    row: u32,
    id: BodyId,
}

impl<'w> BodyMut<'w> {
    pub(super) fn new(world: &'w mut World, id: BodyId) -> Option<Self> {
        let row = world.tables.bodies.rows.row(id)?;
        Some(Self { world, row, id })
    }

    /// The body, to read.
    #[must_use]
    pub fn get(&self) -> BodyRef<'_> {
        BodyRef {
            tables: &self.world.tables,
            body: self.world.tables.bodies.at(self.row),
            id: self.id,
        }
    }

    fn body(&mut self) -> &mut Body {
        self.world.tables.bodies.at_mut(self.row)
    }

    /// Wakes it, with the island it is in.
    pub fn wake(&mut self) {
        self.world.sets().wake(self.row);
    }

    /// Wakes what touches it: a static or kinematic body was moved.
    fn wake_neighbors(&mut self) {
        let tables = &self.world.tables;
        let others: Vec<u32> = tables
            .contacts
            .of_body(tables.bodies.at(self.row))
            .map(|(row, side)| {
                let c = tables.contacts.at(row);
                if side == 0 { c.body_b } else { c.body_a }
            })
            .collect();
        for other in others {
            self.world.sets().wake(other);
        }
    }

    /// Puts its origin somewhere else at once [m, world], keeping its velocity. To push others on the
    /// way, give a kinematic body a velocity instead.
    ///
    /// # Errors
    /// A number is not finite or too large, or the rotation is not a unit quaternion; then nothing is
    /// changed.
    pub fn set_pose(&mut self, pose: Pose) -> Result<(), DefError> {
        position("position", pose.position)?;
        unit("rotation", pose.rotation)?;
        self.wake_neighbors();
        self.world.put_body(self.row, pose.position, pose.rotation.normalized());
        self.wake();
        Ok(())
    }

    /// Sets the velocity of the center of mass [m/s, world]. No effect on static bodies.
    ///
    /// # Errors
    /// A number is not finite or too large; then nothing is changed.
    pub fn set_linear_velocity(&mut self, v: impl Into<Vec3>) -> Result<(), DefError> {
        let v = v.into();
        velocity("linear_velocity", v)?;
        let w = self.body().w;
        self.set_velocities(v, w);
        Ok(())
    }

    /// Sets the angular velocity [rad/s, world]. No effect on static bodies.
    ///
    /// # Errors
    /// A number is not finite or too large; then nothing is changed.
    pub fn set_angular_velocity(&mut self, w: impl Into<Vec3>) -> Result<(), DefError> {
        let w = w.into();
        velocity("angular_velocity", w)?;
        let v = self.body().v;
        self.set_velocities(v, w);
        Ok(())
    }

    fn set_velocities(&mut self, v: Vec3, w: Vec3) {
        let body = self.body();
        if body.kind == BodyKind::Static {
            return;
        }
        body.faulted = false;
        (body.v, body.w, body.w_rest) = (v, w, Vec3::ZERO);
        if v != Vec3::ZERO || w != Vec3::ZERO {
            if self.body().kind == BodyKind::Kinematic {
                self.wake_neighbors();
            }
            self.wake();
        }
    }

    /// Gives a kinematic body the velocity that takes it to `pose` in one step of `dt` [s]; for other
    /// kinds of bodies nothing is changed.
    ///
    /// # Errors
    /// A number is not finite or too large, or `dt` is not above 0; then nothing is changed.
    pub fn move_to(&mut self, pose: Pose, dt: f32) -> Result<(), DefError> {
        position("position", pose.position)?;
        unit("rotation", pose.rotation)?;
        crate::state::def::above_zero("dt", dt)?;
        let body = self.body();
        if body.kind != BodyKind::Kinematic {
            return Ok(());
        }
        let rotation = pose.rotation.normalized();
        let target = pose.position + rotation.rotate(body.local_center);
        let turn = (rotation * body.rotation.conjugate()).to_rotation_vector();
        let (v, w) = ((target - body.center) * (1.0 / dt), turn * (1.0 / dt));
        self.set_velocities(v, w);
        Ok(())
    }

    /// Forces and impulses act on dynamic bodies; not on a faulted one, which waits for a new state.
    fn pushable(&mut self) -> bool {
        let body = self.body();
        body.is_dynamic() && !body.faulted
    }

    /// Changes the velocity of the center of mass at once by an impulse [N s, world]. Dynamic bodies
    /// only.
    ///
    /// # Errors
    /// A number is not finite; then nothing is changed.
    pub fn apply_impulse(&mut self, impulse: impl Into<Vec3>) -> Result<(), DefError> {
        let impulse = impulse.into();
        finite_vec("impulse", impulse)?;
        if self.pushable() {
            let body = self.body();
            body.v += impulse * (1.0 / body.mass);
            self.wake();
        }
        Ok(())
    }

    /// An impulse [N s, world] at a point [m, world]: changes linear and angular velocity at once.
    ///
    /// # Errors
    /// A number is not finite; then nothing is changed.
    pub fn apply_impulse_at(
        &mut self,
        impulse: impl Into<Vec3>,
        point: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let (impulse, point) = (impulse.into(), point.into());
        finite_vec("impulse", impulse)?;
        finite_vec("point", point)?;
        let arm = point - self.body().center;
        self.apply_impulse(impulse)?;
        self.apply_angular_impulse(arm.cross(impulse))
    }

    /// Changes the angular velocity at once by an angular impulse [N m s, world]. Dynamic bodies only.
    ///
    /// # Errors
    /// A number is not finite; then nothing is changed.
    pub fn apply_angular_impulse(&mut self, impulse: impl Into<Vec3>) -> Result<(), DefError> {
        let impulse = impulse.into();
        finite_vec("impulse", impulse)?;
        if self.pushable() {
            let body = self.body();
            let m = body.moments;
            let inverse = |i: f32| if i > 0.0 { 1.0 / i } else { 0.0 };
            let d = Vec3 { x: inverse(m.x), y: inverse(m.y), z: inverse(m.z) };
            let mut dw = Sym3::rotated_diagonal(body.rotation * body.principal, d).mul(impulse);
            for i in 0..3 {
                if body.locks.angular[i] {
                    dw[i] = 0.0;
                }
            }
            body.w += dw;
            self.wake();
        }
        Ok(())
    }

    /// Adds a force [N, world] at the center of mass for the next step only. Dynamic bodies only.
    ///
    /// # Errors
    /// A number is not finite; then nothing is changed.
    pub fn add_step_force(&mut self, force: impl Into<Vec3>) -> Result<(), DefError> {
        let force = force.into();
        finite_vec("force", force)?;
        if self.pushable() {
            self.body().step_force += force;
            self.wake();
        }
        Ok(())
    }

    /// Adds a force [N, world] at a point [m, world] for the next step only. Dynamic bodies only.
    ///
    /// # Errors
    /// A number is not finite; then nothing is changed.
    pub fn add_step_force_at(
        &mut self,
        force: impl Into<Vec3>,
        point: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let (force, point) = (force.into(), point.into());
        finite_vec("force", force)?;
        finite_vec("point", point)?;
        let arm = point - self.body().center;
        self.add_step_force(force)?;
        self.add_step_torque(arm.cross(force))
    }

    /// Adds a torque [N m, world] for the next step only. Dynamic bodies only.
    ///
    /// # Errors
    /// A number is not finite; then nothing is changed.
    pub fn add_step_torque(&mut self, torque: impl Into<Vec3>) -> Result<(), DefError> {
        let torque = torque.into();
        finite_vec("torque", torque)?;
        if self.pushable() {
            self.body().step_torque += torque;
            self.wake();
        }
        Ok(())
    }

    /// Sets the lasting force [N, world] at the center of mass: acts in every step until it is set
    /// anew. Dynamic bodies only.
    ///
    /// # Errors
    /// A number is not finite; then nothing is changed.
    pub fn set_lasting_force(&mut self, force: impl Into<Vec3>) -> Result<(), DefError> {
        let force = force.into();
        finite_vec("force", force)?;
        if self.pushable() {
            self.body().force = force;
            self.wake();
        }
        Ok(())
    }

    /// Sets the lasting torque [N m, world]. Dynamic bodies only.
    ///
    /// # Errors
    /// A number is not finite; then nothing is changed.
    pub fn set_lasting_torque(&mut self, torque: impl Into<Vec3>) -> Result<(), DefError> {
        let torque = torque.into();
        finite_vec("torque", torque)?;
        if self.pushable() {
            self.body().torque = torque;
            self.wake();
        }
        Ok(())
    }

    /// How many times gravity counts.
    ///
    /// # Errors
    /// The number is not finite; then nothing is changed.
    pub fn set_gravity_scale(&mut self, scale: f32) -> Result<(), DefError> {
        finite("gravity_scale", scale)?;
        self.body().gravity_scale = scale;
        self.wake();
        Ok(())
    }

    /// Rates at which linear and angular velocity decay [1/s].
    ///
    /// # Errors
    /// A number is negative or not finite; then nothing is changed.
    pub fn set_damping(&mut self, linear: f32, angular: f32) -> Result<(), DefError> {
        at_least_zero("linear_damping", linear)?;
        at_least_zero("angular_damping", angular)?;
        let body = self.body();
        (body.linear_damping, body.angular_damping) = (linear, angular);
        Ok(())
    }

    /// Locks axes [world]; velocity along them is taken out.
    pub fn set_locks(&mut self, locks: AxisLocks) {
        let body = self.body();
        body.locks = locks;
        for i in 0..3 {
            if locks.linear[i] {
                body.v[i] = 0.0;
            }
            if locks.angular[i] {
                body.w[i] = 0.0;
            }
        }
        self.wake();
    }

    /// Whether it may fall asleep; wakes it if not.
    pub fn set_can_sleep(&mut self, can_sleep: bool) {
        self.body().can_sleep = can_sleep;
        if !can_sleep {
            self.wake();
        }
    }

    /// Sets the user's number.
    pub fn set_user_data(&mut self, data: u64) {
        self.body().user_data = data;
    }
}
