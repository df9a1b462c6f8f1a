//! A real-time 3D rigid-body physics engine, named for walls that stand without mortar, by stacking and
//! friction alone. Deterministic by construction: the same calls give the same bits for any number of
//! threads, any SIMD level, in debug and release.
//!
//! ```
//! use drystone::{BodyDef, ShapeDef, World};
//!
//! fn main() -> Result<(), drystone::DefError> {
//!     // All cores; without it, the caller's thread alone. The results are the same.
//!     let mut world = World::default().with_threads(0);
//!     world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
//!     let ball = BodyDef::dynamic().with_position([0.0, 4.0, 0.0]);
//!     let ball = world.add_body(ball.with_shape(ShapeDef::sphere(0.5)))?;
//!     for _ in 0..120 {
//!         world.step(1.0 / 60.0);
//!     }
//!     println!("{:?}", world.body(ball).map(|b| b.position()));
//!     Ok(())
//! }
//! ```
//!
//! Units are SI: meters, kilograms, seconds, radians. Vectors and quaternions are taken as arrays or as
//! [`Vec3`] and [`Quat`]. A [`World`] owns everything; ids name what is in it and stay valid until it is
//! removed. Definitions are checked when they are given: nothing a user passes can panic, and
//! [`World::step`] cannot fail.
//!
//! The step is nine stages over tables; `ARCHITECTURE.md` of the repository shows them.

mod base;
mod geometry;
mod state;
mod step;
mod query;
mod world;

pub use base::aabb::Aabb;
pub use base::collision::ImpactKind;
pub use base::id::{BodyId, JointId, LinkId, ParticleId, ShapeId};
pub use base::jobs::{Executor, Inline};
pub use base::limits;
pub use base::math::{Mat3, Vec3, vec3};
pub use base::pose::Pose;
pub use base::quat::Quat;
pub use base::sym3::Sym3;
pub use base::team::Team;
pub use base::trig;
pub use base::wide::SimdLevel;
pub use geometry::cells::{CutError, HullPiece};
pub use geometry::hull::{Hull, HullError, Plane};
pub use geometry::mass::MassProperties;
pub use geometry::mesh::{Mesh, MeshError};
pub use geometry::shape::{Shape, ShapeError};
pub use query::Query;
pub use query::audit::{
    Audit, ConeUse, ConstraintId, ContactPair, ContactResidual, Energy, JointErrors, Ledger,
    Momentum, Penetration, WorstConstraint,
};
pub use query::cast::{Motion, ShapeHit, ShapeQuery};
pub use query::filter::{BodyKinds, Inside, QueryFilter};
pub use query::nearest::NearestShape;
pub use query::pair::{CastHit, ClosestPoints, ShapeContact, ShapeContactPoint};
pub use query::ray::{RayHit, RayQuery};
pub use query::shape::ShapeRef;
pub use query::stiffness::PenaltyLimit;
pub use query::why_awake::{AwakeCause, WhyAwake};
pub use state::axis::Axis;
pub use state::config::{
    BreakageConfig, ContactConfig, InertiaConfig, JointConfig, ParticleConfig, ParticleForm,
    PenaltyConfig, SleepConfig, WorldConfig,
};
pub use state::coupling::CouplingDef;
pub use state::def::{
    AxisLocks, BodyDef, BodyKind, Bond, BondStrength, DefError, Fatigue, Fracture, Glue, JointDef,
    JointKind, JointStrength, MassDef, ShapeDef, WorldAxes,
};
pub use state::events::{
    BondBreak, ContactEvent, ContactForce, Events, Fault, FaultKind, ForcePoint, FractureCause,
    FractureEvent, HitEvent, JointBreak, JointLimit, LinkTear, SensorEvent,
};
pub use state::material::{Combine, ContactSoftness, Filter, Material, SurfaceRule};
pub use state::method::{Method, Pass};
pub use state::options::{
    Damping, Integration, MethodOptions, Order, Overlap, Persistence, Rest, Shock,
};
pub use state::particle_def::{LinkDef, LinkKind, LinkSpring, ParticleDef};
pub use state::reports::{ContactReports, Senses};
pub use state::sixdof::{JointAxis, JointCone, JointDrive, JointMotion, JointSpring, SixDof};
pub use step::Stage;
pub use step::hooks::{ContactHooks, HookedContact};
pub use world::{
    Answer, AxisCall, AxisMut, AxisRef, BodyCall, BodyMut, BodyRef, BondRef, Call, Clock, ClothDef,
    ContactPoint, ContactRef, DebugColor, DebugDraw, DebugDrawOptions, DebugTint, DeltaError,
    Difference, GeometryKey, Impact, ImpactBody, ImpactSurface, JointCall, JointMut, JointRef,
    Journal, JournalError, Library, LinkRef, Moved, Mover, MoverHit, ParticleCall, ParticleMut,
    ParticleRef, RopeDef, ShapeCall, ShapeMut, SnapshotError, Strand, World, WorldCounts,
    apply_delta, impact, write_delta,
};

pub mod joint {
    #![doc = include_str!("joints.md")]

    pub use crate::state::def::{Pulley, Spring};
    pub use crate::state::named::{
        Ball, ConeTwist, Cylindrical, Distance, Fixed, Hinge, Planar, Rope, Servo, Slider,
        Universal, Wheel,
    };
}
