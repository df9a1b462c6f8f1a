//! Triangles of the meshes of a document.

use super::accessor;
use super::document::Document;
use super::nodes::Tree;
use crate::error::SceneError;
use crate::read::json::At;
use crate::read::mesh::Triangles;
use crate::transform::Affine;

/// The corners of each triangle, as places in a list of `count` of them; `mode` is 4 for triangles,
/// 5 for strips, 6 for fans.
pub(super) fn corners(mode: usize, count: usize) -> impl Iterator<Item = [usize; 3]> {
    let triangles = if mode == 4 { count / 3 } else { count.saturating_sub(2) };
    (0..triangles).map(move |t| match mode {
        4 => [3 * t, 3 * t + 1, 3 * t + 2],
        5 if t.is_multiple_of(2) => [t, t + 1, t + 2],
        5 => [t + 1, t, t + 2],
        _ => [0, t + 1, t + 2],
    })
}

impl Triangles {
    /// Adds those of mesh `mesh`, mapped by `map`; says what was left out.
    pub(crate) fn add_mesh(
        &mut self,
        document: &Document,
        mesh: &At<'_>,
        map: &Affine,
        notes: &mut Vec<String>,
    ) -> Result<(), SceneError> {
        let mesh = At::root(&document.json).entry("meshes", mesh)?;
        for primitive in mesh.need("primitives")?.items()? {
            self.add_primitive(document, &primitive, map, notes)?;
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        document: &Document,
        at: &At<'_>,
        map: &Affine,
        notes: &mut Vec<String>,
    ) -> Result<(), SceneError> {
        for compressed in ["KHR_draco_mesh_compression", "EXT_meshopt_compression"] {
            if let Some(e) = at.dig(&["extensions", compressed]) {
                return Err(e.error("it is compressed", "a mesh without compression"));
            }
        }
        let mode = at.get("mode").map_or(Ok(4), |m| m.size())?;
        if !(4..=6).contains(&mode) {
            notes
                .push(format!("{}: points and lines are left out of collision shapes", at.place()));
            return Ok(());
        }
        if at.get("targets").is_some() {
            notes.push(format!(
                "{}: morph targets are not applied to the collision shape",
                at.place()
            ));
        }
        let position = at.need("attributes")?.need("POSITION")?;
        let points = accessor::positions(document, &position)?;
        let list = match at.get("indices") {
            Some(i) => accessor::indices(document, &i, points.len())?,
            None => (0..u32::try_from(points.len()).unwrap_or(0)).collect(),
        };
        let base = u32::try_from(self.points.len())
            .ok()
            .filter(|b| b.checked_add(u32::try_from(points.len()).unwrap_or(u32::MAX)).is_some())
            .ok_or_else(|| position.error("there are too many vertices", "below 2³²"))?;
        self.points.extend(points.iter().map(|p| map.point(*p)));
        let moved = |t: [usize; 3]| t.map(|i| base + list[i]);
        self.triangles.extend(corners(mode, list.len()).map(moved));
        Ok(())
    }

    /// Adds the meshes of a node and of all below it, in that node's own frame, mapped by `map`.
    pub(crate) fn add_node(
        &mut self,
        document: &Document,
        tree: &Tree,
        node: usize,
        map: &Affine,
        notes: &mut Vec<String>,
    ) -> Result<(), SceneError> {
        let root = At::root(&document.json);
        let mut stack = vec![(node, *map)];
        while let Some((n, map)) = stack.pop() {
            let Some(at) = root.nth("nodes", n) else { continue };
            document.work.add(1, &at)?;
            if let Some(mesh) = at.get("mesh") {
                self.add_mesh(document, &mesh, &map, notes)?;
                if at.get("skin").is_some() {
                    notes.push(format!(
                        "{}: its skin is not applied to the collision shape",
                        tree.name(n)
                    ));
                }
            }
            let inner = tree.nodes[n].children.iter().rev();
            stack.extend(inner.map(|&c| (c, map.compose(&tree.nodes[c].local))));
        }
        Ok(())
    }
}
