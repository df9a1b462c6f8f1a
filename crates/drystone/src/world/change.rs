//! Changes of a living body: its kind, its mass, whether it is enabled, whether it sleeps.

pub(crate) mod mass;
pub(crate) mod reshape;

use self::mass::{check_energy, check_mass, principal_moments};
use super::World;
use super::body::BodyMut;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::geometry::mass::MassProperties;
use crate::state::bodies::body::Subdivision;
use crate::state::bodies::stillness::Stillness;
use crate::state::def::{
    BodyKind, DefError, MassDef, at_least_zero, position, shape_suits, unit, velocity,
};
use crate::state::tables::Tables;
use crate::step::broadphase::may_meet;
use crate::step::sleep::{freeze, split_island};

impl BodyMut<'_> {
    /// Changes the kind of the body. The body keeps its pose, shapes, contacts and joints. It wakes
    /// together with its neighbors: bodies and particles that touch it or are joined to it. A body
    /// that becomes static loses its velocity; other bodies keep theirs.
    ///
    /// A body that becomes dynamic has the mass of [`super::BodyRef::mass_def`]. Contacts end where
    /// neither body is dynamic. Joints between two bodies that are not dynamic are idle until one
    /// becomes dynamic. Bonds and [`crate::breakage::Fracture`] are idle while their body is not
    /// dynamic.
    ///
    /// # Errors
    /// A shape does not suit the new kind: a half-space needs a static body, a mesh a static or
    /// kinematic one. For a body that becomes dynamic: its mass or kinetic energy is out of range.
    /// Then nothing is changed.
    pub fn set_kind(&mut self, kind: BodyKind) -> Result<(), DefError> {
        let (row, body) = (self.row, self.world.tables.bodies.at(self.row));
        if kind == body.kind {
            return Ok(());
        }
        self.check_free("kind")?;
        let body = self.world.tables.bodies.at(row);
        for shape in &body.ties.shapes {
            shape_suits(kind, &self.world.tables.shapes.at(*shape).shape)?;
        }
        let mut mass = None;
        if kind == BodyKind::Dynamic {
            let made = self.world.mass_from(row, self.get().mass_def())?;
            check_energy(made.mass, principal_moments(&made).0, [body.v, body.w])?;
            mass = Some(made);
        }
        self.wake();
        self.wake_neighbors();
        self.world.change_kind(row, kind, mass.as_ref());
        Ok(())
    }

    /// Sets the mass of the body and wakes it. The shapes stay in place. Each point of the body
    /// keeps its velocity, even if the center of mass moves. A body that is not dynamic has this
    /// mass once it becomes dynamic.
    ///
    /// # Errors
    /// A number, or the mass computed from the shapes, is out of range; an exact mass is given for
    /// a body that breaks; the velocities or lasting forces are out of range with that mass. Then
    /// nothing is changed.
    pub fn set_mass(&mut self, mass: MassDef) -> Result<(), DefError> {
        mass.validate()?;
        self.check_free("mass")?;
        let row = self.row;
        let breaks = self.world.tables.breakage.breaks(row);
        if breaks && matches!(mass, MassDef::Exact { .. }) {
            let allowed = "computed from the shapes, or their total, for a body that breaks";
            return Err(DefError::unsuitable("mass", "an exact mass", allowed));
        }
        let mut made = None;
        if self.body().is_dynamic() {
            let props = self.world.mass_from(row, mass)?;
            self.check_mass(&props)?;
            made = Some(props);
        }
        let bodies = &mut self.world.tables.bodies;
        bodies.at_mut(row).inertia.source = mass.into();
        bodies.given.remove(&row);
        if let MassDef::Exact { mass, center, inertia } = mass {
            bodies.given.insert(row, MassProperties { mass, center, inertia });
        }
        if let Some(made) = made {
            let more = made.mass - self.body().inertia.mass;
            self.world.set_mass(row, &made);
            self.world.follow_weight(row, more);
            self.world.refresh_extent(row);
            self.world.refresh_bounds(row);
            self.wake();
        }
        Ok(())
    }

    /// Checks that the body's velocities and lasting forces are in range with another mass.
    fn check_mass(&mut self, mass: &MassProperties) -> Result<(), DefError> {
        let (moments, principal) = principal_moments(mass);
        check_mass(mass.mass, moments)?;
        let body = self.body();
        check_energy(mass.mass, moments, [body.v, body.w])?;
        let (force, torque) = (
            body.forces.force + body.forces.step_force,
            body.forces.torque + body.forces.step_torque,
        );
        let now = (body.inertia.mass, body.inertia.moments, body.inertia.principal);
        (body.inertia.mass, body.inertia.moments, body.inertia.principal) =
            (mass.mass, moments, principal);
        let checked = self.check_forces(force, torque);
        let body = self.body();
        (body.inertia.mass, body.inertia.moments, body.inertia.principal) = now;
        checked
    }

    /// Takes the body out of the world (false), or puts it back (true).
    ///
    /// A disabled body keeps its id, pose, velocities, shapes and joints, and all of them can be
    /// changed. It does not move, touches nothing, and is invisible to queries. It is left out of
    /// all sums, and its joints and attachments are idle. Its contacts end, and its neighbors wake.
    /// When it is enabled again, it continues in the state that it had. A link of an articulation
    /// takes all links with it.
    pub fn set_enabled(&mut self, enabled: bool) {
        let of = self.world.tables.articulations.of_body(self.row);
        let Some(articulation) = of.filter(|_| self.body().record.is_link) else {
            return self.set_enabled_alone(enabled);
        };
        for row in self.world.bodies_of_articulation(articulation) {
            let id = self.world.tables.bodies.id(row);
            if let Some(mut body) = self.world.body_mut(id) {
                body.set_enabled_alone(enabled);
            }
        }
    }

    fn set_enabled_alone(&mut self, enabled: bool) {
        if enabled != self.body().record.disabled {
            return;
        }
        let (row, id) = (self.row, self.get().id());
        if enabled {
            let body = self.body();
            body.record.disabled = false;
            if body.record.faulted {
                return;
            }
            let moves = body.v != Vec3::ZERO || body.w != Vec3::ZERO;
            let is_idle = body.kind == BodyKind::Kinematic && !moves;
            self.world.put_in(row);
            if !is_idle {
                self.wake();
            }
            // Wakes everything that is joined to it, including particles.
            self.wake_neighbors();
            // A body that is put back awake causes no wake event.
            self.world.pending.wake.retain(|body| *body != id);
            return;
        }
        self.wake();
        self.wake_neighbors();
        self.body().record.disabled = true;
        if !self.body().out {
            self.world.sets().take_out(row);
            self.world.take_out(row);
            // Particles at rest on it check their contacts again.
            self.world.tables.bounds.fixed_changes += 1;
        }
    }

    /// Puts the body to sleep now, at any place and any speed. All dynamic bodies connected with it
    /// by contacts and joints sleep too. They stop, and sleep until something wakes them, including
    /// bodies with `can_sleep` false. No effect on bodies that are not dynamic.
    pub fn sleep(&mut self) {
        let row = self.row;
        let body = self.body();
        if !body.active() || !body.is_dynamic() {
            return;
        }
        let island = body.sleep.island;
        if self.world.tables.islands.wake_alone {
            let ctx = self.world.context();
            freeze::note_loads(&ctx, &[row], &mut self.world.sets());
            self.world.sets().put_to_sleep(&[row]);
            return;
        }
        let step = self.world.tables.steps;
        if self.world.tables.islands.rows[island as usize].cut {
            split_island(island, step, &mut self.world.sets());
        }
        let Tables { islands, bodies, .. } = &mut self.world.tables;
        let members = islands.members(bodies.at(row).sleep.island, bodies);
        for row in &members {
            // A body with still time 0 is not woken by existing contacts, like a body that is added
            // asleep.
            bodies.at_mut(*row).sleep.still_time = 0.0;
        }
        self.world.sets().put_to_sleep(&members);
        self.world.tables.islands.give_back(members);
    }

    /// Sets the speed below which the body counts as slow [m/s]; `None`: the world's default.
    ///
    /// # Errors
    /// The speed is below 0 or not finite; then nothing is changed.
    pub fn set_sleep_speed(&mut self, speed: Option<f32>) -> Result<(), DefError> {
        if let Some(speed) = speed {
            at_least_zero("sleep_speed", speed)?;
        }
        self.body().sleep.speed = speed.unwrap_or(-1.0);
        Ok(())
    }

    /// Corrects the state of the body, for example to that of a server: pose of the origin [m,
    /// world], linear and angular velocity [m/s, rad/s, world]. If all numbers equal the current
    /// ones, nothing is changed and nothing wakes. Returns true if something was changed. For a
    /// static body only the pose is used.
    ///
    /// # Errors
    /// A number is not finite or too large, or the rotation is not a unit quaternion. Then nothing
    /// is changed.
    pub fn correct_state(
        &mut self,
        pose: Pose,
        linear: impl Into<Vec3>,
        angular: impl Into<Vec3>,
    ) -> Result<bool, DefError> {
        let (linear, angular) = (linear.into(), angular.into());
        position("position", pose.position)?;
        unit("rotation", pose.rotation)?;
        velocity("linear_velocity", linear)?;
        velocity("angular_velocity", angular)?;
        // A rotation that a step computed is stored unchanged. Normalizing it again could change
        // its last bits, and then each correction with the same numbers would count as a change.
        let square: f32 = pose.rotation.to_array().iter().map(|x| x * x).sum();
        let exact = (square - 1.0).abs() < 1.0e-6;
        let rotation = if exact { pose.rotation } else { pose.rotation.normalized() };
        let row = self.row;
        let body = self.body();
        let has_velocity = body.kind != BodyKind::Static;
        let center = Pose { rotation, ..pose }.point(body.inertia.local_center);
        let stays = body.pose() == pose || (body.center == center && body.rotation == rotation);
        let moved = body.record.faulted || !stays;
        let sped = has_velocity && (body.v != linear || body.w != angular);
        if moved {
            self.wake_neighbors();
            self.world.put_body(row, pose.position, rotation);
            self.wake();
        }
        if sped {
            self.set_velocities(linear, angular);
        }
        Ok(moved || sped)
    }
}

impl World {
    /// Changes the kind of a body; `mass` is its mass if it becomes dynamic.
    fn change_kind(&mut self, row: u32, kind: BodyKind, mass: Option<&MassProperties>) {
        let ctx = self.context();
        let was_fixed = self.tables.bodies.at(row).kind == BodyKind::Static;
        if was_fixed != (kind == BodyKind::Static) {
            self.end_seen_otherwise(row);
        }
        let body = self.tables.bodies.at_mut(row);
        if kind == BodyKind::Static {
            (body.v, body.w) = (Vec3::ZERO, Vec3::ZERO);
        }
        (body.forces.step_force, body.forces.step_torque, body.history.w_low) = Default::default();
        (body.history.inertia_factor, body.history.load, body.history.subdivision) =
            (1.0, 0.0, Subdivision::Whole);
        body.history.last_h = if ctx.is_soft { self.last_h } else { 0.0 };
        body.flies = false;
        (body.inertia.mass, body.inertia.moments, body.inertia.principal) =
            (0.0, Vec3::ZERO, Quat::IDENTITY);
        self.tables.bodies.tracks[row as usize].ahead = 0;
        self.tables.bodies.stillness[row as usize] = Stillness::default();
        self.sets().set_kind(row, kind);
        if let Some(mass) = mass {
            self.set_mass(row, mass);
        }
        self.follow_breakage(row);
        self.end_forbidden(row);
        self.follow_kind_of(row);
        self.refresh_extent(row);
        if was_fixed == (kind == BodyKind::Static) {
            self.refresh_bounds(row);
            return;
        }
        self.tables.bodies.at_mut(row).room = 0.0;
        for shape in self.tables.bodies.at(row).ties.shapes.clone() {
            let tables = &mut self.tables;
            tables.bounds.remove(shape, &tables.shapes);
            tables.shapes.at_mut(shape).fixed = !was_fixed;
            self.enter_bounds(shape);
        }
    }

    /// Ends the contacts of a body that its kind, filter or joints no longer allow, and wakes the
    /// touched bodies.
    pub(super) fn end_forbidden(&mut self, row: u32) {
        self.end_contacts_where(row, |Tables { bodies, shapes, joints, .. }, c| {
            !may_meet(bodies, joints, shapes.at(c.shape_a), shapes.at(c.shape_b))
        });
    }

    /// Ends the sensor overlaps whose visibility depends on whether the body is static. Call it
    /// while the body still has its old kind, which determines the exits to report. A sensor that
    /// still detects the body reports an enter event in the next step.
    fn end_seen_otherwise(&mut self, row: u32) {
        self.end_contacts_where(row, |Tables { bodies, shapes, .. }, c| {
            let other = if c.body_a == row { c.body_b } else { c.body_a };
            let (a, b) = (shapes.at(c.shape_a), shapes.at(c.shape_b));
            let seen = |fixed| (a.sees(b, fixed), b.sees(a, fixed));
            c.sensor && bodies.at(other).kind == BodyKind::Static && seen(true) != seen(false)
        });
    }

    /// Clears the impulses of joints that no longer act on a dynamic body. Updates couplings, which
    /// act between bodies of which at least one is dynamic.
    fn follow_kind_of(&mut self, row: u32) {
        let joints: Vec<u32> = self.tables.bodies.at(row).ties.joints.to_vec();
        for joint in joints {
            let tables = &mut self.tables;
            let Some(id) = tables.joints.rows.id_at(joint) else { continue };
            if !tables.joints.at(joint).place.is_somewhere() {
                tables.joints.at_mut(joint).forget();
            }
            for coupling in self.each_coupling_of(id) {
                self.follow_joints(coupling, true);
            }
        }
    }
}
