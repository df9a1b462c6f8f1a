//! Definitions of bodies, shapes and joints, and their validation.

pub use super::body_def::{AxisLocks, BodyDef, BodyKind, MassDef};
pub(crate) use super::check::{
    all_within, at_least_zero, finite_vec, position, unit, velocity, within,
};
pub use super::error::{DefError, DefErrorKind};
pub use super::fracture::Fracture;
pub use super::glue::{Bond, BondStrength, Glue};
pub use super::joint_def::{
    Fatigue, JointDef, JointKind, JointStrength, Pulley, Spring, WorldAxes,
};
pub use super::shape_def::ShapeDef;
pub(crate) use super::shape_def::{check_front, check_shape, shape_suits};
