//! Bodies for documents without physics: one for each node with a mesh.

use drystone::{ShapeDef, Vec3};

use super::document::Document;
use super::geometry::{Geometry, stretch};
use super::nodes::Tree;
use super::physics::Found;
use crate::error::SceneError;
use crate::read::auto::{self, AutoColliders, Candidate};
use crate::read::json::At;
use crate::read::mesh::{Solid, Triangles};

/// Makes each node with a mesh a dynamic body, except the one that reaches lowest against `up`,
/// which is static (if there is more than one).
pub(crate) fn bodies(
    document: &Document,
    tree: &Tree,
    how: AutoColliders,
    up: Vec3,
    notes: &mut Vec<String>,
) -> Result<Vec<Found>, SceneError> {
    let root = At::root(&document.json);
    let list = root.list("nodes")?;
    let mut meshes = Vec::new();
    let mut candidates = Vec::new();
    for &node in &tree.order {
        let Some(at) = list[node].get("mesh") else { continue };
        if !tree.nodes[node].in_scene {
            continue;
        }
        let mut triangles = Triangles::default();
        triangles.add_mesh(document, &at, &stretch(&tree.nodes[node]), notes)?;
        candidates.push(Candidate::new(&triangles, tree.nodes[node].pose, up));
        meshes.push((node, at));
    }
    let kinds = auto::kinds(&candidates);
    let mut geometry = Geometry::new(document, tree)?;
    let mut found = Vec::new();
    for (((node, at), candidate), kind) in meshes.into_iter().zip(candidates).zip(kinds) {
        let name = tree.name(node);
        let made = match how.solid(kind) {
            None => {
                candidate.bounds.map(|s| vec![s]).map_err(|p| at.error(p, "a mesh with a size"))
            }
            Some(solid) => {
                let owner = &tree.nodes[node];
                geometry
                    .mesh(&at, owner, solid == Solid::Hull, kind, &name, notes)
                    .map(|shapes| shapes.into_iter().map(ShapeDef::new).collect())
            }
        };
        match made {
            Ok(shapes) => {
                found.push(Found { node, def: auto::body(kind, tree.nodes[node].pose, shapes) });
            }
            // Decoration without volume is common in such files; it is no reason to refuse them.
            Err(e) => notes.push(format!("{name}: left out: {}", e.problem())),
        }
    }
    Ok(found)
}
