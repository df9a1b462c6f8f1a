//! Bodies that break into pieces when they are hit.

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use bevy_ecs::event::EntityEvent;
use bevy_ecs::message::Message;
use bevy_ecs::reflect::ReflectComponent;
use bevy_ecs::world::World;
use bevy_math::Vec3;
use bevy_reflect::Reflect;
use bevy_reflect::prelude::ReflectDefault;
use drystone::BodyId;

use crate::body::{PhysicsBody, RigidBody};
use crate::collider::Collider;
use crate::convert::from_vec;
use crate::queue::look_again;
use crate::world::PhysicsWorld;

/// Breaks a dynamic body of one box or hull, without [`MassProperties`](crate::MassProperties),
/// into pieces when it is hit harder than one of these limits.
///
/// The pieces are new entities: see [`Fractured`].
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct Fracture {
    /// Impulse of a hit [N s], above 0; default infinite.
    pub impulse: f32,
    /// Energy of a hit [J], above 0; default infinite.
    pub energy: f32,
    /// Maximum number of pieces, 2 to 1024; default 12.
    pub pieces: u32,
    /// Number of generations that break, 1 to 16; default 1: pieces do not break again.
    pub generations: u32,
    /// Random seed of the cracks.
    pub seed: u64,
}

impl Default for Fracture {
    fn default() -> Self {
        let limit = f32::INFINITY;
        Self { impulse: limit, energy: limit, pieces: 12, generations: 1, seed: 0 }
    }
}

impl Fracture {
    /// Breaks under a hit of more than this impulse [N s].
    #[must_use]
    pub fn by_impulse(impulse: f32) -> Self {
        Self { impulse, ..Self::default() }
    }

    /// Breaks under a hit of more than this energy [J].
    #[must_use]
    pub fn by_energy(energy: f32) -> Self {
        Self { energy, ..Self::default() }
    }

    /// With this maximum number of pieces.
    #[must_use]
    pub const fn with_pieces(self, pieces: u32) -> Self {
        Self { pieces, ..self }
    }

    pub(crate) fn how(self) -> drystone::breakage::Fracture {
        let limits = drystone::breakage::Fracture::by_impulse(self.impulse);
        drystone::breakage::Fracture {
            energy: self.energy,
            pieces: self.pieces,
            generations: self.generations,
            seed: self.seed,
            ..limits
        }
    }
}

/// A body broke into pieces. Its entity lost its body and its collider: despawn it, or show
/// something else with it. The pieces have all components of bodies and colliders.
#[derive(Clone, Debug, EntityEvent, Message, PartialEq, Reflect)]
pub struct Fractured {
    /// The entity that broke.
    pub entity: Entity,
    /// The entities of its pieces.
    pub pieces: Vec<Entity>,
    /// Position of the hit [m, world].
    pub point: Vec3,
}

/// A fracture that waits for the entities of its pieces.
#[derive(Debug)]
pub(crate) struct Cracked {
    pub(crate) world: Entity,
    pub(crate) entity: Entity,
    pub(crate) pieces: Vec<BodyId>,
    pub(crate) point: drystone::Vec3,
}

impl Cracked {
    /// Makes the entities of the pieces, and tells of the fracture.
    pub(crate) fn apply(self, world: &mut World) {
        let pieces: Vec<Entity> = self
            .pieces
            .into_iter()
            .filter_map(|piece| PhysicsWorld::adopt(world, self.world, piece))
            .collect();
        if let Ok(mut broken) = world.get_entity_mut(self.entity) {
            broken.remove::<(RigidBody, Collider, Fracture)>();
            if let Some(mut record) = broken.get_mut::<PhysicsBody>() {
                record.link = None;
            }
        }
        let event = Fractured { entity: self.entity, pieces, point: from_vec(self.point) };
        world.write_message(event.clone());
        world.trigger(event);
    }
}
