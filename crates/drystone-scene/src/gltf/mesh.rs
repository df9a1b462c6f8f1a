//! Triangles of glTF meshes, and what solid they make: mesh, hull, or several hulls.

use std::sync::Arc;

use drystone::{Hull, Mesh, Shape, Vec3};
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};

use super::accessor;
use super::json::At;
use super::nodes::{Affine, Tree};
use super::read::Document;
use crate::error::SceneError;

/// The corners of each triangle, as places in a list of `count` of them; `mode` is 4 for triangles, 5 for strips, 6 for fans.
pub(super) fn corners(mode: usize, count: usize) -> impl Iterator<Item = [usize; 3]> {
    let triangles = if mode == 4 { count / 3 } else { count.saturating_sub(2) };
    (0..triangles).map(move |t| match mode {
        4 => [3 * t, 3 * t + 1, 3 * t + 2],
        5 if t.is_multiple_of(2) => [t, t + 1, t + 2],
        5 => [t + 1, t, t + 2],
        _ => [0, t + 1, t + 2],
    })
}

/// Points and triangles [m].
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangles {
    pub(crate) points: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
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

    /// As a hull.
    pub(crate) fn hull(&self, at: &At<'_>) -> Result<Shape, SceneError> {
        let hull = Hull::from_points(&self.points)
            .map_err(|e| at.error(e, "points that span a volume"))?;
        Ok(Shape::Hull(Arc::new(hull)))
    }

    /// As a mesh.
    pub(crate) fn mesh(self, at: &At<'_>) -> Result<Shape, SceneError> {
        let mesh = Mesh::new(self.points, self.triangles)
            .map_err(|e| at.error(e, "a mesh with at least one triangle with an area"))?;
        Ok(Shape::Mesh(Arc::new(mesh)))
    }

    /// As one hull if the surface is convex and closed, else as several; with a line that says which.
    pub(crate) fn hulls(&self, at: &At<'_>) -> Result<(Vec<Shape>, String), SceneError> {
        let whole = Hull::from_points(&self.points)
            .map_err(|e| at.error(e, "points that span a volume"))?;
        if self.is_surface_of(&whole) {
            return Ok((
                vec![Shape::Hull(Arc::new(whole))],
                "taken as its hull, it is convex".to_owned(),
            ));
        }
        let parts: Vec<Shape> = self
            .decompose(&whole)
            .iter()
            .filter_map(|points| Hull::from_points_limited(points, 64).ok())
            .map(|hull| Shape::Hull(Arc::new(hull)))
            .collect();
        if parts.is_empty() {
            let note = "taken as its hull, it cannot be decomposed".to_owned();
            return Ok((vec![Shape::Hull(Arc::new(whole))], note));
        }
        let note = format!("decomposed into {} hulls, because the body is dynamic", parts.len());
        Ok((parts, note))
    }

    /// As a hull, if the surface is convex and closed.
    pub(crate) fn convex(&self) -> Option<Shape> {
        let hull = Hull::from_points(&self.points).ok().filter(|hull| self.is_surface_of(hull))?;
        Some(Shape::Hull(Arc::new(hull)))
    }

    /// True if all triangles lie on the surface of `hull` and cover nearly all of it.
    fn is_surface_of(&self, hull: &Hull) -> bool {
        let size = hull.bounds().half_extents().max_element();
        let depth =
            |p: Vec3| hull.planes().iter().map(|pl| -pl.distance(p)).fold(f32::MAX, f32::min);
        let mut area = 0.0;
        for t in &self.triangles {
            let [a, b, c] = t.map(|i| self.points[i as usize]);
            let middle = (a + b + c) * (1.0 / 3.0);
            if depth(middle) > 0.01 * size {
                return false;
            }
            area += 0.5 * (b - a).cross(c - a).length();
        }
        area >= 0.9 * hull_area(hull)
    }

    /// The points of convex parts: the voxel method of V-HACD, then the mesh's own surface inside each
    /// part, so that parts meet the mesh exactly and not voxels. The list is empty if the mesh cannot be decomposed. The library
    /// panics on some meshes, which counts as that.
    fn decompose(&self, whole: &Hull) -> Vec<Vec<Vec3>> {
        let bounds = whole.bounds();
        let (center, size) = (bounds.center(), bounds.half_extents().max_element());
        let into = 1.0 / size;
        let unit: Vec<_> = self
            .points
            .iter()
            .map(|p| {
                let q = (*p - center) * into;
                parry3d::math::Vector::new(q.x, q.y, q.z)
            })
            .collect();
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| self.points[i as usize] * into);
            (b - a).cross(c - a).length() > 1.0e-9
        };
        let triangles: Vec<[u32; 3]> = self.triangles.iter().copied().filter(area).collect();
        if triangles.is_empty() {
            return Vec::new();
        }
        let parameters = VHACDParameters { max_convex_hulls: 64, ..VHACDParameters::default() };
        let cut = std::panic::catch_unwind(|| {
            let parts = VHACD::decompose(&parameters, &unit, &triangles, true);
            parts.compute_primitive_intersections(&unit, &triangles)
        });
        let Ok(cut) = cut else { return Vec::new() };
        let back = |v: &parry3d::math::Vector| Vec3::from([v.x, v.y, v.z]) * size + center;
        cut.iter().map(|points| points.iter().map(back).collect()).collect()
    }
}

fn hull_area(hull: &Hull) -> f32 {
    let mut area = 0.0;
    for f in 0..hull.planes().len() {
        let corners: Vec<Vec3> =
            hull.face(f).iter().map(|&v| hull.vertices()[usize::from(v)]).collect();
        for k in 1..corners.len().saturating_sub(1) {
            let (a, b) = (corners[k] - corners[0], corners[k + 1] - corners[0]);
            area += 0.5 * a.cross(b).length();
        }
    }
    area
}
