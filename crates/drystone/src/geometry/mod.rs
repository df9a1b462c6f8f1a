//! Geometry of shapes: boxes, hulls, masses, errors.
//! The manual: [shapes](crate::manual::shapes).
// Layer 1: shapes and everything computed from shapes alone. It uses no body and no time step.

pub(crate) mod shape;
pub(crate) mod solid;
pub(crate) mod mass;
pub(crate) mod hull;
pub(crate) mod cells;
pub(crate) mod flush;
pub(crate) mod mesh;
pub(crate) mod boxes;
pub(crate) mod bvh;
pub(crate) mod rtree;
pub(crate) mod manifold;
pub(crate) mod collide;
pub(crate) mod cast;
pub(crate) mod approach;
pub(crate) mod toi;
pub(crate) mod nearest;
pub(crate) mod room;
#[cfg(test)]
pub(crate) mod oracle;
pub(crate) mod convex;

pub use self::cells::{CutError, HullPiece};
pub use self::hull::{HullError, Plane};
pub use self::mass::MassProperties;
pub use self::mesh::MeshError;
pub use self::shape::ShapeError;
pub use crate::base::aabb::Aabb;
