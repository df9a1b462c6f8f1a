//! Quickhull: points to [`Hull`].

use super::{Hull, HullError};
use crate::base::math::Vec3;

pub(super) fn quickhull(points: &[Vec3], max_vertices: usize) -> Result<Hull, HullError> {
    let _ = max_vertices;
    Err(HullError::TooFewPoints(points.len()))
}
