//! Meshes to look at: how many are read, and their normals where a file gives none.

use drystone::Vec3;

use crate::visual::{VisualMesh, VisualVertex};

/// Vertices of all meshes together; meshes beyond them are left out. A page in a browser has less
/// memory.
const MOST_VERTICES: usize = if cfg!(target_arch = "wasm32") { 1 << 22 } else { 1 << 24 };

/// Meshes for which there is room.
pub(crate) const ALLOWED: &str = "fewer or simpler meshes";

/// Room for the meshes of a scene.
#[derive(Debug, Default)]
pub(crate) struct Room {
    vertices: usize,
}

impl Room {
    /// Whether `more` vertices may come; otherwise the problem with a mesh that brings them.
    pub(crate) fn check(&self, more: usize) -> Result<(), String> {
        if self.vertices.saturating_add(more) <= MOST_VERTICES {
            return Ok(());
        }
        Err(format!("brings all meshes to more than {MOST_VERTICES} vertices"))
    }

    /// Counts a mesh.
    pub(crate) fn add(&mut self, mesh: &VisualMesh) {
        self.vertices += size(mesh.vertices.len(), mesh.indices.len());
    }
}

/// Vertices that a mesh counts for: few vertices may have many triangles, two for each are usual.
pub(crate) fn size(vertices: usize, indices: usize) -> usize {
    vertices.max(indices / 6)
}

/// The triangles with corners of their own that face as they do: for files without normals.
pub(crate) fn flat(
    vertices: &[VisualVertex],
    triangles: &[[u32; 3]],
    material: Option<usize>,
) -> VisualMesh {
    let mut all = Vec::with_capacity(3 * triangles.len());
    for triangle in triangles {
        let corners = triangle.map(|i| vertices[i as usize]);
        let [a, b, c] = corners.map(|corner| Vec3::from(corner.place));
        let normal = (b - a).cross(c - a).normalize_or(Vec3::Y).to_array();
        all.extend(corners.map(|corner| VisualVertex { normal, ..corner }));
    }
    let indices = (0_u32..).take(all.len()).collect();
    VisualMesh { vertices: all, indices, material }
}
