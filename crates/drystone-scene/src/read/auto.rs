//! Bodies for files without physics: one for each mesh.

use drystone::{BodyDef, BodyKind, MassDef, Pose, ShapeDef, Vec3};

use super::mesh::{Solid, Triangles};

/// How to make bodies from meshes in files without physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AutoColliders {
    /// The convex hull of each mesh.
    Hull,
    /// The mesh itself; hulls it is decomposed into where the body moves.
    Mesh,
    /// The bounding box of each mesh, along its node's axes.
    Box,
}

impl AutoColliders {
    /// The solid of a mesh on a body of a kind; `None`: its bounding box.
    pub(crate) fn solid(self, kind: BodyKind) -> Option<Solid> {
        match (self, kind) {
            (Self::Box, _) => None,
            (Self::Hull, BodyKind::Dynamic) => Some(Solid::Hull),
            (Self::Mesh, BodyKind::Dynamic) => Some(Solid::Hulls),
            // The lowest mesh is the ground: a hull would fill its hollows.
            (Self::Hull | Self::Mesh, _) => Some(Solid::Mesh),
        }
    }
}

/// A mesh that becomes a body. It does not keep its triangles: many nodes may have one large mesh.
pub(crate) struct Candidate {
    /// Its bounding box, or why it has none.
    pub(crate) bounds: Result<ShapeDef, String>,
    /// Lowest point along the direction that is up [m].
    low: f32,
}

impl Candidate {
    /// The candidate of a mesh at a pose.
    pub(crate) fn new(triangles: &Triangles, pose: Pose, up: Vec3) -> Self {
        let heights = triangles.points.iter().map(|p| up.dot(pose.point(*p)));
        Self { bounds: triangles.bounding_box(), low: heights.fold(f32::MAX, f32::min) }
    }
}

/// The kinds of the bodies: dynamic but for the one that reaches lowest, which is static if there
/// is more than one.
pub(crate) fn kinds(candidates: &[Candidate]) -> Vec<BodyKind> {
    let lowest = (0..candidates.len())
        .min_by(|&a, &b| candidates[a].low.total_cmp(&candidates[b].low))
        .filter(|_| candidates.len() > 1);
    let kind = |i| if Some(i) == lowest { BodyKind::Static } else { BodyKind::Dynamic };
    (0..candidates.len()).map(kind).collect()
}

/// The body of a mesh at a pose, with these shapes.
pub(crate) fn body(kind: BodyKind, pose: Pose, shapes: Vec<ShapeDef>) -> BodyDef {
    let def = BodyDef { kind, mass: MassDef::FromShapes, shapes, ..BodyDef::dynamic() };
    def.with_position(pose.position).with_rotation(pose.rotation)
}

/// The summary of a scene of these bodies.
pub(crate) fn summary<'a>(bodies: impl ExactSizeIterator<Item = &'a BodyDef>) -> String {
    let count = bodies.len();
    let moving = bodies.filter(|def| def.kind != BodyKind::Static).count();
    format!("{count} bodies, {moving} of them moving")
}
