//! Ropes and cloths of particles.

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use bevy_ecs::query::{Has, With};
use bevy_ecs::reflect::ReflectComponent;
use bevy_ecs::system::{Local, Query, Res, ResMut};
use bevy_math::Vec3;
use bevy_reflect::Reflect;
use bevy_reflect::prelude::ReflectDefault;
use drystone::particle::{ClothDef, ParticleDef, ParticleId, RopeDef, Strand};
use drystone::{DefError, World};

use crate::body::BodyLink;
use crate::convert::{from_vec, to_vec};
use crate::events::PhysicsFault;
use crate::queue::{Pending, look_at_strand, strand_gone};
use crate::sync::{Records, SyncState};
use crate::world::{DefaultPhysicsWorld, InWorld, PhysicsOrder, PhysicsWorld, key};

/// A rope of particles, which bodies touch and pull. Insert another value to make it anew.
///
/// Its particles are in [`ParticlePositions`]. Tears and other settings: by the engine's world,
/// with [`PhysicsStrand::particles`].
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(immutable, on_insert = look_at_strand, on_remove = look_at_strand)]
#[require(PhysicsStrand, ParticlePositions)]
#[reflect(Component)]
pub struct Rope {
    /// Position of the first end [m, world].
    pub from: Vec3,
    /// Position of the last end [m, world].
    pub to: Vec3,
    /// Number of links, 1 to 1,000,000.
    pub links: usize,
    /// Length [m]; `None`, the default: the distance of its ends.
    pub length: Option<f32>,
    /// Total mass [kg]; default 1.
    pub mass: f32,
    /// Radius [m]; default 0.02.
    pub radius: f32,
    /// Its first and its last end; default free.
    pub ends: [RopeEnd; 2],
    /// Elongation at which a link tears, as a part of its length; `None`, the default: never.
    pub tear_strain: Option<f32>,
}

/// An end of a rope.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Default)]
pub enum RopeEnd {
    /// It moves.
    #[default]
    Free,
    /// It stays where it is.
    Pinned,
    /// It is tied to the body of this entity, at the place of the end when the rope is made. Until
    /// the body is there, there is no rope.
    Attached(Entity),
}

impl Rope {
    /// A rope between two points [m, world].
    #[must_use]
    pub const fn between(from: Vec3, to: Vec3, links: usize) -> Self {
        let ends = [RopeEnd::Free, RopeEnd::Free];
        Self { from, to, links, length: None, mass: 1.0, radius: 0.02, ends, tear_strain: None }
    }

    /// With these ends.
    #[must_use]
    pub const fn with_ends(self, first: RopeEnd, last: RopeEnd) -> Self {
        Self { ends: [first, last], ..self }
    }

    /// With this total mass [kg].
    #[must_use]
    pub const fn with_mass(self, mass: f32) -> Self {
        Self { mass, ..self }
    }

    fn add(&self, world: &mut World, bodies: [Option<BodyLink>; 2]) -> Result<Strand, DefError> {
        let mut def = RopeDef::between(to_vec(self.from), to_vec(self.to), self.links);
        (def.length, def.mass, def.tear_strain) = (self.length, self.mass, self.tear_strain);
        def.particle = ParticleDef { radius: self.radius, ..def.particle };
        def.pinned = self.ends.map(|end| end == RopeEnd::Pinned);
        let strand = world.add_rope(def)?;
        let ends = [strand.particles.first(), strand.particles.last()];
        for (link, (end, at)) in bodies.into_iter().zip(ends.into_iter().zip([def.from, def.to])) {
            let Some((BodyLink { body, .. }, end)) = link.zip(end) else { continue };
            let Some(pose) = world.body(body).map(|body| body.pose()) else { continue };
            if let Some(mut particle) = world.particle_mut(*end) {
                particle.attach(body, pose.local_point(at))?;
            }
        }
        Ok(strand)
    }
}

/// A rectangle of cloth. Insert another value to make it anew.
///
/// Its particles are in [`ParticlePositions`], row by row along the first side.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(immutable, on_insert = look_at_strand, on_remove = look_at_strand)]
#[require(PhysicsStrand, ParticlePositions)]
#[reflect(Component)]
pub struct Cloth {
    /// Position of the first corner [m, world].
    pub corner: Vec3,
    /// The two sides, from the first corner [m, world].
    pub sides: [Vec3; 2],
    /// Number of squares along each side, each 1 to 4,000.
    pub squares: [usize; 2],
    /// Total mass [kg]; default 1.
    pub mass: f32,
    /// Radius of the particles [m]; default 0.02.
    pub radius: f32,
    /// Whether the corners at the start and the end of the first row, and of the last row, are
    /// pinned; default none.
    pub pinned: [bool; 4],
    /// Elongation at which a thread tears, as a part of its length; `None`, the default: never.
    pub tear_strain: Option<f32>,
}

impl Cloth {
    /// A cloth from a corner along two sides [m, world].
    #[must_use]
    pub const fn new(corner: Vec3, sides: [Vec3; 2], squares: [usize; 2]) -> Self {
        let pinned = [false; 4];
        Self { corner, sides, squares, mass: 1.0, radius: 0.02, pinned, tear_strain: None }
    }

    /// With these corners pinned: see [`Self::pinned`].
    #[must_use]
    pub const fn with_pinned(self, pinned: [bool; 4]) -> Self {
        Self { pinned, ..self }
    }

    fn add(&self, world: &mut World) -> Result<Strand, DefError> {
        let mut def = ClothDef::new(to_vec(self.corner), self.sides.map(to_vec), self.squares);
        (def.mass, def.tear_strain) = (self.mass, self.tear_strain);
        def.particle = ParticleDef { radius: self.radius, ..def.particle };
        let strand = world.add_cloth(def)?;
        let (row, all) = (self.squares[0] + 1, strand.particles.len());
        let corners = [0, row - 1, all - row, all - 1];
        for (corner, is_pinned) in corners.into_iter().zip(self.pinned) {
            let particle = strand.particles.get(corner);
            if let Some(mut particle) = particle.and_then(|id| world.particle_mut(*id)) {
                particle.set_pinned(is_pinned);
            }
        }
        Ok(strand)
    }
}

/// The particles of a rope or a cloth after the last step [m, world], as the plugin writes them.
#[derive(Clone, Component, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct ParticlePositions(pub Vec<Vec3>);

/// The particles of an entity in its world, kept by the plugin.
#[derive(Component, Debug, Default)]
#[component(on_remove = strand_gone, clone_behavior = Ignore)]
pub struct PhysicsStrand {
    pub(crate) world: Option<Entity>,
    pub(crate) particles: Vec<ParticleId>,
}

impl PhysicsStrand {
    /// The particles in the world: a rope's from its first end, a cloth's row by row.
    #[must_use]
    pub fn particles(&self) -> &[ParticleId] {
        &self.particles
    }
}

/// All components that describe a strand.
type StrandData = (
    Option<&'static Rope>,
    Option<&'static Cloth>,
    Option<&'static InWorld>,
    Option<&'static PhysicsOrder>,
    Has<PhysicsStrand>,
);

/// The system that makes and removes ropes and cloths, after the bodies.
pub(crate) fn read_strands(
    data: Query<'_, '_, StrandData>,
    every: Query<'_, '_, Entity, With<PhysicsStrand>>,
    mut strands: Query<'_, '_, &mut PhysicsStrand>,
    mut records: Records<'_, '_>,
    mut pending: ResMut<'_, Pending>,
    (state, default): (Res<'_, SyncState>, Res<'_, DefaultPhysicsWorld>),
    mut waiting: Local<'_, Vec<Entity>>,
) {
    pending.gone_strands.sort_unstable();
    for (world, particle) in pending.gone_strands.drain(..) {
        if let Ok(mut physics) = records.worlds.get_mut(world) {
            physics.world.remove_particle(particle);
        }
    }
    let mut dirty = core::mem::take(&mut pending.strands);
    if state.has_new_bodies {
        dirty.append(&mut waiting);
    }
    if state.has_other_worlds {
        // In a world that was put back, its particles may be there.
        let is_lost = |entity: &Entity| {
            let Ok(strand) = strands.get(*entity) else { return true };
            let world = strand.world.and_then(|world| records.worlds.get(world).ok());
            let first = strand.particles.first();
            world.zip(first).is_none_or(|(physics, id)| physics.world.particle(*id).is_none())
        };
        dirty.extend(every.iter().filter(is_lost));
    }
    let order = |entity| key(data.get(entity).ok().and_then(|(.., order, _)| order), entity);
    let mut dirty: Vec<((u64, u32), Entity)> =
        dirty.into_iter().map(|entity| (order(entity), entity)).collect();
    dirty.sort_unstable();
    dirty.dedup();
    for (_, entity) in dirty {
        let Ok((rope, cloth, given, ..)) = data.get(entity) else { continue };
        let Ok(mut strand) = strands.get_mut(entity) else { continue };
        let old = core::mem::take(&mut strand.particles);
        if let Some(Ok(mut physics)) =
            strand.world.take().map(|world| records.worlds.get_mut(world))
        {
            old.into_iter().for_each(|particle| {
                physics.world.remove_particle(particle);
            });
        }
        let world = given.map_or(default.0, |world| world.0);
        let ends = rope.map_or([RopeEnd::Free; 2], |rope| rope.ends);
        let bodies = ends.map(|end| match end {
            RopeEnd::Attached(body) => {
                let link = records.bodies.get(body).ok().and_then(|record| record.link);
                Some(link.filter(|link| link.world == world))
            }
            RopeEnd::Free | RopeEnd::Pinned => None,
        });
        let is_missing = bodies.contains(&Some(None));
        let Ok(mut physics) = records.worlds.get_mut(world) else { continue };
        if is_missing {
            waiting.push(entity);
            continue;
        }
        let made = match (rope, cloth) {
            (Some(rope), _) => rope.add(&mut physics.world, bodies.map(Option::flatten)),
            (None, Some(cloth)) => cloth.add(&mut physics.world),
            (None, None) => continue,
        };
        match made {
            Ok(made) => (strand.world, strand.particles) = (Some(world), made.particles),
            Err(error) => {
                let text = error.to_string();
                PhysicsFault { world, entity: Some(entity), text }.report(&mut records.faults);
            }
        }
    }
}

/// The system that writes the positions of particles, where they move.
pub(crate) fn write_strands(
    worlds: Query<'_, '_, &PhysicsWorld>,
    mut strands: Query<'_, '_, (&PhysicsStrand, &mut ParticlePositions)>,
) {
    for (strand, mut positions) in &mut strands {
        let Some(Ok(physics)) = strand.world.map(|world| worlds.get(world)) else { continue };
        let particle = |id: &ParticleId| physics.world.particle(*id);
        let is_new = positions.0.len() != strand.particles.len();
        let moves = || strand.particles.iter().filter_map(particle).any(|p| !p.is_asleep());
        if is_new || moves() {
            let found = strand.particles.iter().filter_map(particle);
            let found: Vec<Vec3> = found.map(|p| from_vec(p.position())).collect();
            if positions.0 != found {
                positions.0 = found;
            }
        }
    }
}
