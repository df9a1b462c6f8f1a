//! Overlaps: the shapes that a bounding box, a shape or a point overlaps.

use super::filter::QueryFilter;
use super::{Query, convex};
use crate::base::aabb::Aabb;
use crate::base::id::ShapeId;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::collide::{MAX_PARTS, MeshScratch, Reach, collide, collide_mesh};
use crate::geometry::manifold::{Manifold, PairCache};
use crate::geometry::shape::Shape;
use crate::geometry::solid::{Core, Solid};
use crate::state::def::DefError;

/// Radius [m] of the ball that stands for a point: the minimum length of a shape, times the world's
/// length scale if that is above 1. The radius makes a point on a mesh overlap it despite rounding.
const POINT: f32 = 1.0e-5;

impl Query<'_> {
    /// Returns the shapes whose bounding box overlaps this box [m, world], sorted by slot. This is
    /// cheap, and includes some shapes that the box itself does not overlap. The query sees sensors
    /// only if the filter includes them. The box may be infinite.
    ///
    /// # Errors
    /// A number is NaN.
    pub fn overlap_bounds<'f>(
        &self,
        bounds: Aabb,
        filter: impl Into<QueryFilter<'f>>,
    ) -> Result<Vec<ShapeId>, DefError> {
        let mut shapes = Vec::new();
        self.overlap_bounds_into(bounds, filter, &mut shapes)?;
        Ok(shapes)
    }

    /// [`Self::overlap_bounds`] into a list, which is cleared first.
    ///
    /// # Errors
    /// The errors of [`Self::overlap_bounds`]; the list is then unchanged.
    pub fn overlap_bounds_into<'f>(
        &self,
        bounds: Aabb,
        filter: impl Into<QueryFilter<'f>>,
        shapes: &mut Vec<ShapeId>,
    ) -> Result<(), DefError> {
        for (field, corner) in [("bounds.min", bounds.min), ("bounds.max", bounds.max)] {
            if corner.to_array().into_iter().any(f32::is_nan) {
                return Err(DefError::of_vec(field, corner, "three numbers"));
            }
        }
        self.collect(&bounds, &filter.into(), shapes, |row| {
            let shape = self.tables.shapes.at(row);
            shape.solid.aabb(&self.pose(shape)).overlaps(&bounds)
        });
        Ok(())
    }

    /// Returns the shapes that overlap a convex shape at `pose` [m, world], sorted by slot. The
    /// query sees sensors only if the filter includes them.
    ///
    /// # Errors
    /// The shape or the pose is invalid, or the shape is a mesh or a half-space.
    pub fn overlap_shape<'f>(
        &self,
        shape: &Shape,
        pose: Pose,
        filter: impl Into<QueryFilter<'f>>,
    ) -> Result<Vec<ShapeId>, DefError> {
        let mut shapes = Vec::new();
        self.overlap_shape_into(shape, pose, filter, &mut shapes)?;
        Ok(shapes)
    }

    /// [`Self::overlap_shape`] into a list, which is cleared first.
    ///
    /// ```
    /// use drystone::{BodyDef, DefError, Pose, Shape, ShapeDef, World};
    /// use drystone::query::QueryFilter;
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let mut world = World::default();
    ///     let zone = ShapeDef { sensor: true, ..ShapeDef::box_half([1.0; 3]) };
    ///     world.add_body(BodyDef::fixed().with_shape(zone))?;
    ///     let (query, probe, mut found) = (world.query(), Shape::sphere(0.1), Vec::new());
    ///     query.overlap_shape_into(&probe, Pose::IDENTITY, QueryFilter::default(), &mut found)?;
    ///     assert!(found.is_empty());
    ///     let all = QueryFilter::default().with_sensors();
    ///     query.overlap_shape_into(&probe, Pose::IDENTITY, all, &mut found)?;
    ///     assert_eq!(found.len(), 1);
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// The errors of [`Self::overlap_shape`]; the list is then unchanged.
    pub fn overlap_shape_into<'f>(
        &self,
        shape: &Shape,
        pose: Pose,
        filter: impl Into<QueryFilter<'f>>,
        shapes: &mut Vec<ShapeId>,
    ) -> Result<(), DefError> {
        let solid = convex(shape, &pose)?;
        let mut scratch = MeshScratch::default();
        self.collect(&solid.aabb(&pose), &filter.into(), shapes, |row| {
            self.overlaps(row, &solid, &pose, &mut scratch)
        });
        Ok(())
    }

    /// Returns whether a convex shape at `pose` [m, world] overlaps a shape that the filter sees;
    /// stops at the first overlap found.
    ///
    /// # Errors
    /// The errors of [`Self::overlap_shape`].
    pub fn overlap_shape_any<'f>(
        &self,
        shape: &Shape,
        pose: Pose,
        filter: impl Into<QueryFilter<'f>>,
    ) -> Result<bool, DefError> {
        let solid = convex(shape, &pose)?;
        let (mut any, mut scratch) = (false, MeshScratch::default());
        self.each_near(&solid.aabb(&pose), &filter.into(), |row| {
            any = self.overlaps(row, &solid, &pose, &mut scratch);
            !any
        });
        Ok(any)
    }

    /// Returns the shapes that contain a point [m, world], within 1e-5 m, sorted by slot. A mesh
    /// contains the points of its triangles. The query sees sensors only if the filter includes
    /// them.
    ///
    /// # Errors
    /// A number is not finite, or beyond 1e7 m.
    pub fn overlap_point<'f>(
        &self,
        point: impl Into<Vec3>,
        filter: impl Into<QueryFilter<'f>>,
    ) -> Result<Vec<ShapeId>, DefError> {
        self.overlap_shape(&self.point(), Pose::at(point), filter)
    }

    /// [`Self::overlap_point`] into a list, which is cleared first.
    ///
    /// # Errors
    /// The errors of [`Self::overlap_point`]; the list is then unchanged.
    pub fn overlap_point_into<'f>(
        &self,
        point: impl Into<Vec3>,
        filter: impl Into<QueryFilter<'f>>,
        shapes: &mut Vec<ShapeId>,
    ) -> Result<(), DefError> {
        self.overlap_shape_into(&self.point(), Pose::at(point), filter, shapes)
    }

    /// The ball that stands for a point.
    fn point(&self) -> Shape {
        Shape::sphere(POINT * self.tables.config.length_scale.max(1.0))
    }

    /// Collects the shapes near `bounds` for which `is_met` returns true, sorted by slot.
    fn collect(
        &self,
        bounds: &Aabb,
        filter: &QueryFilter<'_>,
        shapes: &mut Vec<ShapeId>,
        mut is_met: impl FnMut(u32) -> bool,
    ) {
        shapes.clear();
        self.each_near(bounds, filter, |row| {
            if is_met(row) {
                shapes.push(self.tables.shapes.id(row));
            }
            true
        });
        shapes.sort_unstable_by_key(|id| id.index());
    }

    fn overlaps(&self, row: u32, solid: &Solid, pose: &Pose, scratch: &mut MeshScratch) -> bool {
        let other = self.tables.shapes.at(row);
        let inner = self.pose(other).relative(pose);
        if let Core::Mesh(mesh) = &other.solid.core {
            let (reach, mut made) = (Reach::still(0.0), [Manifold::default(); MAX_PARTS]);
            return collide_mesh(self.level.0, mesh, solid, &inner, &reach, scratch, &mut made) > 0;
        }
        let cache = &mut PairCache::default();
        collide(self.level.0, &other.solid, solid, &inner, 0.0, cache).count > 0
    }
}
