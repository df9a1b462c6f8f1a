//! Entities that the next step must look at again, in queues filled by component hooks. No query
//! walks entities that nobody changed.

use bevy_ecs::entity::Entity;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::lifecycle::{Discard, HookContext, Insert};
use bevy_ecs::observer::On;
use bevy_ecs::resource::Resource;
use bevy_ecs::system::ResMut;
use bevy_ecs::world::DeferredWorld;
use drystone::particle::ParticleId;
use drystone::{BodyId, JointId, ShapeId};

use crate::body::PhysicsBody;
use crate::collider::PhysicsCollider;
use crate::joint::PhysicsJoint;
use crate::strand::PhysicsStrand;

/// The queues. Entities in them may be despawned meanwhile, and may be listed several times.
#[derive(Debug, Default, Resource)]
pub(crate) struct Pending {
    /// Bodies and colliders.
    pub(crate) dirty: Vec<Entity>,
    /// Entities whose whole subtree counts as dirty.
    pub(crate) trees: Vec<Entity>,
    /// Joints.
    pub(crate) joints: Vec<Entity>,
    /// Bodies whose entity lost its record, with the entity of their world.
    pub(crate) gone_bodies: Vec<(Entity, BodyId)>,
    /// Shapes whose entity lost its record, with the entity of their world.
    pub(crate) gone_shapes: Vec<(Entity, ShapeId)>,
    /// Joints whose entity lost its record, with the entity of their world.
    pub(crate) gone_joints: Vec<(Entity, JointId)>,
    /// Bodies that got or lost `Sleeping`.
    pub(crate) sleepers: Vec<Entity>,
    /// Ropes and cloths.
    pub(crate) strands: Vec<Entity>,
    /// Particles whose entity lost its record, with the entity of their world.
    pub(crate) gone_strands: Vec<(Entity, ParticleId)>,
    /// Lists of touching colliders that were inserted since the last step.
    pub(crate) lists: Vec<Entity>,
    /// Whether a world came or went, so that every body counts as dirty.
    pub(crate) all: bool,
}

/// Without the plugin there is nothing to fill.
fn pending<'w>(world: &'w mut DeferredWorld<'_>) -> Option<bevy_ecs::world::Mut<'w, Pending>> {
    world.get_resource_mut::<Pending>()
}

/// The hook of components that describe a body or a collider.
pub(crate) fn look_again(mut world: DeferredWorld<'_>, context: HookContext) {
    if let Some(mut pending) = pending(&mut world) {
        pending.dirty.push(context.entity);
    }
}

/// The hook of components that decide to which body the colliders below an entity belong.
pub(crate) fn look_below(mut world: DeferredWorld<'_>, context: HookContext) {
    if let Some(mut pending) = pending(&mut world) {
        pending.trees.push(context.entity);
    }
}

/// The hook of components that describe a joint.
pub(crate) fn look_at_joint(mut world: DeferredWorld<'_>, context: HookContext) {
    if let Some(mut pending) = pending(&mut world) {
        pending.joints.push(context.entity);
    }
}

/// The hook of inserted joints, which also mends a broken one.
pub(crate) fn mend_joint(mut world: DeferredWorld<'_>, context: HookContext) {
    if let Some(mut record) = world.get_mut::<PhysicsJoint>(context.entity) {
        record.is_broken = false;
    }
    look_at_joint(world, context);
}

/// The hook of worlds.
pub(crate) fn look_at_all(mut world: DeferredWorld<'_>, _: HookContext) {
    if let Some(mut pending) = pending(&mut world) {
        pending.all = true;
    }
}

pub(crate) fn body_gone(mut world: DeferredWorld<'_>, context: HookContext) {
    let link = world.get::<PhysicsBody>(context.entity).and_then(|record| record.link);
    if let (Some(link), Some(mut pending)) = (link, pending(&mut world)) {
        pending.gone_bodies.push((link.world, link.body));
    }
}

pub(crate) fn collider_gone(mut world: DeferredWorld<'_>, context: HookContext) {
    let record = world.get_mut::<PhysicsCollider>(context.entity);
    let Some((of, shapes)) = record.map(|mut r| (r.world, core::mem::take(&mut r.shapes))) else {
        return;
    };
    if let (Some(of), Some(mut pending)) = (of, pending(&mut world)) {
        pending.gone_shapes.extend(shapes.into_iter().map(|shape| (of, shape)));
    }
}

pub(crate) fn joint_gone(mut world: DeferredWorld<'_>, context: HookContext) {
    let link = world.get::<PhysicsJoint>(context.entity).and_then(|record| record.link);
    if let (Some(link), Some(mut pending)) = (link, pending(&mut world)) {
        pending.gone_joints.push(link);
    }
}

/// The hook of `Sleeping`.
pub(crate) fn look_at_sleep(mut world: DeferredWorld<'_>, context: HookContext) {
    if let Some(mut pending) = pending(&mut world) {
        pending.sleepers.push(context.entity);
    }
}

/// The hook of ropes and cloths.
pub(crate) fn look_at_strand(mut world: DeferredWorld<'_>, context: HookContext) {
    if let Some(mut pending) = pending(&mut world) {
        pending.strands.push(context.entity);
    }
}

pub(crate) fn strand_gone(mut world: DeferredWorld<'_>, context: HookContext) {
    let record = world.get_mut::<PhysicsStrand>(context.entity);
    let Some((of, all)) = record.map(|mut r| (r.world, core::mem::take(&mut r.particles))) else {
        return;
    };
    if let (Some(of), Some(mut pending)) = (of, pending(&mut world)) {
        pending.gone_strands.extend(all.into_iter().map(|particle| (of, particle)));
    }
}

/// The observer of new parents.
pub(crate) fn note_parent(insert: On<'_, '_, Insert, ChildOf>, mut pending: ResMut<'_, Pending>) {
    pending.trees.push(insert.entity);
}

/// The observer of lost parents.
pub(crate) fn note_orphan(discard: On<'_, '_, Discard, ChildOf>, mut pending: ResMut<'_, Pending>) {
    pending.trees.push(discard.entity);
}
