//! Worlds as components, and the choice among them.

use core::fmt;
use std::collections::BTreeMap;
use std::sync::Arc;

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use bevy_ecs::reflect::{ReflectComponent, ReflectResource};
use bevy_ecs::resource::Resource;
use bevy_math::Vec3;
use bevy_reflect::Reflect;
use drystone::contact::ContactHooks;
use drystone::{BodyId, JointId, ShapeId, World};

use crate::queue::{look_again, look_at_all};

/// A physics world, on an entity. The plugin makes a default one; spawn more for previews, servers
/// or split screens, and choose among them by [`InWorld`].
///
/// The engine's world is within reach: [`Self::world`] for everything that has no component here,
/// and a clone of it for a rollback.
#[derive(Component, Default)]
#[component(on_insert = look_at_all, on_remove = look_at_all)]
pub struct PhysicsWorld {
    pub(crate) world: World,
    /// Shapes that were removed since the last step, with their collider and body. Their contacts
    /// end in the next step.
    pub(crate) gone: Vec<GoneShape>,
    /// Numbers of touching shapes for pairs of colliders of which one has several shapes.
    pub(crate) touching: BTreeMap<(Entity, Entity), u32>,
    /// The entities of joints, by slot: a joint that broke is no longer in the world.
    pub(crate) joints: Vec<Option<(JointId, Entity)>>,
    /// Whether it was put back to an earlier state since the last step.
    pub(crate) is_restored: bool,
    /// Hooks of the contacts of its steps.
    pub(crate) hooks: Option<Arc<dyn ContactHooks + Send + Sync>>,
    /// Number of the last step whose events were delivered.
    pub(crate) delivered: u64,
}

/// A shape that was removed, with the entities that it belonged to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GoneShape {
    pub(crate) shape: ShapeId,
    pub(crate) collider: Entity,
    pub(crate) body: Entity,
}

impl PhysicsWorld {
    /// A world for this plugin, for example `World::new(config)?.with_threads(0)`.
    #[must_use]
    pub fn new(world: World) -> Self {
        let delivered = world.step_count();
        Self { world, delivered, ..Self::default() }
    }

    /// The engine's world.
    #[must_use]
    pub const fn world(&self) -> &World {
        &self.world
    }

    /// The engine's world for changes. Bodies that are added here have no entity and are left
    /// alone; their number for the user stays 0. That of an entity's body is [`Entity::to_bits`],
    /// which is never 0. [`Self::adopt`] gives a body an entity.
    pub const fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// Puts back an earlier clone of the engine's world. Put the components of that moment back
    /// into the entities too: where both agree, nothing is changed and nothing wakes, and the steps
    /// have the same bits.
    ///
    /// Bodies whose entities were despawned since are removed, and entities that were spawned since
    /// get new bodies.
    pub fn restore(&mut self, world: &World) {
        self.world.clone_from(world);
        self.is_restored = true;
        self.delivered = self.world.step_count();
    }

    /// Sets the hooks that every step calls for the contacts of colliders with
    /// [`ActiveCollisionHooks`](crate::ActiveCollisionHooks); `None`: no hooks. A hook may drop a
    /// contact, or change its friction, restitution and softness for the step. Each world has its
    /// own. The numbers of shapes in a hook are [`Entity::to_bits`] of their colliders.
    pub fn set_hooks(&mut self, hooks: Option<Arc<dyn ContactHooks + Send + Sync>>) {
        self.hooks = hooks;
    }

    /// The entity of a body; `None` for a body without an entity.
    #[must_use]
    pub fn entity_of(&self, body: BodyId) -> Option<Entity> {
        self.world.body(body).and_then(|body| Entity::try_from_bits(body.user_data()))
    }
}

impl fmt::Debug for PhysicsWorld {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PhysicsWorld").field("counts", &self.world.counts()).finish_non_exhaustive()
    }
}

/// The world of a body, by the entity of its [`PhysicsWorld`]. Without it a body is in the default
/// world. The colliders and joints of a body are in its world.
#[derive(Clone, Component, Copy, Debug, PartialEq, Eq, Reflect)]
#[component(immutable, on_insert = look_again, on_remove = look_again)]
#[reflect(Component)]
pub struct InWorld(#[entities] pub Entity);

/// The entity of the default world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect, Resource)]
#[reflect(Resource)]
pub struct DefaultPhysicsWorld(pub Entity);

/// Gravity of the default world [m/s², world]; default (0, -9.81, 0). Another world has the gravity
/// of its configuration: set it by [`World::set_gravity`].
#[derive(Clone, Copy, Debug, PartialEq, Reflect, Resource)]
#[reflect(Resource)]
pub struct Gravity(pub Vec3);

impl Gravity {
    /// No gravity.
    pub const ZERO: Self = Self(Vec3::ZERO);
}

impl Default for Gravity {
    fn default() -> Self {
        Self(Vec3::new(0.0, -9.81, 0.0))
    }
}

/// Whether and how fast physics runs.
#[derive(Clone, Copy, Debug, PartialEq, Reflect, Resource)]
#[reflect(Resource)]
pub struct PhysicsTime {
    /// Whether steps are left out; default false. Changes of components still reach the world.
    pub paused: bool,
    /// Length of a step relative to the schedule's; default 1. A factor changes the results, since
    /// it changes the length of steps: for slow motion, slow `Time<Virtual>` down in its place.
    pub scale: f32,
}

impl Default for PhysicsTime {
    fn default() -> Self {
        Self { paused: false, scale: 1.0 }
    }
}

/// The place of a body or collider in the order in which they are added. Bodies with it come first,
/// by this number; others follow by the index of their entity.
///
/// The order decides the last bits of a simulation. Give it where entities are spawned in different
/// orders on different machines and their worlds must agree.
#[derive(Clone, Component, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Reflect)]
#[reflect(Component)]
pub struct PhysicsOrder(pub u64);

/// The key of that order.
pub(crate) fn key(order: Option<&PhysicsOrder>, entity: Entity) -> (u64, u32) {
    (order.map_or(u64::MAX, |order| order.0), entity.index_u32())
}
