//! The entities as the plugin reads them: which body a collider belongs to, and where things are.

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::query::{Has, QueryData};
use bevy_ecs::system::{Query, Res, SystemParam};
use bevy_transform::components::Transform;
use drystone::{BodyKind, Pose};

use crate::body::{
    AngularDamping, AngularVelocity, ConstantForce, ConstantTorque, GravityScale, LinearDamping,
    LinearVelocity, LockedAxes, Mass, MassProperties, RigidBody, RigidBodyDisabled, SleepThreshold,
    Sleeping, SleepingDisabled,
};
use crate::collider::Collider;
use crate::convert::Placement;
use crate::fracture::Fracture;
use crate::surface::{
    ActiveCollisionHooks, ColliderDensity, ColliderDisabled, CollisionLayers, Friction, HitSpeed,
    KineticFriction, OneWay, Restitution, RollingResistance, Sensor, SensorSenses,
    SpinningResistance, SurfaceVelocity,
};
use crate::world::{DefaultPhysicsWorld, InWorld, PhysicsOrder, key};

/// Maximum depth of a hierarchy. It stops the search in hierarchies that a program closed to a
/// circle.
const DEEPEST: usize = 4096;

/// Marks an entity that has bodies or colliders below it, whose places depend on it.
#[derive(Component, Debug, Default)]
pub(crate) struct BodiesBelow;

/// All components that describe a body.
#[derive(QueryData)]
pub(crate) struct HostData {
    pub(crate) linear: Option<&'static LinearVelocity>,
    pub(crate) angular: Option<&'static AngularVelocity>,
    pub(crate) mass: Option<&'static Mass>,
    pub(crate) properties: Option<&'static MassProperties>,
    pub(crate) linear_damping: Option<&'static LinearDamping>,
    pub(crate) angular_damping: Option<&'static AngularDamping>,
    pub(crate) gravity_scale: Option<&'static GravityScale>,
    pub(crate) locks: Option<&'static LockedAxes>,
    pub(crate) force: Option<&'static ConstantForce>,
    pub(crate) torque: Option<&'static ConstantTorque>,
    pub(crate) threshold: Option<&'static SleepThreshold>,
    pub(crate) fracture: Option<&'static Fracture>,
    pub(crate) is_disabled: Has<RigidBodyDisabled>,
    pub(crate) is_asleep: Has<Sleeping>,
    pub(crate) is_sleepless: Has<SleepingDisabled>,
}

/// The components that a collider takes from its body where it has none of its own.
#[derive(QueryData)]
pub(crate) struct SurfaceData {
    pub(crate) friction: Option<&'static Friction>,
    pub(crate) kinetic: Option<&'static KineticFriction>,
    pub(crate) rolling: Option<&'static RollingResistance>,
    pub(crate) spinning: Option<&'static SpinningResistance>,
    pub(crate) restitution: Option<&'static Restitution>,
    pub(crate) density: Option<&'static ColliderDensity>,
    pub(crate) layers: Option<&'static CollisionLayers>,
    pub(crate) hit_speed: Option<&'static HitSpeed>,
}

/// All components that describe a collider.
#[derive(QueryData)]
pub(crate) struct ColliderData {
    pub(crate) collider: &'static Collider,
    pub(crate) surface: SurfaceData,
    pub(crate) velocity: Option<&'static SurfaceVelocity>,
    pub(crate) one_way: Option<&'static OneWay>,
    pub(crate) senses: Option<&'static SensorSenses>,
    pub(crate) is_sensor: Has<Sensor>,
    pub(crate) is_disabled: Has<ColliderDisabled>,
    pub(crate) has_hooks: Has<ActiveCollisionHooks>,
}

/// Read access to the entities.
#[derive(SystemParam)]
pub(crate) struct Scene<'w, 's> {
    pub(crate) hosts: Query<'w, 's, HostData>,
    kinds: Query<'w, 's, &'static RigidBody>,
    worlds: Query<'w, 's, &'static InWorld>,
    orders: Query<'w, 's, &'static PhysicsOrder>,
    pub(crate) colliders: Query<'w, 's, ColliderData>,
    pub(crate) surfaces: Query<'w, 's, SurfaceData>,
    pub(crate) parents: Query<'w, 's, &'static ChildOf>,
    pub(crate) children: Query<'w, 's, &'static Children>,
    pub(crate) transforms: Query<'w, 's, &'static Transform>,
    pub(crate) below: Query<'w, 's, Has<BodiesBelow>>,
    default: Res<'w, DefaultPhysicsWorld>,
}

impl Scene<'_, '_> {
    /// The entity and its ancestors, nearest first.
    fn upward(&self, entity: Entity) -> impl Iterator<Item = Entity> {
        let parent = |entity: &Entity| self.parents.get(*entity).ok().map(ChildOf::parent);
        core::iter::successors(Some(entity), parent).take(DEEPEST)
    }

    /// The ancestors of an entity, nearest first.
    pub(crate) fn ancestors(&self, entity: Entity) -> impl Iterator<Item = Entity> {
        self.upward(entity).skip(1)
    }

    fn has_body(&self, entity: Entity) -> bool {
        self.kinds.contains(entity)
    }

    /// The entity of the body to which a collider on `entity` belongs: its own or its nearest
    /// ancestor with a body, or else itself, as a static body.
    pub(crate) fn owner(&self, entity: Entity) -> Entity {
        self.upward(entity).find(|entity| self.has_body(*entity)).unwrap_or(entity)
    }

    /// The kind of body that an entity describes; `None`: it describes none.
    pub(crate) fn kind(&self, entity: Entity) -> Option<BodyKind> {
        if let Ok(body) = self.kinds.get(entity) {
            return Some(body.kind());
        }
        let is_alone = self.colliders.contains(entity) && self.owner(entity) == entity;
        is_alone.then_some(BodyKind::Static)
    }

    /// The entity of the world of a body.
    pub(crate) fn world(&self, host: Entity) -> Entity {
        self.worlds.get(host).map_or(self.default.0, |world| world.0)
    }

    /// The place of an entity in the order of additions.
    pub(crate) fn key(&self, entity: Entity) -> (u64, u32) {
        key(self.orders.get(entity).ok(), entity)
    }

    pub(crate) fn transform(&self, entity: Entity) -> Transform {
        self.transforms.get(entity).copied().unwrap_or_default()
    }

    /// The place of an entity in the world.
    pub(crate) fn place(&self, entity: Entity) -> Placement {
        self.place_below(entity, None, Placement::IDENTITY)
    }

    /// The place of a collider in the frame of its body, whose axes are not scaled. The scale of
    /// the body's entity and its ancestors counts.
    pub(crate) fn place_in(&self, collider: Entity, host: Entity) -> Placement {
        let scale = self.place(host).scale;
        let frame = Placement { pose: Pose::IDENTITY, scale };
        self.place_below(collider, Some(host), frame)
    }

    /// The place of an entity, given that of its ancestor `top`; `None`: of the world.
    fn place_below(&self, entity: Entity, top: Option<Entity>, frame: Placement) -> Placement {
        let chain: Vec<Entity> =
            self.upward(entity).take_while(|entity| Some(*entity) != top).collect();
        let inner = |entity: &Entity| Placement::of(&self.transform(*entity));
        chain.iter().rev().fold(frame, |place, entity| place.child(&inner(entity)))
    }

    /// Calls `visit` with every descendant of an entity.
    pub(crate) fn each_below(&self, entity: Entity, mut visit: impl FnMut(Entity)) {
        let mut open = vec![(entity, 0)];
        while let Some((entity, depth)) = open.pop() {
            let Ok(children) = self.children.get(entity) else { continue };
            for child in children.iter().copied() {
                visit(child);
                if depth < DEEPEST {
                    open.push((child, depth + 1));
                }
            }
        }
    }
}
