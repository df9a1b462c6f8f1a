//! Components of bodies.

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use bevy_ecs::reflect::ReflectComponent;
use bevy_math::Vec3;
use bevy_reflect::Reflect;
use bevy_reflect::prelude::ReflectDefault;
use bevy_transform::components::Transform;
use drystone::{AxisLocks, BodyId, BodyKind};

use crate::forces::PendingForces;
use crate::queue::{body_gone, look_again, look_at_sleep, look_below};

/// A body, and the cause of its motion. Insert another value to change it.
///
/// Colliders on the same entity and on its descendants are its shapes. A dynamic body without any
/// solid collider and without [`Mass`] has a mass of 1 kg, so that it can move.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[component(immutable, on_insert = look_below, on_remove = look_below)]
#[require(PhysicsBody, PendingForces, Transform, LinearVelocity, AngularVelocity)]
#[reflect(Component, Default)]
pub enum RigidBody {
    /// Forces, contacts and joints move it. A write to its `Transform` is a teleport.
    #[default]
    Dynamic,
    /// It never moves by itself. A write to its `Transform` moves it at once.
    Static,
    /// It moves at its velocity, which only the user writes. A write to its `Transform` is a
    /// target, which it reaches at the end of the next step; it pushes and carries what it meets.
    Kinematic,
}

impl RigidBody {
    pub(crate) const fn kind(self) -> BodyKind {
        match self {
            Self::Dynamic => BodyKind::Dynamic,
            Self::Static => BodyKind::Static,
            Self::Kinematic => BodyKind::Kinematic,
        }
    }
}

/// The body of an entity in its world, kept by the plugin.
#[derive(Component, Debug, Default)]
#[component(on_remove = body_gone, clone_behavior = Ignore)]
pub struct PhysicsBody {
    pub(crate) link: Option<BodyLink>,
    /// The transform that the plugin last read or wrote.
    pub(crate) local: Transform,
    /// The velocities that the plugin last read or wrote.
    pub(crate) linear: Vec3,
    pub(crate) angular: Vec3,
    /// The lasting force and torque of the body.
    pub(crate) force: Vec3,
    pub(crate) torque: Vec3,
    /// Whether the plugin last saw or inserted [`Sleeping`].
    pub(crate) asleep: bool,
    /// Whether a target of the last step gave a kinematic body its velocity.
    pub(crate) targeted: bool,
    /// The round of the last look at it, see `sync`.
    pub(crate) round: u64,
    /// The transform before the last step, from which interpolation starts.
    pub(crate) before: Transform,
    /// The interpolated transform that is shown now; `None`: the true one is.
    pub(crate) shown: Option<Transform>,
}

/// A body in a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BodyLink {
    pub(crate) world: Entity,
    pub(crate) body: BodyId,
}

impl PhysicsBody {
    /// The body in its world; `None` before the first step after it was spawned, for a collider
    /// that belongs to the body of an ancestor, and for a body that was refused.
    #[must_use]
    pub fn body(&self) -> Option<BodyId> {
        self.link.map(|link| link.body)
    }

    /// The entity of its [`PhysicsWorld`](crate::PhysicsWorld).
    #[must_use]
    pub fn world(&self) -> Option<Entity> {
        self.link.map(|link| link.world)
    }
}

/// Velocity of the center of mass [m/s, world]; default 0. The plugin writes it for dynamic bodies.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct LinearVelocity(pub Vec3);

/// Angular velocity [rad/s, world]; default 0. The plugin writes it for dynamic bodies.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct AngularVelocity(pub Vec3);

/// Mass of a dynamic body [kg], above 0. Its center and inertia are in proportion to its colliders.
/// Without it the mass follows from the colliders and their densities.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component)]
pub struct Mass(pub f32);

/// An exact mass, center and inertia of a dynamic body, independent of its colliders. It takes
/// precedence over [`Mass`].
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component)]
pub struct MassProperties {
    /// Mass [kg]; above 0.
    pub mass: f32,
    /// Center of mass [m, body].
    pub center: Vec3,
    /// Moments of inertia about the center along the body's axes [kg m²]; at least 0, where 0 locks
    /// the axis.
    pub moments: Vec3,
    /// Products of inertia xy, xz and yz [kg m²], as elements of the matrix; 0 if the axes are
    /// principal ones.
    pub products: Vec3,
}

impl MassProperties {
    /// A mass [kg] with this center [m, body] and these moments about it along the body's axes,
    /// which are principal ones [kg m²].
    #[must_use]
    pub const fn new(mass: f32, center: Vec3, moments: Vec3) -> Self {
        Self { mass, center, moments, products: Vec3::ZERO }
    }
}

/// Rate at which the linear velocity decays [1/s], at least 0; default 0.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct LinearDamping(pub f32);

/// Rate at which the angular velocity decays [1/s], at least 0; default 0.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct AngularDamping(pub f32);

/// Factor by which gravity acts on a body, -1000 to 1000; default 1.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct GravityScale(pub f32);

impl Default for GravityScale {
    fn default() -> Self {
        Self(1.0)
    }
}

/// Axes along or about which a dynamic body cannot move [world]; default none.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct LockedAxes {
    /// Locked translations along x, y, z.
    pub translation: [bool; 3],
    /// Locked rotations about x, y, z.
    pub rotation: [bool; 3],
}

impl LockedAxes {
    /// All rotations are locked, as for a character.
    pub const ROTATION_LOCKED: Self = Self { translation: [false; 3], rotation: [true; 3] };
    /// All translations are locked.
    pub const TRANSLATION_LOCKED: Self = Self { translation: [true; 3], rotation: [false; 3] };
    /// Motion in the xy plane only.
    pub const PLANE_XY: Self =
        Self { translation: [false, false, true], rotation: [true, true, false] };

    pub(crate) const fn locks(self) -> AxisLocks {
        AxisLocks { linear: self.translation, angular: self.rotation }
    }
}

/// A lasting force at the center of mass of a dynamic body [N, world].
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct ConstantForce(pub Vec3);

/// A lasting torque on a dynamic body [N m, world].
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct ConstantTorque(pub Vec3);

/// Takes a body out of its world while it is there. The body keeps its state and its joints, and
/// continues when it is removed.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[component(on_insert = look_again, on_remove = look_again)]
#[reflect(Component, Default)]
pub struct RigidBodyDisabled;

/// A dynamic body at rest that is not computed. The plugin inserts and removes it. Insert it to put
/// a body to sleep, with everything that it touches; remove it to wake the body.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[component(storage = "SparseSet", on_insert = look_at_sleep, on_remove = look_at_sleep)]
#[reflect(Component, Default)]
pub struct Sleeping;

/// Keeps a body from falling asleep.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[component(on_insert = look_again, on_remove = look_again)]
#[reflect(Component, Default)]
pub struct SleepingDisabled;

/// Speed below which a body counts as slow and may fall asleep [m/s]; default: the world's.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component)]
pub struct SleepThreshold(pub f32);

/// Shows a body at its last computed place, without interpolation between steps.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default)]
pub struct NoInterpolation;
