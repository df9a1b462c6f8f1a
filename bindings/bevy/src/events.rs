//! Events, as messages and as events of entities that observers see.

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use bevy_ecs::event::EntityEvent;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::message::{Message, MessageWriter};
use bevy_ecs::reflect::ReflectComponent;
use bevy_ecs::world::DeferredWorld;
use bevy_math::Vec3;
use bevy_reflect::Reflect;

use crate::queue::Pending;

/// Two colliders began to touch. As an event it comes to each of both colliders, which is then the
/// first.
#[derive(Clone, Copy, Debug, EntityEvent, Message, PartialEq, Reflect)]
pub struct CollisionStart {
    /// First collider.
    #[event_target]
    pub collider1: Entity,
    /// Second collider.
    pub collider2: Entity,
    /// Body of the first collider.
    pub body1: Entity,
    /// Body of the second collider.
    pub body2: Entity,
}

/// Two colliders ceased to touch, also because one was despawned, disabled or changed. A despawned
/// collider gets no event; the other one and messages do.
#[derive(Clone, Copy, Debug, EntityEvent, Message, PartialEq, Reflect)]
pub struct CollisionEnd {
    /// First collider.
    #[event_target]
    pub collider1: Entity,
    /// Second collider.
    pub collider2: Entity,
    /// Body of the first collider.
    pub body1: Entity,
    /// Body of the second collider.
    pub body2: Entity,
}

/// Two colliders met at more than the hit speed: they began to touch, or a part landed.
#[derive(Clone, Copy, Debug, EntityEvent, Message, PartialEq, Reflect)]
pub struct CollisionHit {
    /// First collider.
    #[event_target]
    pub collider1: Entity,
    /// Second collider.
    pub collider2: Entity,
    /// Body of the first collider.
    pub body1: Entity,
    /// Body of the second collider.
    pub body2: Entity,
    /// Position [m, world].
    pub point: Vec3,
    /// Normal from the first to the second collider [world].
    pub normal: Vec3,
    /// Speed along the normal before the hit [m/s]; above 0.
    pub speed: f32,
    /// Impulse along the normals in the step of the hit [N s].
    pub impulse: f32,
}

/// A collider entered a sensor. As an event it comes to the sensor.
#[derive(Clone, Copy, Debug, EntityEvent, Message, PartialEq, Reflect)]
pub struct SensorEnter {
    /// The sensor.
    #[event_target]
    pub sensor: Entity,
    /// The other collider.
    pub visitor: Entity,
    /// Body of the sensor.
    pub sensor_body: Entity,
    /// Body of the other collider.
    pub visitor_body: Entity,
}

/// A collider left a sensor. As an event it comes to the sensor.
#[derive(Clone, Copy, Debug, EntityEvent, Message, PartialEq, Reflect)]
pub struct SensorExit {
    /// The sensor.
    #[event_target]
    pub sensor: Entity,
    /// The other collider.
    pub visitor: Entity,
    /// Body of the sensor.
    pub sensor_body: Entity,
    /// Body of the other collider.
    pub visitor_body: Entity,
}

/// A joint exceeded its strength and was removed. Its entity stays, without effect, until its joint
/// component is inserted again.
#[derive(Clone, Copy, Debug, EntityEvent, Message, PartialEq, Reflect)]
pub struct JointBroke {
    /// The joint.
    #[event_target]
    pub joint: Entity,
    /// Its first body.
    pub body1: Entity,
    /// Its second body.
    pub body2: Entity,
    /// Force on the joint [N].
    pub force: f32,
    /// Torque [N m].
    pub torque: f32,
    /// Impulse of the step [N s].
    pub impulse: f32,
}

/// A value or call was refused, or a step failed for a body. It is also logged as a warning.
#[derive(Clone, Debug, Message, PartialEq, Eq, Reflect)]
pub struct PhysicsFault {
    /// The world.
    pub world: Entity,
    /// The entity with the value, if there is one.
    pub entity: Option<Entity>,
    /// The field, the allowed values and the given one.
    pub text: String,
}

impl PhysicsFault {
    pub(crate) fn report(self, faults: &mut MessageWriter<'_, Self>) {
        match self.entity {
            Some(entity) => log::warn!("physics of {entity}: {}", self.text),
            None => log::warn!("physics: {}", self.text),
        }
        faults.write(self);
    }
}

/// The colliders that touch a collider, or overlap a sensor, in the order of entities. The plugin
/// keeps it up to date on each collider that has it.
#[derive(Clone, Component, Debug, Default, PartialEq, Eq, Reflect)]
#[component(on_insert = fill)]
#[reflect(Component)]
pub struct CollidingEntities(pub(crate) Vec<Entity>);

impl CollidingEntities {
    /// The colliders, sorted.
    #[must_use]
    pub fn entities(&self) -> &[Entity] {
        &self.0
    }

    /// Whether it touches this collider.
    #[must_use]
    pub fn contains(&self, entity: Entity) -> bool {
        self.0.binary_search(&entity).is_ok()
    }

    pub(crate) fn add(&mut self, entity: Entity) {
        if let Err(place) = self.0.binary_search(&entity) {
            self.0.insert(place, entity);
        }
    }

    pub(crate) fn remove(&mut self, entity: Entity) {
        if let Ok(place) = self.0.binary_search(&entity) {
            self.0.remove(place);
        }
    }
}

/// A list that is inserted late needs the touches that began before.
fn fill(mut world: DeferredWorld<'_>, context: HookContext) {
    if let Some(mut pending) = world.get_resource_mut::<Pending>() {
        pending.lists.push(context.entity);
    }
}
