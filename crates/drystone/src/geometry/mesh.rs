//! Triangle meshes and their bounding volume hierarchy.

use super::bvh::Bvh;
use crate::base::aabb::Aabb;
use crate::base::math::Vec3;

/// A triangle mesh that does not deform. Any winding; both sides are solid.
#[derive(Clone, Debug)]
pub struct Mesh {
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    bvh: Bvh,
    bounds: Aabb,
}

/// Why a mesh was refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// No triangle, or none with an area.
    NoTriangles,
    /// A triangle names a vertex that is not there: triangle and vertex number.
    IndexOutOfRange {
        /// Number of the triangle.
        triangle: usize,
        /// The vertex number it names.
        vertex: u32,
    },
    /// A coordinate is infinite or NaN; the number of the vertex.
    NotFinite(usize),
    /// A coordinate is larger than 1e7 m; the number of the vertex.
    TooLarge(usize),
}

impl core::fmt::Display for MeshError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoTriangles => write!(f, "the mesh has no triangle with an area"),
            Self::IndexOutOfRange { triangle, vertex } => {
                write!(f, "triangle {triangle} names vertex {vertex}, which is not there")
            }
            Self::NotFinite(i) => write!(f, "vertex {i} is not finite"),
            Self::TooLarge(i) => write!(f, "vertex {i} has a coordinate beyond 1e7 m"),
        }
    }
}

impl core::error::Error for MeshError {}

impl Mesh {
    /// A mesh of `vertices` [m, local] and `triangles`, n × 3 vertex numbers of any winding. Unused
    /// vertices are allowed; duplicate and zero-area triangles are left out.
    ///
    /// # Errors
    /// See [`MeshError`].
    pub fn new(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError::NoTriangles);
        }
        let boxes: Vec<Aabb> =
            triangles.iter().map(|t| Aabb::of_points(t.map(|i| vertices[i as usize]))).collect();
        let bvh = Bvh::build(&boxes);
        let bounds = Aabb::of_points(vertices.iter().copied());
        Ok(Self { vertices, triangles, bvh, bounds })
    }

    /// The vertices [m, local].
    #[must_use]
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// The triangles that were kept, n × 3 vertex numbers.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The smallest box around the triangles [m, local].
    #[must_use]
    pub const fn bounds(&self) -> Aabb {
        self.bounds
    }

    pub(crate) const fn bvh(&self) -> &Bvh {
        &self.bvh
    }
}
