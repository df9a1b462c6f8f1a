//! Definitions of bodies, shapes and joints, and their validation.

pub(crate) mod config;
pub(crate) mod options;
pub(crate) mod method;
pub(crate) mod check;
pub(crate) mod error;
pub(crate) mod body_def;
pub(crate) mod shape_def;
pub(crate) mod joint_def;
pub(crate) mod axis;
pub(crate) mod six_dof;
pub(crate) mod material;
pub(crate) mod reports;
pub(crate) mod named;
pub(crate) mod particle_def;
pub(crate) mod drives;

pub use self::body_def::{AxisLocks, BodyDef, BodyKind, MassDef};
pub(crate) use self::check::{
    all_within, at_least_zero, finite_vec, position, unit, velocity, within,
};
pub use self::error::{DefError, DefErrorKind};
pub use self::joint_def::{Fatigue, JointDef, JointKind, JointStrength, Pulley, Spring, WorldAxes};
pub use self::shape_def::ShapeDef;
pub(crate) use self::shape_def::{check_front, check_shape, shape_suits};
pub use super::fracture::Fracture;
pub use super::glue::{Bond, BondStrength, Glue};
