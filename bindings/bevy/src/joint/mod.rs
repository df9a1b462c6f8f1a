//! Joints as entities.

mod kinds;
mod place;

pub use self::kinds::{
    DistanceJoint, FixedJoint, JointLimits, JointMotor, JointSpringiness, PrismaticJoint,
    RevoluteJoint, RopeJoint, SphericalJoint,
};
pub use self::place::{JointEnds, JointPlace};

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use bevy_ecs::query::{Changed, Has, Or, QueryData, With};
use bevy_ecs::reflect::ReflectComponent;
use bevy_ecs::system::{Local, Query, Res, ResMut, SystemParam};
use bevy_reflect::Reflect;
use bevy_reflect::prelude::ReflectDefault;
use drystone::joint::SixDof;
use drystone::{DefErrorKind, JointDef, JointId, JointKind};

use crate::body::{BodyLink, PhysicsBody};
use crate::events::PhysicsFault;
use crate::queue::{Pending, joint_gone, look_at_joint};
use crate::sync::{Records, SyncState};
use crate::world::{PhysicsOrder, key};

/// The joint of an entity in its world, kept by the plugin.
#[derive(Component, Debug, Default)]
#[component(on_remove = joint_gone, clone_behavior = Ignore)]
pub struct PhysicsJoint {
    pub(crate) link: Option<(Entity, JointId)>,
    /// The ends of the joint as it was made, and its definition in the frames of its bodies. The
    /// same ends keep these frames, also when a body comes back.
    made: Option<(JointEnds, JointDef)>,
    /// Whether it broke, so that it is not made again.
    pub(crate) is_broken: bool,
}

impl PhysicsJoint {
    /// The joint in its world; `None` while an end is missing, and after it broke or was refused.
    #[must_use]
    pub fn joint(&self) -> Option<JointId> {
        self.link.map(|(_, joint)| joint)
    }

    /// Whether it broke. Insert the joint component again to mend it.
    #[must_use]
    pub const fn is_broken(&self) -> bool {
        self.is_broken
    }
}

/// Loads above which a joint breaks and reports [`JointBroke`](crate::JointBroke). Each may be
/// infinite.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_at_joint)]
#[reflect(Component, Default)]
pub struct JointStrength {
    /// Maximum force [N], above 0.
    pub force: f32,
    /// Maximum torque [N m], above 0.
    pub torque: f32,
    /// Maximum impulse in a step [N s], above 0.
    pub impulse: f32,
}

impl Default for JointStrength {
    fn default() -> Self {
        Self { force: f32::INFINITY, torque: f32::INFINITY, impulse: f32::INFINITY }
    }
}

/// A joint with no effect while this is there.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[component(on_insert = look_at_joint, on_remove = look_at_joint)]
#[reflect(Component, Default)]
pub struct JointDisabled;

/// Lets the two bodies of a joint collide with each other. Without it they do not.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[component(on_insert = look_at_joint, on_remove = look_at_joint)]
#[reflect(Component, Default)]
pub struct JointCollisionEnabled;

/// All components that describe a joint.
#[derive(QueryData)]
pub(crate) struct JointData {
    fixed: Option<&'static FixedJoint>,
    revolute: Option<&'static RevoluteJoint>,
    prismatic: Option<&'static PrismaticJoint>,
    spherical: Option<&'static SphericalJoint>,
    distance: Option<&'static DistanceJoint>,
    rope: Option<&'static RopeJoint>,
    strength: Option<&'static JointStrength>,
    order: Option<&'static PhysicsOrder>,
    is_disabled: Has<JointDisabled>,
    collides: Has<JointCollisionEnabled>,
}

type JointChanges = Or<(
    Changed<FixedJoint>,
    Changed<RevoluteJoint>,
    Changed<PrismaticJoint>,
    Changed<SphericalJoint>,
    Changed<DistanceJoint>,
    Changed<RopeJoint>,
    Changed<JointStrength>,
)>;

/// Access to joints.
#[derive(SystemParam)]
pub(crate) struct Joints<'w, 's> {
    data: Query<'w, 's, JointData>,
    changed: Query<'w, 's, Entity, JointChanges>,
    every: Query<'w, 's, Entity, With<PhysicsJoint>>,
    records: Query<'w, 's, &'static mut PhysicsJoint>,
}

/// The system that brings joints in line with their components, after the bodies.
pub(crate) fn read_joints(
    mut joints: Joints<'_, '_>,
    mut records: Records<'_, '_>,
    mut pending: ResMut<'_, Pending>,
    state: Res<'_, SyncState>,
    mut waiting: Local<'_, Vec<Entity>>,
) {
    pending.gone_joints.sort_unstable();
    for (world, joint) in pending.gone_joints.drain(..) {
        remove(&mut records, world, joint);
    }
    let mut dirty = core::mem::take(&mut pending.joints);
    dirty.extend(&joints.changed);
    if state.has_new_bodies {
        dirty.append(&mut waiting);
    }
    if state.has_other_worlds {
        dirty.extend(&joints.every);
    }
    let mut dirty: Vec<((u64, u32), Entity)> = dirty
        .into_iter()
        .map(|entity| {
            (key(joints.data.get(entity).ok().and_then(|data| data.order), entity), entity)
        })
        .collect();
    dirty.sort_unstable();
    dirty.dedup();
    for (_, entity) in dirty {
        if joints.update(&mut records, entity) == Outcome::Waits {
            waiting.push(entity);
        }
    }
}

/// Whether a joint must be looked at again when bodies come or change their kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    Done,
    Waits,
}

fn remove(records: &mut Records<'_, '_>, world: Entity, joint: JointId) {
    if let Ok(mut physics) = records.worlds.get_mut(world) {
        physics.world.remove_joint(joint);
        if let Some(slot) = physics.joints.get_mut(joint.index() as usize) {
            *slot = None;
        }
    }
}

impl Joints<'_, '_> {
    fn update(&mut self, records: &mut Records<'_, '_>, entity: Entity) -> Outcome {
        let Ok(mut record) = self.records.get_mut(entity) else { return Outcome::Done };
        let data = self.data.get(entity).ok();
        let wanted = data.as_ref().and_then(JointDataItem::wanted);
        let (Some(data), Some((ends, kind))) = (data, wanted) else {
            if let Some((world, joint)) = record.link.take() {
                remove(records, world, joint);
            }
            record.made = None;
            return Outcome::Done;
        };
        if record.is_broken {
            return Outcome::Done;
        }
        let link = |body: Entity| records.bodies.get(body).ok().and_then(|r: &PhysicsBody| r.link);
        let links = link(ends.body1).zip(link(ends.body2));
        let links = links.filter(|(a, b)| a.world == b.world);
        let def = links.map(|links| data.def(entity, &ends, kind, links, record.made.as_ref()));
        if let (Some(def), Some((world, joint))) = (def, record.link)
            && let Ok(mut physics) = records.worlds.get_mut(world)
            && let Some((then, made)) = record.made.as_mut()
            && *then == ends
        {
            match change(&mut physics.world, joint, made, &def) {
                Some(Ok(())) => return Outcome::Done,
                Some(Err(error)) => {
                    let text = error.to_string();
                    PhysicsFault { world, entity: Some(entity), text }.report(&mut records.faults);
                    return Outcome::Done;
                }
                None => {}
            }
        }
        if let Some((world, joint)) = record.link.take() {
            remove(records, world, joint);
        }
        let (Some(def), Some((BodyLink { world, .. }, _))) = (def, links) else {
            return Outcome::Waits;
        };
        let Ok(mut physics) = records.worlds.get_mut(world) else { return Outcome::Waits };
        let placed = physics.world.place_joint(def);
        let added = placed.and_then(|def| Ok((physics.world.add_joint(def)?, def)));
        match added {
            Ok((joint, def)) => {
                let slot = joint.index() as usize;
                if physics.joints.len() <= slot {
                    physics.joints.resize(slot + 1, None);
                }
                physics.joints[slot] = Some((joint, entity));
                record.link = Some((world, joint));
                record.made = Some((ends, def));
                Outcome::Done
            }
            Err(error) => {
                let text = error.to_string();
                PhysicsFault { world, entity: Some(entity), text }.report(&mut records.faults);
                // A bad number stays bad until somebody changes it.
                let is_bad = error.kind() == DefErrorKind::Value;
                if is_bad { Outcome::Done } else { Outcome::Waits }
            }
        }
    }
}

/// Changes a joint in place. `None`: it must be made anew.
fn change(
    world: &mut drystone::World,
    joint: JointId,
    made: &mut JointDef,
    def: &JointDef,
) -> Option<Result<(), drystone::DefError>> {
    let mut joint = world.joint_mut(joint)?;
    let keeps = made.body_a == def.body_a && made.body_b == def.body_b;
    if !keeps {
        return None;
    }
    if made.strength != def.strength
        && let Err(error) = joint.set_strength(def.strength)
    {
        return Some(Err(error));
    }
    if made.kind != def.kind
        && let Err(error) = joint.set_kind(def.kind)
    {
        return Some(Err(error));
    }
    joint.set_enabled(def.enabled);
    joint.set_collide_connected(def.collide_connected);
    *made = *def;
    Some(Ok(()))
}

impl JointDataItem<'_, '_> {
    /// The ends and the kind of the joint. An entity has one joint: the first of these.
    fn wanted(&self) -> Option<(JointEnds, JointKind)> {
        if let Some(joint) = self.fixed {
            return Some((joint.ends, joint.kind()));
        }
        if let Some(joint) = self.revolute {
            return Some((joint.ends, joint.kind()));
        }
        if let Some(joint) = self.prismatic {
            return Some((joint.ends, joint.kind()));
        }
        if let Some(joint) = self.spherical {
            return Some((joint.ends, joint.kind()));
        }
        if let Some(joint) = self.distance {
            return Some((joint.ends, joint.kind()));
        }
        self.rope.map(|joint| (joint.ends, joint.kind()))
    }

    /// The definition of the joint; in the frames of its bodies, if it was made before.
    fn def(
        &self,
        entity: Entity,
        ends: &JointEnds,
        kind: JointKind,
        (a, b): (BodyLink, BodyLink),
        made: Option<&(JointEnds, JointDef)>,
    ) -> JointDef {
        let strength = self.strength.map(|strength| drystone::breakage::JointStrength {
            force: strength.force,
            torque: strength.torque,
            impulse: strength.impulse,
            fatigue: None,
        });
        let def = JointDef {
            strength,
            enabled: !self.is_disabled,
            user_data: entity.to_bits(),
            ..JointDef::new(a.body, b.body, kind).with_collide_connected(self.collides)
        };
        match made.filter(|(then, _)| then == ends) {
            Some((_, made)) => {
                let def = def.with_anchors(made.anchor_a, made.anchor_b);
                match made.kind {
                    JointKind::SixDof(SixDof { frame_a, frame_b, .. }) => {
                        def.with_frames(frame_a, frame_b)
                    }
                    _ => def,
                }
            }
            None => ends.place(def),
        }
    }
}
