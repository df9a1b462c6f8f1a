//! Registration of types for reflection.

use bevy_app::App;

use crate::body::{
    AngularDamping, AngularVelocity, ConstantForce, ConstantTorque, GravityScale, LinearDamping,
    LinearVelocity, LockedAxes, Mass, MassProperties, NoInterpolation, RigidBody,
    RigidBodyDisabled, SleepThreshold, Sleeping, SleepingDisabled,
};
use crate::collider::Collider;
use crate::events::{
    CollidingEntities, CollisionEnd, CollisionHit, CollisionStart, JointBroke, PhysicsFault,
    SensorEnter, SensorExit,
};
use crate::fracture::{Fracture, Fractured};
use crate::joint::{
    DistanceJoint, FixedJoint, JointCollisionEnabled, JointDisabled, JointStrength, PrismaticJoint,
    RevoluteJoint, RopeJoint, SphericalJoint,
};
use crate::strand::{Cloth, ParticlePositions, Rope};
use crate::surface::{
    ActiveCollisionHooks, ColliderDensity, ColliderDisabled, CollisionLayers, Friction, HitSpeed,
    KineticFriction, OneWay, Restitution, RollingResistance, Sensor, SensorSenses,
    SpinningResistance, SurfaceVelocity,
};
use crate::world::{DefaultPhysicsWorld, Gravity, InWorld, PhysicsOrder, PhysicsTime};

/// Registers all components, resources and events.
pub(crate) fn register_types(app: &mut App) {
    app.register_type::<RigidBody>()
        .register_type::<RigidBodyDisabled>()
        .register_type::<LinearVelocity>()
        .register_type::<AngularVelocity>()
        .register_type::<Mass>()
        .register_type::<MassProperties>()
        .register_type::<LinearDamping>()
        .register_type::<AngularDamping>()
        .register_type::<GravityScale>()
        .register_type::<LockedAxes>()
        .register_type::<ConstantForce>()
        .register_type::<ConstantTorque>()
        .register_type::<Sleeping>()
        .register_type::<SleepingDisabled>()
        .register_type::<SleepThreshold>()
        .register_type::<NoInterpolation>()
        .register_type::<Fracture>();
    app.register_type::<Collider>()
        .register_type::<ColliderDensity>()
        .register_type::<ColliderDisabled>()
        .register_type::<ActiveCollisionHooks>()
        .register_type::<CollisionLayers>()
        .register_type::<Friction>()
        .register_type::<KineticFriction>()
        .register_type::<RollingResistance>()
        .register_type::<SpinningResistance>()
        .register_type::<Restitution>()
        .register_type::<HitSpeed>()
        .register_type::<OneWay>()
        .register_type::<Sensor>()
        .register_type::<SensorSenses>()
        .register_type::<SurfaceVelocity>()
        .register_type::<CollidingEntities>();
    app.register_type::<FixedJoint>()
        .register_type::<RevoluteJoint>()
        .register_type::<PrismaticJoint>()
        .register_type::<SphericalJoint>()
        .register_type::<DistanceJoint>()
        .register_type::<RopeJoint>()
        .register_type::<JointStrength>()
        .register_type::<JointDisabled>()
        .register_type::<JointCollisionEnabled>();
    app.register_type::<Rope>().register_type::<Cloth>().register_type::<ParticlePositions>();
    app.register_type::<InWorld>()
        .register_type::<PhysicsOrder>()
        .register_type::<Gravity>()
        .register_type::<PhysicsTime>()
        .register_type::<DefaultPhysicsWorld>()
        .register_type::<CollisionStart>()
        .register_type::<CollisionEnd>()
        .register_type::<CollisionHit>()
        .register_type::<SensorEnter>()
        .register_type::<SensorExit>()
        .register_type::<JointBroke>()
        .register_type::<Fractured>()
        .register_type::<PhysicsFault>();
}
