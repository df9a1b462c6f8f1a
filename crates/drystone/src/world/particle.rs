//! Public access to particles, their links and attachments.

pub(crate) mod strand;
mod link;

pub use self::link::{LinkMut, LinkRef};

use super::World;
use crate::base::id::{BodyId, LinkId, ParticleId};
use crate::base::math::{Vec3, bounded};
use crate::state::def::DefError;
use crate::state::def::check::{finite_vec, position, velocity};
use crate::state::def::particle_def::{ParticleDef, check_mass};
use crate::state::particles::{Attachment, Link, Particle, Particles};
use crate::state::tables::Tables;

/// A particle, read-only.
#[derive(Clone, Copy, Debug)]
pub struct ParticleRef<'w> {
    tables: &'w Tables,
    particle: &'w Particle,
    id: ParticleId,
    /// Length of the last substep [s]; 0 before the first.
    h: f32,
}

impl ParticleRef<'_> {
    const fn solver_row(&self) -> usize {
        self.id.index() as usize + 1
    }

    /// Its id.
    #[must_use]
    pub const fn id(&self) -> ParticleId {
        self.id
    }

    /// Its position [m, world].
    #[must_use]
    pub fn position(&self) -> Vec3 {
        self.tables.particles.position(self.id.index() + 1)
    }

    /// Its velocity [m/s, world].
    #[must_use]
    pub fn velocity(&self) -> Vec3 {
        self.tables.particles.states[self.solver_row()].velocity()
    }

    /// Its mass [kg], also while it is pinned.
    #[must_use]
    pub const fn mass(&self) -> f32 {
        self.particle.mass
    }

    /// Distance that its center keeps from shapes [m].
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.tables.particles.x[self.solver_row()][3]
    }

    /// True if it is pinned: it moves only at its own velocity.
    #[must_use]
    pub const fn is_pinned(&self) -> bool {
        self.particle.pinned
    }

    /// True if it is at rest and left out of steps until something wakes it.
    #[must_use]
    pub const fn is_asleep(&self) -> bool {
        self.particle.frozen
    }

    /// True if its state became non-finite, until it gets a new position or velocity. Until then
    /// its links and attachment do not act.
    #[must_use]
    pub const fn is_faulted(&self) -> bool {
        self.particle.faulted
    }

    /// Number of links that end at it.
    #[must_use]
    pub const fn link_count(&self) -> u32 {
        self.particle.links
    }

    fn attachment_row(&self) -> Option<&Attachment> {
        let number = self.particle.attachment.checked_sub(1)?;
        self.tables.particles.attachments.get(number as usize)
    }

    /// The body to which it is attached, and the point [m, frame of the body's origin].
    #[must_use]
    pub fn attachment(&self) -> Option<(BodyId, Vec3)> {
        let attachment = self.attachment_row()?;
        let body = self.tables.bodies.at(attachment.body);
        Some((
            self.tables.bodies.id(attachment.body),
            attachment.anchor + body.inertia.local_center,
        ))
    }

    /// Force of its attachment on the particle in the last substep [N, world]; the body gets the
    /// opposite. Zero if it is not attached.
    #[must_use]
    pub fn attachment_force(&self) -> Vec3 {
        match self.attachment_row() {
            Some(attachment) if self.h > 0.0 => (attachment.impulse * (1.0 / self.h)).bounded(),
            _ => Vec3::ZERO,
        }
    }

    /// Kinetic energy ½ m v² [J]; 0 if it is pinned.
    #[must_use]
    pub fn kinetic_energy(&self) -> f32 {
        if self.particle.pinned {
            0.0
        } else {
            bounded(0.5 * self.particle.mass * self.velocity().length_squared())
        }
    }
}

/// A particle, for changes. A change wakes it and all particles linked to it.
#[derive(Debug)]
pub struct ParticleMut<'w> {
    pub(super) world: &'w mut World,
    solver_row: u32,
    id: ParticleId,
}

impl ParticleMut<'_> {
    /// The particle, read-only.
    #[must_use]
    pub fn get(&self) -> ParticleRef<'_> {
        let tables = &self.world.tables;
        let particle = tables.particles.at(self.solver_row);
        ParticleRef { tables, particle, id: self.id, h: tables.particles.last_h }
    }

    fn touch(&mut self) -> &mut Particle {
        let particles = &mut self.world.tables.particles;
        let particle = particles.at_mut(self.solver_row);
        particle.room = 0.0;
        if core::mem::replace(&mut particle.faulted, false) {
            // It belongs to the strand of its links again, which may be at rest.
            particles.chains_changed = true;
            particles.wake_strand(self.solver_row);
        } else {
            particles.wake(self.solver_row);
        }
        particles.at_mut(self.solver_row)
    }

    /// See [`Self::set_position`].
    pub(super) fn try_set_position(&mut self, x: impl Into<Vec3>) -> Result<(), DefError> {
        let x = x.into();
        position("position", x)?;
        self.touch();
        let place = &mut self.world.tables.particles.x[self.solver_row as usize];
        *place = [x.x, x.y, x.z, place[3]];
        Ok(())
    }

    /// See [`Self::set_velocity`].
    pub(super) fn try_set_velocity(&mut self, v: impl Into<Vec3>) -> Result<(), DefError> {
        let v = v.into();
        velocity("velocity", v)?;
        self.touch();
        self.world.tables.particles.states[self.solver_row as usize].set_velocity(v);
        Ok(())
    }

    /// See [`Self::apply_impulse`].
    pub(super) fn try_apply_impulse(&mut self, impulse: impl Into<Vec3>) -> Result<(), DefError> {
        let impulse = impulse.into();
        finite_vec("impulse", impulse)?;
        let state = &self.world.tables.particles.states[self.solver_row as usize];
        let v = state.velocity() + impulse * state.inverse_mass();
        velocity("velocity", v)?;
        self.try_set_velocity(v)
    }

    /// Sets its mass [kg].
    ///
    /// # Errors
    /// The mass is not from 1e-9 to 1e9 kg.
    pub fn set_mass(&mut self, mass: f32) -> Result<(), DefError> {
        check_mass(mass)?;
        let particle = self.touch();
        particle.mass = mass;
        let inverse = if particle.pinned { 0.0 } else { 1.0 / mass };
        self.world.tables.particles.states[self.solver_row as usize].v[3] = inverse;
        Ok(())
    }

    /// Attaches it to a point of a body [m, frame of the body's origin]. If it is elsewhere, the
    /// attachment pulls it there. It does not collide with the shapes of that body. An existing
    /// attachment is replaced.
    ///
    /// # Errors
    /// The body is not of this world, or the point is not finite.
    pub fn attach(&mut self, body: BodyId, point: impl Into<Vec3>) -> Result<(), DefError> {
        let point = point.into();
        position("point", point)?;
        let Some(row) = self.world.tables.bodies.rows.row(body) else {
            return Err(DefError::missing(
                "body",
                format_args!("BodyId {}", body.index()),
                "a body of this world",
            ));
        };
        let solver_row = self.solver_row;
        let anchor = point - self.world.tables.bodies.at(row).inertia.local_center;
        let particles = &mut self.world.tables.particles;
        particles.wake(solver_row);
        particles.attach(Attachment { solver_row, body: row, anchor, impulse: Vec3::ZERO });
        self.world.sets().wake(row);
        Ok(())
    }

    /// Detaches it from its body, and wakes both. False if it is not attached.
    pub fn detach(&mut self) -> bool {
        let particles = &mut self.world.tables.particles;
        let Some(number) = particles.at(self.solver_row).attachment.checked_sub(1) else {
            return false;
        };
        let body = particles.attachments[number as usize].body;
        particles.wake_strand(self.solver_row);
        particles.detach(self.solver_row);
        self.world.sets().wake(body);
        true
    }

    /// Pins or unpins it. An unpinned particle continues at its velocity.
    pub fn set_pinned(&mut self, pinned: bool) {
        let particle = self.touch();
        particle.pinned = pinned;
        let inverse = if pinned { 0.0 } else { 1.0 / particle.mass };
        self.world.tables.particles.states[self.solver_row as usize].v[3] = inverse;
    }
}

impl World {
    /// Adds a particle.
    ///
    /// # Errors
    /// The first field that is out of range; then nothing is added.
    pub fn add_particle(&mut self, def: ParticleDef) -> Result<ParticleId, DefError> {
        def.validate()?;
        let particle = Particle {
            mass: def.mass,
            gravity_scale: def.gravity_scale,
            damping: def.damping,
            room: 0.0,
            still_time: 0.0,
            pinned: def.pinned,
            frozen: false,
            faulted: false,
            links: 0,
            strand: 0,
            attachment: 0,
            material: def.material,
            filter: def.filter,
            colors: 0,
        };
        Ok(self.tables.particles.insert(particle, def.position, def.velocity, def.radius))
    }

    /// Removes a particle with its links and its attachment, and wakes the linked particles. False
    /// if there is no such particle.
    pub fn remove_particle(&mut self, id: ParticleId) -> bool {
        let particles = &mut self.tables.particles;
        let Some(slot) = particles.rows.row(id) else { return false };
        let solver_row = slot + 1;
        particles.wake(solver_row);
        if particles.at(solver_row).links > 0 {
            let ends_here = |link: &Link| {
                let (block, lane) = particles.block_of(link);
                block.row_a[lane] == solver_row || block.row_b[lane] == solver_row
            };
            let links = particles.links.iter().filter(|(_, link)| ends_here(link));
            let links: Vec<LinkId> = links.map(|(id, _)| id).collect();
            for link in links {
                self.remove_link(link);
            }
        }
        if let Some(mut particle) = self.particle_mut(id) {
            particle.detach();
        }
        self.tables.particles.remove(id);
        true
    }

    /// Removes the attachments of a body that is being removed.
    pub(super) fn detach_all(&mut self, body: u32) {
        let particles = &mut self.tables.particles;
        let mut i = 0;
        while let Some(attachment) = particles.attachments.get(i) {
            let solver_row = attachment.solver_row;
            if attachment.body != body {
                i += 1;
                continue;
            }
            particles.wake_strand(solver_row);
            particles.detach(solver_row);
            let id =
                particles.rows.id_at(solver_row - 1).expect("attachments are of living particles");
            self.pending.detached.push(id);
        }
    }

    /// The particle, unless it was removed.
    #[must_use]
    pub fn particle(&self, id: ParticleId) -> Option<ParticleRef<'_>> {
        let tables = &self.tables;
        let particle = tables.particles.rows.at(tables.particles.rows.row(id)?)?;
        Some(ParticleRef { tables, particle, id, h: tables.particles.last_h })
    }

    /// The particle for changes, unless it was removed.
    #[must_use]
    pub fn particle_mut(&mut self, id: ParticleId) -> Option<ParticleMut<'_>> {
        let solver_row = self.tables.particles.rows.row(id)? + 1;
        Some(ParticleMut { world: self, solver_row, id })
    }

    /// All particles in the order of their slots.
    pub fn particles(&self) -> impl Iterator<Item = ParticleRef<'_>> {
        let (tables, h) = (&self.tables, self.tables.particles.last_h);
        let rows = tables.particles.rows.iter();
        rows.map(move |(id, particle)| ParticleRef { tables, particle, id, h })
    }

    /// Maximum depth of a particle's ball in a shape [m], computed in double precision; 0 if none
    /// overlaps.
    #[must_use]
    pub fn particle_penetration(&self) -> f32 {
        crate::query::particles::penetration(&self.tables)
    }
}

impl Particles {
    /// The words of the particles for the state hash.
    pub(super) fn words(&self) -> impl Iterator<Item = (u32, Vec3, Vec3)> {
        self.rows.iter().map(|(id, _)| {
            let solver_row = id.index() + 1;
            (id.index(), self.position(solver_row), self.states[solver_row as usize].velocity())
        })
    }
}
