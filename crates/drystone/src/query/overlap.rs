//! Overlaps: which shapes a box, a shape or a point meets where it is.

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

/// A point is looked up as a ball of this radius [m], the least that there is, times the world's length if that is more: so a point on a mesh is found in spite of its rounding.
const POINT: f32 = 1.0e-5;

impl Query<'_> {
    /// Shapes whose bounding box overlaps this box [m, world], in the order of their slots; cheap, and true of some shapes that the
    /// box itself does not meet. Sensors are seen only if the filter asks for them. The box may be without end.
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

    /// [`Self::overlap_bounds`] into a list that is emptied before.
    ///
    /// # Errors
    /// The errors of [`Self::overlap_bounds`]; then the list is as it was.
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

    /// Shapes that overlap a convex shape at `pose` [m, world], in the order of their slots. Sensors are seen only if the filter asks
    /// for them.
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

    /// [`Self::overlap_shape`] into a list that is emptied before.
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
    /// The errors of [`Self::overlap_shape`]; then the list is as it was.
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

    /// Whether a convex shape at `pose` [m, world] overlaps a shape that the filter sees: the first that is found answers it.
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

    /// Shapes that hold a point [m, world], within 1e-5 m, in the order of their slots. A mesh holds the points of its triangles.
    /// Sensors are seen only if the filter asks for them.
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

    /// [`Self::overlap_point`] into a list that is emptied before.
    ///
    /// # Errors
    /// The errors of [`Self::overlap_point`]; then the list is as it was.
    pub fn overlap_point_into<'f>(
        &self,
        point: impl Into<Vec3>,
        filter: impl Into<QueryFilter<'f>>,
        shapes: &mut Vec<ShapeId>,
    ) -> Result<(), DefError> {
        self.overlap_shape_into(&self.point(), Pose::at(point), filter, shapes)
    }

    /// A ball for a point.
    fn point(&self) -> Shape {
        Shape::sphere(POINT * self.tables.config.length_scale.max(1.0))
    }

    /// The shapes near `bounds` for which `is_met` holds.
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
