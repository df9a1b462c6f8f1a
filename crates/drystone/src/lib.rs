//! A real-time 3D rigid-body physics engine, named for walls that stand without mortar, by stacking
//! and friction alone. Deterministic by construction: the same calls give the same bits for any
//! number of threads, any SIMD level, in debug and release.
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
//! Units are SI: meters, kilograms, seconds, radians. Vectors and quaternions are taken as arrays
//! or as [`Vec3`] and [`Quat`]. A [`World`] owns everything; an id names an object in it, and stays
//! valid until that object is removed. Definitions are checked when they are given: no argument of
//! a user can cause a panic, and [`World::step`] cannot fail.
//!
//! The [`manual`] has a chapter for each part, with examples: [first steps](manual::first_steps),
//! [bodies](manual::bodies), [shapes](manual::shapes), [materials](manual::materials),
//! [joints](manual::joints), [events](manual::events), [queries](manual::queries),
//! [tuning](manual::tuning) and others.
//!
//! # Features
//!
//! - `snapshot` (default): worlds as bytes, deltas, journals of calls; with `serde`.
//! - `serde`: definitions, ids, events and numbers are `Serialize` and `Deserialize`.
//! - `glam`, `mint`: conversions of vectors, rotations and matrices from and into their types.
//!
//! The step is ten stages over tables; `ARCHITECTURE.md` of the repository shows them.

#![cfg_attr(
    not(feature = "snapshot"),
    expect(dead_code, reason = "tables are checked against each other when they come from bytes")
)]

mod base;
mod reduced;
pub mod geometry;
/// The manual: a chapter for each part of the engine, with examples that run.
pub mod manual;
mod state;
mod step;
pub mod query;
mod world;

pub use self::state::def::axis::Axis;
pub use self::state::def::config::WorldConfig;
pub use self::state::def::material::{Filter, Material};
pub use base::id::{BodyId, JointId, ShapeId};
pub use base::limits;
pub use base::math::{Vec3, vec3};
pub use base::pose::Pose;
pub use base::quat::Quat;
pub use geometry::hull::Hull;
pub use geometry::mesh::Mesh;
pub use geometry::shape::Shape;
pub use query::shape::ShapeRef;
pub use state::def::{
    AxisLocks, BodyDef, BodyKind, DefError, DefErrorKind, JointDef, JointKind, MassDef, ShapeDef,
    WorldAxes,
};
pub use step::Stage;
pub use world::{
    BodyMut, BodyRef, Clock, JointMut, JointRef, ShapeMut, StageHashes, World, WorldCounts,
};

pub mod math {
    //! Numbers besides [`Vec3`](crate::Vec3), [`Quat`](crate::Quat) and [`Pose`](crate::Pose), and
    //! the trigonometry that gives the same bits everywhere.

    pub use crate::base::math::Mat3;
    pub use crate::base::sym3::Sym3;
    pub use crate::base::trig;
}

pub mod config {
    //! The parts of a [`WorldConfig`](crate::WorldConfig). The manual:
    //! [tuning](crate::manual::tuning).

    pub use crate::state::def::config::{
        BreakageConfig, ContactConfig, InertiaConfig, JointConfig, ParticleConfig, ParticleForm,
        PenaltyConfig, SleepConfig,
    };
}

pub mod method {
    //! How a step solves contacts and joints: [`WorldConfig::method`](crate::WorldConfig::method).
    //! The manual: [methods](crate::manual::methods).

    pub use crate::state::def::method::{Method, Pass};
    pub use crate::state::def::options::{
        Damping, Integration, MethodOptions, Order, Overlap, Persistence, Rest, Shock,
    };
}

pub mod contact {
    //! Contacts at rest and in motion, and rules that decide which contacts exist and how they act.
    //! The manual: [materials](crate::manual::materials).

    pub use crate::state::def::material::{Combine, ContactSoftness, SurfaceRule};
    pub use crate::step::hooks::{ContactHooks, HookedContact};
    pub use crate::world::{ContactPoint, ContactRef};
}

pub mod events {
    //! Events and faults of a step: [`World::events`](crate::World::events). The manual:
    //! [events](crate::manual::events).

    pub use crate::state::def::reports::{ContactReports, Senses};
    pub use crate::state::events::{
        BondBreak, ContactEvent, ContactForce, Events, Fault, FaultKind, ForcePoint, FractureCause,
        FractureEvent, FrameCall, HitEvent, JointBreak, JointLimit, LinkTear, SensorEvent,
    };
}

pub mod joint {
    //! Joints by name: their kinds, their axes, and what drives them. The chapter
    //! [`joints`](crate::manual::joints) of the manual shows how to use them.

    pub use crate::state::coupling::CouplingDef;
    pub use crate::state::def::named::{
        Ball, ConeTwist, Cylindrical, Distance, Fixed, Hinge, Planar, Rope, Servo, Slider,
        Universal, Wheel,
    };
    pub use crate::state::def::six_dof::{
        JointAxis, JointCone, JointDrive, JointMotion, JointSpring, SixDof,
    };
    pub use crate::state::def::{Pulley, Spring};
    pub use crate::world::{AxisMut, AxisRef};
}

pub mod articulation {
    //! Trees of links in reduced coordinates: robots, chains, mechanisms.
    //!
    //! The state of a tree is one number for each angle or displacement of a joint, so joints
    //! cannot drift. An [`Articulation`] has forward kinematics, Jacobians, mass matrix, bias
    //! forces, inverse and forward dynamics, and a step that gives no passive tree energy.
    //!
    //! ```
    //! use drystone::articulation::{Articulation, LinkDef, TreeDef, TreeJoint};
    //!
    //! # fn main() -> Result<(), drystone::articulation::TreeError> {
    //! // A pendulum: 1 kg at 0.5 m below a hinge about y, 0.1 m in size.
    //! let bob = LinkDef::on(None)
    //!     .with_joint(TreeJoint::hinge([0.0, 1.0, 0.0]))
    //!     .with_mass(1.0, [0.0, 0.0, -0.5], [0.004, 0.004, 0.004, 0.0, 0.0, 0.0]);
    //! let def = TreeDef { links: vec![bob], ..TreeDef::default() };
    //! let mut pendulum = Articulation::new(&def, [0.0, 0.0, -9.81])?;
    //! pendulum.set_state(&[0.1], &[0.0])?;
    //! // Half of its period, π √((0.25 + 0.004)/(9.81 · 0.5)) s, later it is on the other side.
    //! let half = core::f64::consts::PI * f64::sqrt(0.254 / (9.81 * 0.5));
    //! for _ in 0..100 {
    //!     pendulum.step(half / 100.0)?;
    //! }
    //! assert!((pendulum.q()[0] + 0.1).abs() < 1.0e-3);
    //! # Ok(())
    //! # }
    //! ```
    //!
    //! # Conventions
    //!
    //! Coordinates `q` and velocities `v` are those of MuJoCo: joint after joint, link after link.
    //! A hinge and a slide have one number in each; a ball four and three, a free joint seven and
    //! six. Quaternions have the real part first. Angular velocities of ball and free joints are in
    //! the link's axes, the linear velocity of a free joint in the world's. Generalized forces
    //! belong to `v`. A link with several joints has them in a row; a fixed link has none.
    //!
    //! # How it is computed
    //!
    //! Spatial vectors stand in world axes about the origin of the first link (`spatial.rs`). The
    //! mass matrix is made of composite bodies and factored along the branches as LᵀDL
    //! [Featherstone08] (`dynamics.rs`). Articulated bodies (`bodies.rs`) give the same
    //! accelerations. A step (`step.rs`) takes forces in the middle of the motion
    //! (`velocities.rs`), then restores momentum and energy (`conserve.rs`). All code is over
    //! numbers or lanes (`number.rs`), so the same tree in several worlds goes side by side with
    //! the same bits as alone.
    //!
    //! # Rows
    //!
    //! Limits, friction, couplings, tendons and closures are rows (`row.rs`, `gather.rs`): w with
    //! impulse λ on whitened velocities y = √D L v. A row has up to two segments of y. A tree's
    //! segment is D^-½ L^-ᵀ Jᵀ, a free body's is J over √m and √I. So a contact of a tree with a
    //! tree, a body or the ground is a normal row and friction rows in the same sweep. The
    //! contact's Jacobian is that of its point along the normal (`fill_direction`).

    pub use crate::base::id::ArticulationId;
    pub use crate::reduced::{
        Articulation, LinkDef, RowSoftness, TreeCoupling, TreeDef, TreeError, TreeJoint,
        TreeJointKind, TreeLoop, TreeStepConfig, TreeTendon,
    };
    pub use crate::world::{ArticulationDef, ArticulationMut, ArticulationRef};
}

pub mod breakage {
    //! Breakage: joints and bonds with limited strength, and bodies that fracture on impact.
    //! The manual: [breakage](crate::manual::breakage).

    pub use crate::state::def::{Bond, BondStrength, Fatigue, Fracture, Glue, JointStrength};
    pub use crate::world::BondRef;
}

pub mod particle {
    //! Particles: ropes, cloths and dust. The manual: [particles](crate::manual::particles).

    pub use crate::base::id::{LinkId, ParticleId};
    pub use crate::state::def::particle_def::{LinkDef, LinkKind, LinkSpring, ParticleDef};
    pub use crate::world::{ClothDef, LinkMut, LinkRef, ParticleMut, ParticleRef, RopeDef, Strand};
}

pub mod mover {
    //! A character that walks, climbs steps and slides along walls. The manual:
    //! [character](crate::manual::character).

    pub use crate::world::{Moved, Mover, MoverHit};
}

pub mod impact {
    //! One collision of two bodies in isolation, by several laws.

    pub use crate::base::collision::ImpactKind;
    pub use crate::world::{Impact, ImpactBody, ImpactSurface, impact};
}

pub mod draw {
    //! Debug lines of a world, for a host with its own renderer:
    //! [`World::debug_draw`](crate::World::debug_draw).

    pub use crate::world::{DebugColor, DebugDraw, DebugDrawOptions, DebugTint};
}

pub mod audit {
    //! Accuracy measures of a world at a moment: energy, momentum, overlaps, residuals, causes.
    //! The manual: [audit](crate::manual::audit).

    pub use crate::query::audit::{
        Audit, ConeUse, ConstraintId, ContactPair, ContactResidual, Energy, JointErrors, Ledger,
        Momentum, Penetration, WorstConstraint,
    };
    pub use crate::query::stiffness::PenaltyLimit;
    pub use crate::query::why_awake::{AwakeCause, WhyAwake};
}

#[cfg(feature = "snapshot")]
pub mod snapshot {
    //! Saved worlds: as bytes, by reference to geometry, and as differences.
    //! The manual: [saving and rollback](crate::manual::saving_and_rollback).

    pub use crate::world::{
        DeltaError, GeometryKey, Library, SnapshotError, apply_delta, write_delta,
    };
}

#[cfg(feature = "snapshot")]
pub mod journal {
    //! Calls to a world as data, recorded and replayed.
    //! The manual: [saving and rollback](crate::manual::saving_and_rollback).

    pub use crate::world::{
        Answer, AxisCall, BodyCall, Call, Difference, JointCall, Journal, JournalError,
        ParticleCall, ShapeCall,
    };
}

pub mod threads {
    //! Threads of a step: the caller alone, a [`Team`], or an [`Executor`] of the host.
    //! The manual: [threads and determinism](crate::manual::threads_and_determinism).

    pub use crate::base::simd::wide::SimdLevel;
    pub use crate::base::threads::jobs::{Executor, Inline};
    pub use crate::base::threads::team::Team;
}
