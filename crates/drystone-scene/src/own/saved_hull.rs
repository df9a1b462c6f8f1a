//! Hulls with all that the engine saves of them.

use drystone::geometry::Plane;
use drystone::{Hull, Vec3};
use serde::{Deserialize, Serialize};

/// A hull as the engine saves it.
#[derive(Serialize, Deserialize)]
pub(super) struct SavedHull {
    pub(super) vertices: Vec<Vec3>,
    pub(super) planes: Vec<Plane>,
    pub(super) faces: Vec<Vec<u16>>,
    pub(super) cuboid: Option<Vec3>,
}

impl SavedHull {
    /// Whether both have the same bits.
    pub(super) fn has_bits_of(&self, other: &Self) -> bool {
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        let all = |list: &[Vec3]| list.iter().map(|v| bits(*v)).collect::<Vec<_>>();
        let planes = |list: &[Plane]| {
            list.iter().map(|p| (bits(p.normal), p.offset.to_bits())).collect::<Vec<_>>()
        };
        self.faces == other.faces
            && all(&self.vertices) == all(&other.vertices)
            && planes(&self.planes) == planes(&other.planes)
    }

    /// The hull.
    pub(super) fn hull(&self) -> Result<Hull, String> {
        let value = serde_json::to_value(self).map_err(|e| e.to_string())?;
        serde_json::from_value(value).map_err(|e| e.to_string())
    }
}
