//! The names that most programs need: `use bevy_drystone::prelude::*;`

pub use crate::{
    AngularDamping, AngularVelocity, CharacterMover, CharacterSettings, Cloth, Collider,
    ColliderDensity, ColliderDisabled, CollidingEntities, CollisionEnd, CollisionHit,
    CollisionLayers, CollisionStart, ConstantForce, ConstantTorque, DistanceJoint, DrystonePlugin,
    FixedJoint, Forces, Fracture, Fractured, Friction, Gravity, GravityScale, InWorld, JointBroke,
    JointCollisionEnabled, JointDisabled, JointLimits, JointMotor, JointSpringiness, JointStrength,
    KineticFriction, LinearDamping, LinearVelocity, LockedAxes, Mass, MassProperties,
    NoInterpolation, OneWay, ParticlePositions, PhysicsFault, PhysicsOrder, PhysicsSystems,
    PhysicsTime, PhysicsWorld, PrismaticJoint, RayCaster, RayHits, Restitution, RevoluteJoint,
    RigidBody, RigidBodyDisabled, RollingResistance, Rope, RopeEnd, RopeJoint, Sensor, SensorEnter,
    SensorExit, SensorSenses, ShapeCaster, ShapeHits, Sleeping, SleepingDisabled, SpatialQuery,
    SpatialQueryFilter, SphericalJoint, SpinningResistance, SurfaceVelocity,
};
