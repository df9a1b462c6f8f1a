//! Layer 0: numbers, ids, containers, lanes, the worker team. Independent of physics.

pub mod limits;
pub(crate) mod math;
pub(crate) mod double;
pub(crate) mod quat;
pub(crate) mod pose;
#[cfg(any(feature = "glam", feature = "mint"))]
mod convert;
pub(crate) mod sym3;
pub(crate) mod collision;
pub(crate) mod aabb;
pub mod trig;
pub(crate) mod id;
pub(crate) mod slot_map;
pub(crate) mod sparse;
pub(crate) mod bit_set;
pub(crate) mod pair_set;
pub(crate) mod hash;
pub(crate) mod random;
pub(crate) mod grow;
pub(crate) mod copy;
pub(crate) mod simd;
pub(crate) mod threads;
