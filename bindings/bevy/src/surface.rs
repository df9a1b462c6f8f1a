//! Components of colliders: surfaces, layers, roles.
//!
//! A collider on a descendant of a body has the surface and layers of the body's entity, unless its
//! own entity has such a component.

use bevy_ecs::component::Component;
use bevy_ecs::reflect::ReflectComponent;
use bevy_math::Vec3;
use bevy_reflect::Reflect;
use bevy_reflect::prelude::ReflectDefault;
use drystone::Filter;
use drystone::contact::Combine;

use crate::queue::look_again;

/// Rule that combines the coefficients of two surfaces. If they differ, the one listed later is
/// used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default)]
pub enum CoefficientCombine {
    /// √(a b): the default for friction.
    #[default]
    GeometricMean,
    /// a b.
    Multiply,
    /// The maximum: the default for restitution.
    Max,
    /// The minimum.
    Min,
    /// (a + b) / 2.
    Average,
}

impl CoefficientCombine {
    pub(crate) const fn rule(self) -> Combine {
        match self {
            Self::GeometricMean => Combine::GeometricMean,
            Self::Multiply => Combine::Multiply,
            Self::Max => Combine::Maximum,
            Self::Min => Combine::Minimum,
            Self::Average => Combine::Average,
        }
    }
}

/// Coulomb friction of a collider; default 0.6.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct Friction {
    /// The coefficient, at least 0: the static one, and the kinetic one unless [`KineticFriction`]
    /// is given.
    pub coefficient: f32,
    /// Its rule; default the geometric mean.
    pub combine_rule: CoefficientCombine,
}

impl Friction {
    /// No friction.
    pub const ZERO: Self = Self::new(0.0);

    /// Friction with this coefficient.
    #[must_use]
    pub const fn new(coefficient: f32) -> Self {
        Self { coefficient, combine_rule: CoefficientCombine::GeometricMean }
    }

    /// With this rule.
    #[must_use]
    pub const fn with_combine_rule(self, combine_rule: CoefficientCombine) -> Self {
        Self { combine_rule, ..self }
    }
}

impl Default for Friction {
    fn default() -> Self {
        Self::new(0.6)
    }
}

/// Friction coefficient of a sliding contact, at least 0; default: that of [`Friction`].
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component)]
pub struct KineticFriction(pub f32);

/// Maximum torque against rolling, as a fraction of normal force times radius; at least 0; default
/// 0. Spheres, capsules, cylinders and cones have a radius.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct RollingResistance(pub f32);

/// Maximum torque about the contact normal, as a fraction of normal force times radius; at least 0;
/// default 0.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct SpinningResistance(pub f32);

/// Bounciness of a collider; default 0.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct Restitution {
    /// The coefficient, 0 to 1.
    pub coefficient: f32,
    /// Its rule; default the maximum.
    pub combine_rule: CoefficientCombine,
}

impl Restitution {
    /// No bounce.
    pub const ZERO: Self = Self::new(0.0);

    /// Restitution with this coefficient.
    #[must_use]
    pub const fn new(coefficient: f32) -> Self {
        Self { coefficient, combine_rule: CoefficientCombine::Max }
    }

    /// With this rule.
    #[must_use]
    pub const fn with_combine_rule(self, combine_rule: CoefficientCombine) -> Self {
        Self { combine_rule, ..self }
    }
}

impl Default for Restitution {
    fn default() -> Self {
        Self::ZERO
    }
}

/// Density of a collider [kg/m³], at least 0; default 1000.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct ColliderDensity(pub f32);

impl Default for ColliderDensity {
    fn default() -> Self {
        Self(1000.0)
    }
}

/// Motion of a collider's surface along itself, as of a conveyor belt.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct SurfaceVelocity {
    /// Velocity [m/s, frame of the collider].
    pub linear: Vec3,
    /// Angular velocity about the collider's origin, for rotating belts [rad/s, frame of the
    /// collider].
    pub angular: Vec3,
}

/// Makes a collider block only bodies that come from its front, given as a direction of any length
/// [frame of the collider]. Others pass until they no longer overlap it.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component)]
pub struct OneWay(pub Vec3);

/// A collider that reports overlaps, and touches nothing.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[component(on_insert = look_again, on_remove = look_again)]
#[reflect(Component, Default)]
pub struct Sensor;

/// Additional objects that a [`Sensor`] detects, besides bodies that can move.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct SensorSenses {
    /// Whether a sensor on a static body detects static bodies; default false.
    pub statics: bool,
    /// Whether it detects other sensors; default false.
    pub sensors: bool,
}

/// Takes a collider out of its world while it is there. It still counts for the mass of its body.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[component(on_insert = look_again, on_remove = look_again)]
#[reflect(Component, Default)]
pub struct ColliderDisabled;

/// Calls the hooks of its world for the contacts of a collider: see
/// [`PhysicsWorld::set_hooks`](crate::PhysicsWorld::set_hooks).
#[derive(Clone, Component, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[component(on_insert = look_again, on_remove = look_again)]
#[reflect(Component, Default)]
pub struct ActiveCollisionHooks;

/// Minimum approach speed of the hits that a collider reports [m/s]; default: the world's, 1 m/s.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component)]
pub struct HitSpeed(pub f32);

/// The layers of a collider, and the layers that it collides with, one bit each. Two colliders
/// touch if each one's filters have a layer of the other.
#[derive(Clone, Component, Copy, Debug, PartialEq, Eq, Reflect)]
#[component(on_remove = look_again)]
#[reflect(Component, Default)]
pub struct CollisionLayers {
    /// Its layers; default the first.
    pub memberships: u64,
    /// The layers that it collides with; default all.
    pub filters: u64,
}

impl CollisionLayers {
    /// It is in no layer and collides with nothing.
    pub const NONE: Self = Self { memberships: 0, filters: 0 };

    /// It is in `memberships`, and collides with `filters`.
    #[must_use]
    pub const fn new(memberships: u64, filters: u64) -> Self {
        Self { memberships, filters }
    }

    pub(crate) const fn filter(self) -> Filter {
        Filter::layers(self.memberships, self.filters)
    }
}

impl Default for CollisionLayers {
    fn default() -> Self {
        Self { memberships: 1, filters: u64::MAX }
    }
}
