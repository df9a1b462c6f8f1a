//! drystone: a real-time 3D rigid-body physics engine.
#![allow(dead_code, reason = "under construction")]

mod base;
mod geometry;
mod state;
mod step;
mod query;
mod world;

pub use base::aabb::Aabb;
pub use base::id::{BodyId, JointId, ShapeId};
pub use base::jobs::{Executor, Inline};
pub use base::math::{Mat3, Vec3, vec3};
pub use base::pose::Pose;
pub use base::quat::Quat;
pub use base::sym3::Sym3;
pub use base::team::Team;
pub use base::trig;
pub use base::wide::SimdLevel;
pub use geometry::hull::{Hull, HullError, Plane};
pub use geometry::mass::MassProperties;
pub use geometry::mesh::{Mesh, MeshError};
pub use geometry::shape::{Shape, ShapeError};
pub use query::{Query, RayHit};
pub use state::config::{ContactConfig, JointConfig, SleepConfig, WorldConfig};
pub use state::def::{
    AxisLocks, BodyDef, BodyKind, DefError, JointDef, JointKind, MassDef, ShapeDef, Spring,
};
pub use state::events::{ContactEvent, Events, Fault, FaultKind, HitEvent, SensorEvent};
pub use state::material::{Combine, Filter, Material};
pub use state::method::{Method, Pass};
pub use step::Stage;
pub use world::{
    BodyMut, BodyRef, ContactPoint, ContactRef, JointRef, ShapeRef, World, WorldCounts,
};
