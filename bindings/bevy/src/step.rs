//! The step itself, and its end: physics writes what moved.

use bevy_ecs::change_detection::DetectChangesMut;
use bevy_ecs::entity::Entity;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::message::MessageWriter;
use bevy_ecs::query::{Has, Without};
use bevy_ecs::system::{Commands, Query, Res, ResMut, SystemParam};
use bevy_ecs::world::Mut;
use bevy_time::Time;
use bevy_transform::components::Transform;
use drystone::{BodyKind, Pose, limits};

use crate::body::{AngularVelocity, LinearVelocity, PhysicsBody, Sleeping};
use crate::convert::{Placement, from_quat, from_vec, same_place, same_vec};
use crate::events::PhysicsFault;
use crate::scene::BodiesBelow;
use crate::sync::SyncState;
use crate::world::{PhysicsTime, PhysicsWorld};

/// The system that steps all worlds.
pub(crate) fn step_worlds(
    mut worlds: Query<'_, '_, (Entity, &mut PhysicsWorld)>,
    time: Res<'_, Time>,
    pace: Res<'_, PhysicsTime>,
    mut faults: MessageWriter<'_, PhysicsFault>,
) {
    let dt = time.delta_secs() * pace.scale;
    // The first run of a schedule may have no length; there is nothing to report then.
    if pace.paused || dt == 0.0 {
        return;
    }
    for (entity, mut physics) in &mut worlds {
        if limits::TIME_STEP.admits(dt) {
            match physics.hooks.clone() {
                Some(hooks) => physics.world.step_with(dt, &*hooks),
                None => physics.world.step(dt),
            }
        } else {
            let text = format!("the step must be {} (got {dt})", limits::TIME_STEP.allowed);
            PhysicsFault { world: entity, entity: None, text }.report(&mut faults);
        }
    }
}

/// The components of a body that a step writes.
type Written = (
    Option<&'static mut Transform>,
    Option<&'static mut LinearVelocity>,
    Option<&'static mut AngularVelocity>,
    &'static mut PhysicsBody,
    Has<ChildOf>,
    Has<BodiesBelow>,
);

/// The entities that the end of a step writes.
#[derive(SystemParam)]
pub(crate) struct Writes<'w, 's> {
    bodies: Query<'w, 's, Written>,
    /// Ancestors that are no bodies.
    others: Query<'w, 's, &'static Transform, Without<PhysicsBody>>,
    parents: Query<'w, 's, &'static ChildOf>,
    children: Query<'w, 's, &'static Children>,
}

/// The system that writes the poses and velocities of bodies that moved. It touches no others, and
/// writes only what differs.
pub(crate) fn write_back(
    worlds: Query<'_, '_, (Entity, &PhysicsWorld)>,
    mut writes: Writes<'_, '_>,
    mut state: ResMut<'_, SyncState>,
    mut commands: Commands<'_, '_>,
) {
    let mut nested = core::mem::take(&mut state.rewrite);
    state.moving.clear();
    for (of, physics) in &worlds {
        // Without a step nothing moved.
        if physics.world.step_count() != physics.delivered {
            writes.write_moved(of, physics, &mut state.moving, &mut nested);
            write_sleep(physics, &mut writes, &mut commands);
        }
    }
    writes.write_nested(nested, &worlds);
}

impl Writes<'_, '_> {
    fn write_moved(
        &mut self,
        of: Entity,
        physics: &PhysicsWorld,
        moving: &mut Vec<Entity>,
        nested: &mut Vec<Entity>,
    ) {
        for body in physics.world.moved_bodies() {
            let Some(entity) = Entity::try_from_bits(body.user_data()) else { continue };
            let Ok((place, linear, angular, mut record, is_child, has_below)) =
                self.bodies.get_mut(entity)
            else {
                continue;
            };
            if record.link.is_none_or(|link| link.world != of || link.body != body.id()) {
                continue;
            }
            moving.push(entity);
            if has_below {
                let mut open = vec![entity];
                while let Some(parent) = open.pop() {
                    let Ok(children) = self.children.get(parent) else { continue };
                    nested.extend(children.iter());
                    open.extend(children.iter());
                }
            }
            if !record.targeted {
                let (v, w) = (from_vec(body.linear_velocity()), from_vec(body.angular_velocity()));
                (record.linear, record.angular) = (v, w);
                if let Some(mut linear) = linear
                    && !same_vec(linear.0, v)
                {
                    linear.0 = v;
                }
                if let Some(mut angular) = angular
                    && !same_vec(angular.0, w)
                {
                    angular.0 = w;
                }
            }
            if is_child {
                nested.push(entity);
            } else if let Some(place) = place {
                write_pose(&body.pose(), &mut record, place);
            }
        }
    }

    /// Writes bodies below other entities, parents first.
    fn write_nested(
        &mut self,
        nested: Vec<Entity>,
        worlds: &Query<'_, '_, (Entity, &PhysicsWorld)>,
    ) {
        let depth = |entity: Entity| self.parents.iter_ancestors(entity).count();
        let mut by_depth: Vec<(usize, Entity)> =
            nested.into_iter().map(|entity| (depth(entity), entity)).collect();
        by_depth.sort_unstable();
        by_depth.dedup();
        for (_, entity) in by_depth {
            let Ok((_, _, _, record, ..)) = self.bodies.get(entity) else { continue };
            let Some(link) = record.link else { continue };
            let Ok((_, physics)) = worlds.get(link.world) else { continue };
            let Some(body) = physics.world.body(link.body) else { continue };
            let moves =
                record.linear != bevy_math::Vec3::ZERO || record.angular != bevy_math::Vec3::ZERO;
            // Others follow their parents at the beginning of the next step.
            let is_free = match body.kind() {
                BodyKind::Dynamic => true,
                BodyKind::Kinematic => moves || record.targeted,
                BodyKind::Static => false,
            };
            if !is_free {
                continue;
            }
            let ancestors: Vec<Entity> = self.parents.iter_ancestors(entity).collect();
            let frame = ancestors.iter().rev().fold(Placement::IDENTITY, |place, entity| {
                let inner = self.place(*entity);
                place.child(&Placement::of(&inner))
            });
            let local = if ancestors.is_empty() { body.pose() } else { frame.local(&body.pose()) };
            if let Ok((Some(place), _, _, mut record, ..)) = self.bodies.get_mut(entity) {
                write_pose(&local, &mut record, place);
            }
        }
    }

    /// The transform of an entity.
    fn place(&self, entity: Entity) -> Transform {
        let of_body = self.bodies.get(entity).ok().and_then(|(place, ..)| place.copied());
        let place = of_body.or_else(|| self.others.get(entity).ok().copied());
        place.unwrap_or_default()
    }
}

/// Writes a pose [m, frame of the parent], if it differs.
fn write_pose(pose: &Pose, record: &mut PhysicsBody, mut transform: Mut<'_, Transform>) {
    record.before = record.local;
    let now = Transform {
        translation: from_vec(pose.position),
        rotation: from_quat(pose.rotation),
        scale: transform.scale,
    };
    record.local = Transform { scale: record.local.scale, ..now };
    if !same_place(&transform, &now) {
        *transform = now;
    }
}

/// Inserts and removes [`Sleeping`] by the events of the step.
fn write_sleep(
    physics: &PhysicsWorld,
    writes: &mut Writes<'_, '_>,
    commands: &mut Commands<'_, '_>,
) {
    let events = physics.world.events();
    for body in events.sleep.iter().chain(&events.wake) {
        let Some(body) = physics.world.body(*body) else { continue };
        let Some(entity) = Entity::try_from_bits(body.user_data()) else { continue };
        let Ok((_, _, _, mut record, ..)) = writes.bodies.get_mut(entity) else { continue };
        if record.link.is_none_or(|link| link.body != body.id())
            || body.is_asleep() == record.asleep
        {
            continue;
        }
        record.asleep = body.is_asleep();
        write_sleeping(entity, record.asleep, commands);
    }
}

/// Inserts or removes [`Sleeping`].
pub(crate) fn write_sleeping(entity: Entity, is_asleep: bool, commands: &mut Commands<'_, '_>) {
    if is_asleep {
        commands.entity(entity).try_insert(Sleeping);
    } else {
        commands.entity(entity).try_remove::<Sleeping>();
    }
}

/// The system that shows bodies between their last two poses, after the fixed steps of a frame.
pub(crate) fn show_between(
    mut bodies: Query<
        '_,
        '_,
        (&mut Transform, &mut PhysicsBody),
        Without<crate::body::NoInterpolation>,
    >,
    state: Res<'_, SyncState>,
    time: Res<'_, Time<bevy_time::Fixed>>,
) {
    let part = time.overstep_fraction();
    for entity in &state.moving {
        let Ok((mut transform, mut record)) = bodies.get_mut(*entity) else { continue };
        let last = record.shown.unwrap_or(record.local);
        // The user moved it in this frame: a teleport that the next step reads.
        if !same_place(&last, &transform) {
            continue;
        }
        let (from, to) = (Placement::of(&record.before).pose, Placement::of(&record.local).pose);
        let pose = from.lerp(&to, part);
        let shown = Transform {
            translation: from_vec(pose.position),
            rotation: from_quat(pose.rotation),
            scale: transform.scale,
        };
        record.shown = Some(shown);
        if !same_place(&transform, &shown) {
            *transform = shown;
        }
    }
}

/// The system that puts the true poses back before the next fixed step. A part that the user wrote
/// meanwhile stays.
pub(crate) fn show_true(
    mut bodies: Query<'_, '_, (&mut Transform, &mut PhysicsBody)>,
    state: Res<'_, SyncState>,
) {
    for entity in &state.moving {
        let Ok((mut transform, mut record)) = bodies.get_mut(*entity) else { continue };
        let Some(shown) = record.shown.take() else { continue };
        let mut now = *transform;
        if same_vec(now.translation, shown.translation) {
            now.translation = record.local.translation;
        }
        let bits = |q: bevy_math::Quat| q.to_array().map(f32::to_bits);
        if bits(now.rotation) == bits(shown.rotation) {
            now.rotation = record.local.rotation;
        }
        transform.set_if_neq(now);
    }
}
