//! Triangles of mesh files, and the solid they make: a mesh, a hull, or several hulls.

use std::sync::Arc;

use drystone::{Hull, Mesh, Shape, ShapeDef, Vec3};
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};

/// Points and triangles [m].
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Triangles {
    pub(crate) points: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Why triangles make no solid, and which triangles would.
#[derive(Clone, Debug)]
pub(crate) struct NoSolid {
    pub(crate) problem: String,
    pub(crate) allowed: &'static str,
}

/// The solid that a mesh becomes on a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Solid {
    /// The hull of its points.
    Hull,
    /// The mesh itself.
    Mesh,
    /// Hulls that it is decomposed into.
    Hulls,
}

fn no_hull(e: impl core::fmt::Display) -> NoSolid {
    NoSolid { problem: e.to_string(), allowed: "points that span a volume" }
}

/// The hull of points; otherwise why there is none.
pub(crate) fn hull_of_points(points: &[Vec3]) -> Result<Shape, String> {
    Hull::from_points(points).map(|hull| Shape::Hull(Arc::new(hull))).map_err(|e| e.to_string())
}

impl Triangles {
    /// The triangles as shapes of a body called `name`; a note says how a mesh was decomposed.
    pub(crate) fn shapes(
        self,
        solid: Solid,
        name: &str,
        notes: &mut Vec<String>,
    ) -> Result<Vec<Shape>, NoSolid> {
        match solid {
            Solid::Hull => Ok(vec![self.hull()?]),
            Solid::Mesh => Ok(vec![self.mesh()?]),
            Solid::Hulls => {
                let (shapes, note) = self.hulls()?;
                notes.push(format!("{name}: its mesh is {note}"));
                Ok(shapes)
            }
        }
    }

    /// The hull of the points.
    pub(crate) fn hull(&self) -> Result<Shape, NoSolid> {
        let hull = Hull::from_points(&self.points).map_err(no_hull)?;
        Ok(Shape::Hull(Arc::new(hull)))
    }

    /// The triangles as a mesh.
    pub(crate) fn mesh(self) -> Result<Shape, NoSolid> {
        let allowed = "a mesh with at least one triangle with an area";
        let mesh = Mesh::new(self.points, self.triangles)
            .map_err(|e| NoSolid { problem: e.to_string(), allowed })?;
        Ok(Shape::Mesh(Arc::new(mesh)))
    }

    /// One hull if the surface is convex and closed, several if not; with a line that says which.
    pub(crate) fn hulls(&self) -> Result<(Vec<Shape>, String), NoSolid> {
        let whole = Hull::from_points(&self.points).map_err(no_hull)?;
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

    /// The hull of the points, if the surface is convex and closed.
    pub(crate) fn convex(&self) -> Option<Shape> {
        let hull = Hull::from_points(&self.points).ok().filter(|hull| self.is_surface_of(hull))?;
        Some(Shape::Hull(Arc::new(hull)))
    }

    /// The smallest box around the points along the axes; otherwise why there is none.
    pub(crate) fn bounding_box(&self) -> Result<ShapeDef, String> {
        let mut points = self.points.iter().copied();
        let first = points.next().ok_or("the mesh has no triangles")?;
        let (low, high) = points.fold((first, first), |(l, h), p| (l.min(p), h.max(p)));
        let half = (high - low) * 0.5;
        let half = half.max(Vec3::splat(0.005 * half.max_element()));
        let shape = Shape::box_half(half);
        shape.validate().map_err(|e| e.to_string())?;
        Ok(ShapeDef::new(shape).with_position((low + high) * 0.5))
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

    /// The points of convex parts: the voxel method of V-HACD, then the mesh's own surface inside
    /// each part, so that parts meet the mesh exactly and not voxels. The list is empty if the mesh
    /// cannot be decomposed, or if the library panics on it, as it does on some meshes.
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
