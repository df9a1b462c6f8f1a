//! Public access to a body.

mod forces;

use super::World;
use super::breakage::{BondRef, bonds_of};
use super::change::mass::mass_def;
use super::saving::hashes::feed_state;
use crate::base::hash::StateHash;
use crate::base::id::{BodyId, JointId, ShapeId};
use crate::base::limits;
use crate::base::math::{Vec3, bounded};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::base::sym3::Sym3;
use crate::state::bodies::NONE;
use crate::state::bodies::body::Body;
use crate::state::def::{
    AxisLocks, BodyKind, DefError, Fracture, MassDef, position, unit, velocity, within,
};
use crate::state::tables::Tables;

/// A body, read-only.
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

    pub(super) const fn tables(&self) -> &'w Tables {
        self.tables
    }

    /// Its id.
    #[must_use]
    pub const fn id(&self) -> BodyId {
        self.id
    }

    /// The kind: static, kinematic or dynamic.
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

    /// Velocity of the body at a point [m/s, world; point in m, world].
    #[must_use]
    pub fn velocity_at(&self, point: impl Into<Vec3>) -> Vec3 {
        self.body.velocity_at(point.into() - self.body.center).bounded()
    }

    /// Its mass [kg]; 0 unless it is dynamic.
    #[must_use]
    pub const fn mass(&self) -> f32 {
        self.body.inertia.mass
    }

    /// Its inertia about the center of mass [kg m², world axes].
    #[must_use]
    pub fn inertia(&self) -> Sym3 {
        Sym3::rotated_diagonal(
            self.body.rotation * self.body.inertia.principal,
            self.body.inertia.moments,
        )
    }

    /// Its kinetic energy [J]; 0 unless it is dynamic. A value beyond f32 is given as the largest
    /// f32.
    #[must_use]
    pub fn kinetic_energy(&self) -> f32 {
        if !self.body.is_dynamic() {
            return 0.0;
        }
        let (v, w) = (self.body.v, self.body.w);
        bounded(0.5 * (self.body.inertia.mass * v.length_squared() + w.dot(self.inertia().mul(w))))
    }

    /// Its potential energy in the world's gravity [J], zero at the origin; 0 unless it is dynamic.
    #[must_use]
    pub fn potential_energy(&self) -> f32 {
        let g = self.tables.config.gravity * self.body.forces.gravity_scale;
        bounded(-self.body.inertia.mass * g.dot(self.body.center))
    }

    /// A 64-bit hash of the bits of its pose and velocity. Equal runs give equal hashes.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let mut hash = StateHash::default();
        feed_state(&mut hash, self.body);
        hash.finish()
    }

    /// True if it is left out of steps until something wakes it. Static and disabled bodies are not
    /// asleep.
    #[must_use]
    pub fn is_asleep(&self) -> bool {
        self.body.sleeps() && !self.body.record.disabled
    }

    /// False if it is disabled: see [`BodyMut::set_enabled`].
    #[must_use]
    pub const fn is_enabled(&self) -> bool {
        !self.body.record.disabled
    }

    /// Source of its mass while it is dynamic.
    #[must_use]
    pub fn mass_def(&self) -> MassDef {
        mass_def(&self.tables.bodies, self.id.index())
    }

    /// Factor by which gravity acts on it.
    #[must_use]
    pub const fn gravity_scale(&self) -> f32 {
        self.body.forces.gravity_scale
    }

    /// Rates at which linear and angular velocity decay [1/s].
    #[must_use]
    pub const fn damping(&self) -> [f32; 2] {
        [self.body.forces.linear_damping, self.body.forces.angular_damping]
    }

    /// Whether it may fall asleep.
    #[must_use]
    pub const fn can_sleep(&self) -> bool {
        self.body.can_sleep
    }

    /// Speed below which it counts as slow [m/s]; `None`: the world's default.
    #[must_use]
    pub fn sleep_speed(&self) -> Option<f32> {
        (self.body.sleep.speed >= 0.0).then_some(self.body.sleep.speed)
    }

    /// True if its state became non-finite, until it gets a new pose or velocity.
    #[must_use]
    pub const fn is_faulted(&self) -> bool {
        self.body.record.faulted
    }

    /// Its level in the contact graph: the minimum number of contacts between it and a static or
    /// kinematic body. 0 for those bodies, `None` for an unsupported body. Changes propagate by one
    /// level per step.
    #[must_use]
    pub fn support_level(&self) -> Option<u32> {
        (self.body.history.level != NONE).then_some(self.body.history.level)
    }

    /// Its shapes.
    pub fn shapes(&self) -> impl Iterator<Item = ShapeId> {
        self.body.ties.shapes.iter().map(|row| self.tables.shapes.id(*row))
    }

    /// Its joints, in no promised order. [`crate::JointRef::body_b`] tells which side of a joint it
    /// is on.
    pub fn joints(&self) -> impl Iterator<Item = JointId> {
        self.body.ties.joints.iter().filter_map(|row| self.tables.joints.rows.id_at(*row))
    }

    /// The bonds between its shapes; empty unless it is glued.
    pub fn bonds(&self) -> impl Iterator<Item = BondRef> + use<'w> {
        bonds_of(self.tables, self.id.index())
    }

    /// Its fracture settings; `None`: it does not break when hit.
    #[must_use]
    pub fn fracture(&self) -> Option<Fracture> {
        self.tables.breakage.fractures.get(&self.id.index()).copied()
    }

    /// The locked axes, along or about which it cannot move.
    #[must_use]
    pub const fn locks(&self) -> AxisLocks {
        self.body.inertia.locks
    }

    /// The user's number.
    #[must_use]
    pub const fn user_data(&self) -> u64 {
        self.body.record.user_data
    }
}

/// A body for changes. Setters check their arguments, and wake other bodies that a change affects.
///
/// Forces, torques and impulses act on enabled dynamic bodies. On static, kinematic and disabled
/// ones they have no effect and are not kept: a body that becomes dynamic later starts without
/// them.
#[derive(Debug)]
pub struct BodyMut<'w> {
    pub(super) world: &'w mut World,
    pub(super) row: u32,
    id: BodyId,
}

impl<'w> BodyMut<'w> {
    pub(super) fn new(world: &'w mut World, id: BodyId) -> Option<Self> {
        let row = world.tables.bodies.rows.row(id)?;
        Some(Self { world, row, id })
    }

    /// The body, read-only.
    #[must_use]
    pub fn get(&self) -> BodyRef<'_> {
        BodyRef {
            tables: &self.world.tables,
            body: self.world.tables.bodies.at(self.row),
            id: self.id,
        }
    }

    pub(super) fn body(&mut self) -> &mut Body {
        self.world.tables.bodies.at_mut(self.row)
    }

    /// Wakes it and its island.
    pub fn wake(&mut self) {
        self.world.sets().wake(self.row);
    }

    /// Wakes bodies that touch it, and bodies and particles joined to it, after a static or
    /// kinematic body was moved.
    pub(super) fn wake_neighbors(&mut self) {
        let tables = &self.world.tables;
        let body = tables.bodies.at(self.row);
        let touching = tables.contacts.of_body(body).map(|(row, side)| {
            let c = tables.contacts.at(row);
            if side == 0 { c.body_b } else { c.body_a }
        });
        let ends = |row: &u32| [tables.joints.at(*row).body_a, tables.joints.at(*row).body_b];
        // A coupling may connect bodies to this one through its other joint alone.
        let ids = body.ties.joints.iter().filter_map(|row| tables.joints.rows.id_at(*row));
        let coupled: Vec<u32> = ids.flat_map(|id| self.world.couplings_of(id)).collect();
        let joined = body.ties.joints.iter().chain(&coupled).flat_map(ends);
        let others: Vec<u32> = touching.chain(joined).filter(|row| *row != self.row).collect();
        for other in others {
            self.world.sets().wake(other);
        }
        let particles = &mut self.world.tables.particles;
        for i in 0..particles.attachments.len() {
            if particles.attachments[i].body == self.row {
                particles.wake_strand(particles.attachments[i].solver_row);
            }
        }
    }

    /// See [`Self::set_pose`].
    pub(super) fn try_set_pose(&mut self, pose: Pose) -> Result<(), DefError> {
        position("position", pose.position)?;
        unit("rotation", pose.rotation)?;
        self.check_free("pose")?;
        self.wake_neighbors();
        self.world.put_body(self.row, pose.position, pose.rotation.normalized());
        self.wake();
        Ok(())
    }

    /// See [`Self::set_linear_velocity`].
    pub(super) fn try_set_linear_velocity(&mut self, v: impl Into<Vec3>) -> Result<(), DefError> {
        let v = v.into();
        velocity("linear_velocity", v)?;
        let w = self.body().w;
        self.set_velocities(v, w);
        Ok(())
    }

    /// See [`Self::set_angular_velocity`].
    pub(super) fn try_set_angular_velocity(&mut self, w: impl Into<Vec3>) -> Result<(), DefError> {
        let w = w.into();
        velocity("angular_velocity", w)?;
        let v = self.body().v;
        self.set_velocities(v, w);
        Ok(())
    }

    pub(super) fn set_velocities(&mut self, v: Vec3, w: Vec3) {
        let body = self.body();
        if body.kind == BodyKind::Static {
            return;
        }
        (body.v, body.w, body.history.w_low) = (v, w, Vec3::ZERO);
        if !self.body().record.is_link {
            self.world.bring_back(self.row);
        }
        if v != Vec3::ZERO || w != Vec3::ZERO {
            if self.body().kind == BodyKind::Kinematic {
                self.wake_neighbors();
            }
            self.wake();
        }
    }

    /// See [`Self::move_to`].
    pub(super) fn try_move_to(&mut self, pose: Pose, dt: f32) -> Result<(), DefError> {
        position("position", pose.position)?;
        unit("rotation", pose.rotation)?;
        within("dt", dt, &limits::TIME_STEP)?;
        let body = self.body();
        if body.kind != BodyKind::Kinematic {
            return Ok(());
        }
        let rotation = pose.rotation.normalized();
        let target = pose.position + rotation.rotate(body.inertia.local_center);
        let turn = (rotation * body.rotation.conjugate()).to_rotation_vector();
        let (v, w) = ((target - body.center) * (1.0 / dt), turn * (1.0 / dt));
        velocity("velocity to the pose", v)?;
        velocity("angular velocity to the pose", w)?;
        self.set_velocities(v, w);
        Ok(())
    }

    /// See [`Self::set_gravity_scale`].
    pub(super) fn try_set_gravity_scale(&mut self, scale: f32) -> Result<(), DefError> {
        within("gravity_scale", scale, &limits::GRAVITY_SCALE)?;
        self.body().forces.gravity_scale = scale;
        self.wake();
        Ok(())
    }

    /// See [`Self::set_damping`].
    pub(super) fn try_set_damping(&mut self, linear: f32, angular: f32) -> Result<(), DefError> {
        within("linear_damping", linear, &limits::DAMPING)?;
        within("angular_damping", angular, &limits::DAMPING)?;
        let body = self.body();
        (body.forces.linear_damping, body.forces.angular_damping) = (linear, angular);
        Ok(())
    }

    /// Locks axes [world]. Velocity along and about locked axes becomes 0. Nothing happens to a
    /// link of an articulation.
    pub fn set_locks(&mut self, locks: AxisLocks) {
        let body = self.body();
        if body.record.is_link {
            return;
        }
        let old = core::mem::replace(&mut body.inertia.locks, locks);
        for i in 0..3 {
            if locks.linear[i] {
                body.v[i] = 0.0;
            }
            if locks.angular[i] {
                body.w[i] = 0.0;
            }
        }
        // A body with a linear lock is solved outside the trees of joints.
        self.world.tables.colors.bodies_changed |= locks.linear != old.linear;
        self.wake();
    }

    /// Sets whether it may fall asleep. `false` wakes it.
    pub fn set_can_sleep(&mut self, can_sleep: bool) {
        self.body().can_sleep = can_sleep;
        if !can_sleep {
            self.wake();
        }
    }

    /// Sets the user's number.
    pub fn set_user_data(&mut self, data: u64) {
        self.body().record.user_data = data;
    }
}
