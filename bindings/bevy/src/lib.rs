//! Physics for Bevy, by the engine `drystone`.
//!
//! ```
//! use bevy_app::{App, ScheduleRunnerPlugin, Startup};
//! use bevy_drystone::{Collider, DrystonePlugin, RigidBody};
//! use bevy_ecs::system::Commands;
//! use bevy_math::Vec3;
//! use bevy_time::TimePlugin;
//! use bevy_transform::components::Transform;
//!
//! fn setup(mut commands: Commands) {
//!     commands.spawn(Collider::half_space(Vec3::Y));
//!     for k in 0..10 {
//!         let place = Transform::from_xyz(0.0, 0.5 + 1.2 * k as f32, 0.0);
//!         commands.spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), place));
//!     }
//! }
//!
//! let mut app = App::new();
//! app.add_plugins((TimePlugin, DrystonePlugin::default())).add_systems(Startup, setup);
//! # app.update();
//! ```
//!
//! **One rule says who owns what: in `FixedUpdate` you write components; physics reads what changed
//! at its start and writes what moved at its end.** `Transform` is the only pose. A write to the
//! `Transform` of a dynamic body is a teleport, of a kinematic one a target, of a static one a
//! move.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod adopt;
mod body;
mod caster;
mod character;
mod collider;
mod convert;
mod deliver;
mod events;
mod forces;
mod fracture;
mod joint;
mod plugin;
pub mod prelude;
mod query;
mod queue;
mod register;
mod scale;
mod scene;
mod step;
mod strand;
mod surface;
mod sync;
mod world;

pub use self::body::{
    AngularDamping, AngularVelocity, ConstantForce, ConstantTorque, GravityScale, LinearDamping,
    LinearVelocity, LockedAxes, Mass, MassProperties, NoInterpolation, PhysicsBody, RigidBody,
    RigidBodyDisabled, SleepThreshold, Sleeping, SleepingDisabled,
};
pub use self::caster::{RayCaster, RayHits, ShapeCaster, ShapeHits};
pub use self::character::{CharacterHit, CharacterMove, CharacterMover, CharacterSettings};
pub use self::collider::{Collider, ColliderError, PhysicsCollider};
pub use self::events::{
    CollidingEntities, CollisionEnd, CollisionHit, CollisionStart, JointBroke, PhysicsFault,
    SensorEnter, SensorExit,
};
pub use self::forces::{Forces, ForcesItem, ForcesReadOnly, ForcesReadOnlyItem, PendingForces};
pub use self::fracture::{Fracture, Fractured};
pub use self::joint::{
    DistanceJoint, FixedJoint, JointCollisionEnabled, JointDisabled, JointEnds, JointLimits,
    JointMotor, JointPlace, JointSpringiness, JointStrength, PhysicsJoint, PrismaticJoint,
    RevoluteJoint, RopeJoint, SphericalJoint,
};
pub use self::plugin::{DrystonePlugin, PhysicsSystems};
pub use self::query::{Projection, RayHitData, ShapeHitData, SpatialQuery, SpatialQueryFilter};
pub use self::strand::{Cloth, ParticlePositions, PhysicsStrand, Rope, RopeEnd};
pub use self::surface::{
    ActiveCollisionHooks, CoefficientCombine, ColliderDensity, ColliderDisabled, CollisionLayers,
    Friction, HitSpeed, KineticFriction, OneWay, Restitution, RollingResistance, Sensor,
    SensorSenses, SpinningResistance, SurfaceVelocity,
};
pub use self::world::{
    DefaultPhysicsWorld, Gravity, InWorld, PhysicsOrder, PhysicsTime, PhysicsWorld,
};

pub use drystone;
