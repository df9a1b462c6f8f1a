//! Sibling of step: answers questions about a world, and never writes.

pub(crate) mod audit;
pub(crate) mod particles;
pub(crate) mod stiffness;
pub(crate) mod sweep;
pub(crate) mod why_awake;

use crate::base::aabb::Aabb;
use crate::base::id::{BodyId, ShapeId};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::wide::SimdLevel;
use crate::geometry::boxes::Ray;
use crate::geometry::cast;
use crate::geometry::collide::{MAX_PARTS, MeshScratch, Reach, collide, collide_mesh};
use crate::geometry::manifold::{Manifold, PairCache};
use crate::geometry::shape::Shape;
use crate::geometry::solid::{Core, Solid};
use crate::state::def::{DefError, all_within, position, unit};
use crate::state::material::Filter;
use crate::state::shapes::ShapeRow;
use crate::state::tables::Tables;

/// Where a ray met a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The shape.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// Part of the ray's length, 0 to 1.
    pub fraction: f32,
    /// Where [m, world].
    pub point: Vec3,
    /// Outward normal of the surface [world].
    pub normal: Vec3,
}

/// Questions to a world, as it is now.
#[derive(Clone, Copy, Debug)]
pub struct Query<'w> {
    tables: &'w Tables,
}

impl<'w> Query<'w> {
    pub(crate) const fn new(tables: &'w Tables) -> Self {
        Self { tables }
    }

    fn pose(&self, shape: &ShapeRow) -> Pose {
        self.tables.bodies.at(shape.body).pose().compose(&shape.local)
    }

    /// Shapes of both trees whose box overlaps `bounds`.
    fn candidates(&self, bounds: &Aabb, filter: Filter) -> Vec<u32> {
        let mut found = Vec::new();
        for tree in [&self.tables.bounds.fixed, &self.tables.bounds.moving] {
            tree.query(bounds, |row| {
                if filter.collides_with(self.tables.shapes.at(row).filter) {
                    found.push(row);
                }
                true
            });
        }
        found.sort_unstable();
        found
    }

    /// The first shape on the segment from `origin` to `origin + delta` [m, world] that `filter`
    /// collides with. Sensors are passed through; so is a convex shape in which the ray starts, and what a ray
    /// that starts on a surface goes along.
    ///
    /// # Errors
    /// A number is not finite, or beyond 1e9 m.
    pub fn cast_ray(
        &self,
        origin: impl Into<Vec3>,
        delta: impl Into<Vec3>,
        filter: Filter,
    ) -> Result<Option<RayHit>, DefError> {
        let (origin, delta) = (origin.into(), delta.into());
        all_within("origin", origin, &limits::WAY)?;
        all_within("delta", delta, &limits::WAY)?;
        let point = Solid { core: Core::Point, radius: 0.0 };
        let (sliding, delta) = self.sliding(&point, &Pose::at(origin), delta, filter);
        let origin = origin + sliding.off * sliding.least;
        let mut best: Option<(f32, u32, Vec3)> = None;
        for tree in [&self.tables.bounds.fixed, &self.tables.bounds.moving] {
            let start = best.map_or(1.0, |b| b.0);
            tree.ray(&Ray::new(origin, delta), start, |row| {
                let limit = best.map_or(1.0, |b| b.0);
                let shape = self.tables.shapes.at(row);
                if shape.sensor || !filter.collides_with(shape.filter) {
                    return limit;
                }
                let pose = self.pose(shape);
                let (o, d) = (pose.local_point(origin), pose.local_direction(delta));
                if let Some(hit) = cast::ray(&shape.solid, o, d, limit) {
                    // Of two hits at the same place the lower row is taken, whatever the tree's order.
                    let better = best.is_none_or(|(f, r, _)| (hit.fraction, row) < (f, r));
                    if better {
                        best = Some((hit.fraction, row, pose.direction(hit.normal)));
                    }
                }
                best.map_or(1.0, |b| b.0)
            });
        }
        Ok(best.map(|(fraction, row, normal)| RayHit {
            shape: self.tables.shapes.id(row),
            body: self.tables.bodies.id(self.tables.shapes.at(row).body),
            fraction,
            point: origin + delta * fraction,
            normal,
        }))
    }

    /// Shapes whose bounding box overlaps this box [m, world], in the order of their slots.
    #[must_use]
    pub fn overlap_box(&self, bounds: Aabb, filter: Filter) -> Vec<ShapeId> {
        self.candidates(&bounds, filter)
            .into_iter()
            .filter(|row| {
                let shape = self.tables.shapes.at(*row);
                shape.solid.aabb(&self.pose(shape)).overlaps(&bounds)
            })
            .map(|row| self.tables.shapes.id(row))
            .collect()
    }

    /// Shapes that overlap a convex shape at `pose` [m, world], in the order of their slots.
    ///
    /// # Errors
    /// The shape or the pose is invalid, or the shape is a mesh or a half-space.
    pub fn overlap_shape(
        &self,
        shape: &Shape,
        pose: Pose,
        filter: Filter,
    ) -> Result<Vec<ShapeId>, DefError> {
        let solid = convex(shape, pose)?;
        let found = self.candidates(&solid.aabb(&pose), filter);
        let hits = found.into_iter().filter(|row| {
            let other = self.tables.shapes.at(*row);
            let inner = self.pose(other).relative(&pose);
            overlap(other, &solid, &inner)
        });
        Ok(hits.map(|row| self.tables.shapes.id(row)).collect())
    }

    /// Shapes that hold a point [m, world], in the order of their slots.
    ///
    /// # Errors
    /// A number is not finite.
    pub fn overlap_point(
        &self,
        point: impl Into<Vec3>,
        filter: Filter,
    ) -> Result<Vec<ShapeId>, DefError> {
        let shape = Shape::sphere(1.0e-5);
        self.overlap_shape(&shape, Pose::at(point), filter)
    }
}

/// A convex shape at a place, both checked.
fn convex(shape: &Shape, pose: Pose) -> Result<Solid, DefError> {
    shape.validate()?;
    position("pose.position", pose.position)?;
    unit("pose.rotation", pose.rotation)?;
    if matches!(shape, Shape::Mesh(_) | Shape::HalfSpace { .. }) {
        return Err(DefError::new("shape", shape.kind(), "a convex shape"));
    }
    Ok(Solid::of(shape))
}

fn overlap(a: &ShapeRow, b: &Solid, b_in_a: &Pose) -> bool {
    let mut made = [Manifold::default(); MAX_PARTS];
    let level = SimdLevel::best().0;
    if let Core::Mesh(mesh) = &a.solid.core {
        let (reach, mut scratch) = (Reach::still(0.0), MeshScratch::default());
        return collide_mesh(level, mesh, b, b_in_a, &reach, &mut scratch, &mut made) > 0;
    }
    collide(level, &a.solid, b, b_in_a, 0.0, &mut PairCache::default()).count > 0
}
