//! The tests, one file per family.

pub(crate) mod casts;
pub(crate) mod flight;
pub(crate) mod friction;
pub(crate) mod geometry;
pub(crate) mod impact;
pub(crate) mod invariance;
pub(crate) mod joints;
pub(crate) mod mechanisms;
pub(crate) mod robots;
pub(crate) mod rolling;
pub(crate) mod rotation;
pub(crate) mod stacks;
