//! Bodies for files without physics: one for each node with a mesh.

use drystone::{BodyDef, BodyKind, MassDef, Shape, ShapeDef, Vec3};

use super::AutoColliders;
use super::geometry::{Geometry, stretch};
use super::json::At;
use super::mesh::Triangles;
use super::nodes::Tree;
use super::physics::Found;
use super::read::Document;
use crate::error::SceneError;

/// A node's own mesh, in its frame. Not its triangles: many nodes may have the same large mesh.
struct Part<'a> {
    node: usize,
    at: At<'a>,
    bounds: Result<ShapeDef, String>,
    /// Lowest point along `up` [m].
    low: f32,
}

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
    let mut parts = Vec::new();
    for &node in &tree.order {
        let Some(at) = list[node].get("mesh") else { continue };
        if !tree.nodes[node].in_scene {
            continue;
        }
        let mut triangles = Triangles::default();
        triangles.add_mesh(document, &at, &stretch(&tree.nodes[node]), notes)?;
        let pose = tree.nodes[node].pose;
        let low = triangles.points.iter().map(|p| up.dot(pose.point(*p))).fold(f32::MAX, f32::min);
        parts.push(Part { node, at, bounds: bounding_box(&triangles), low });
    }
    let lowest = (0..parts.len()).min_by(|&a, &b| parts[a].low.total_cmp(&parts[b].low));
    let fixed = if parts.len() > 1 { lowest } else { None };
    let mut geometry = Geometry::new(document, tree)?;
    let mut found = Vec::new();
    for (i, part) in parts.into_iter().enumerate() {
        let kind = if Some(i) == fixed { BodyKind::Static } else { BodyKind::Dynamic };
        let name = tree.name(part.node);
        let made = match how {
            AutoColliders::Box => {
                part.bounds.map(|s| vec![s]).map_err(|p| part.at.error(p, "a mesh with a size"))
            }
            AutoColliders::Hull | AutoColliders::Mesh => {
                // The lowest is the ground: a hull would fill its hollows.
                let hull = how == AutoColliders::Hull && kind == BodyKind::Dynamic;
                let owner = &tree.nodes[part.node];
                geometry
                    .mesh(&part.at, owner, hull, kind, &name, notes)
                    .map(|shapes| shapes.into_iter().map(ShapeDef::new).collect())
            }
        };
        let shapes = match made {
            Ok(shapes) => shapes,
            // Decoration without volume is common in such files; it is no reason to refuse them.
            Err(e) => {
                notes.push(format!("{name}: left out: {}", e.problem()));
                continue;
            }
        };
        let pose = tree.nodes[part.node].pose;
        let def = BodyDef { kind, mass: MassDef::FromShapes, shapes, ..BodyDef::dynamic() };
        let def = def.with_position(pose.position).with_rotation(pose.rotation);
        found.push(Found { node: part.node, def });
    }
    Ok(found)
}

/// The smallest box around the points along the node's axes.
fn bounding_box(triangles: &Triangles) -> Result<ShapeDef, String> {
    let mut points = triangles.points.iter().copied();
    let first = points.next().ok_or("the mesh has no triangles")?;
    let (low, high) = points.fold((first, first), |(l, h), p| (l.min(p), h.max(p)));
    let half = (high - low) * 0.5;
    let half = half.max(Vec3::splat(0.005 * half.max_element()));
    let shape = Shape::box_half(half);
    shape.validate().map_err(|e| e.to_string())?;
    Ok(ShapeDef::new(shape).with_position((low + high) * 0.5))
}
