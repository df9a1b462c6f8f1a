//! Two convex shapes: distance, penetration, separating axes, clipping.

pub(crate) mod sat;
pub(crate) mod clip;
pub(crate) mod gjk;
pub(crate) mod epa;
