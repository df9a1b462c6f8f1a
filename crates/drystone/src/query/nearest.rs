//! Shapes near another one: the nearest, and all within a reach.

use super::filter::QueryFilter;
use super::{Query, convex};
use crate::base::aabb::Aabb;
use crate::base::id::{BodyId, ShapeId};
use crate::base::limits;
use crate::base::math::{Vec3, greater};
use crate::base::pose::Pose;
use crate::geometry::approach::{self, Nearby};
use crate::geometry::shape::Shape;
use crate::geometry::solid::Solid;
use crate::state::def::DefError;
use crate::state::def::check::{at_least_zero, within};

/// A shape near another one, and the closest points of both.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NearestShape {
    /// The shape.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// Distance of the two shapes [m]; below 0: the depth of their overlap along the normal.
    pub distance: f32,
    /// Closest point of the found shape [m, world]; in an overlap, its deepest point.
    pub point: Vec3,
    /// Closest point of the query's shape [m, world]; in an overlap, its deepest point.
    pub own_point: Vec3,
    /// Outward normal of the found shape [world]; points from `point` to `own_point` where the
    /// shapes are apart.
    pub normal: Vec3,
}

impl Query<'_> {
    /// Returns the shape nearest to a convex shape at `pose` [m, world], of those that the filter
    /// sees and that are no farther away than `reach` [m]. Of several that overlap it, the deepest
    /// overlap wins. The query sees sensors only if the filter includes them.
    ///
    /// ```
    /// use drystone::{BodyDef, DefError, Pose, Shape, ShapeDef, World};
    /// use drystone::query::{NearestShape, QueryFilter};
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let mut world = World::default();
    ///     world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    ///     let (probe, at) = (Shape::sphere(0.5), Pose::at([0.0, 2.5, 0.0]));
    ///     let near: Option<NearestShape> = world.query().nearest_shape(&probe, at, 9.0, QueryFilter::default())?;
    ///     assert_eq!(near.map(|near| near.distance), Some(2.0));
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// The shape or the pose is invalid, the shape is a mesh or a half-space, or `reach` is not
    /// from 0 to 1e9 m.
    pub fn nearest_shape<'f>(
        &self,
        shape: &Shape,
        pose: Pose,
        reach: f32,
        filter: impl Into<QueryFilter<'f>>,
    ) -> Result<Option<NearestShape>, DefError> {
        let (solid, filter) = (convex(shape, &pose)?, filter.into());
        valid_reach(reach)?;
        let around = solid.aabb(&pose);
        // The search widens step by step, so that a near shape is found among few candidates. Far
        // from the origin the bounding box of a small shape rounds to size 0. The first search
        // distance is therefore at least the minimum length of a shape, which limits the loop to 24
        // rounds.
        let size = around.half_extents().max_element();
        let mut look = reach.min(greater(size, limits::LENGTH.minimum));
        let best = loop {
            let best = self.nearest_within(&solid, &pose, &around, look, &filter);
            if best.is_some() || look >= reach {
                break best;
            }
            look = (4.0 * look).min(reach);
        };
        Ok(best.map(|(row, near)| self.named(row, &near)))
    }

    /// Collects all shapes no farther than `reach` [m] from a convex shape at `pose` [m, world]
    /// that the filter sees, each with its closest points. `shapes` is cleared first; the result is
    /// sorted by distance, then by slot.
    ///
    /// # Errors
    /// The errors of [`Self::nearest_shape`]; `shapes` is then unchanged.
    pub fn nearest_all<'f>(
        &self,
        shape: &Shape,
        pose: Pose,
        reach: f32,
        filter: impl Into<QueryFilter<'f>>,
        shapes: &mut Vec<NearestShape>,
    ) -> Result<(), DefError> {
        let solid = convex(shape, &pose)?;
        valid_reach(reach)?;
        shapes.clear();
        self.each_near(&solid.aabb(&pose).grown(reach), &filter.into(), |row| {
            let other = self.tables.shapes.at(row);
            let b_in_a = self.pose(other).relative(&pose);
            let near = approach::closest(&other.solid, &solid, &b_in_a, reach);
            shapes.extend(near.map(|near| self.named(row, &near)));
            true
        });
        shapes.sort_unstable_by(|a, b| {
            a.distance.total_cmp(&b.distance).then(a.shape.index().cmp(&b.shape.index()))
        });
        Ok(())
    }

    fn nearest_within(
        &self,
        solid: &Solid,
        pose: &Pose,
        around: &Aabb,
        look: f32,
        filter: &QueryFilter<'_>,
    ) -> Option<(u32, Nearby)> {
        let mut best: Option<(u32, Nearby)> = None;
        for row in self.candidates(&around.grown(look), filter) {
            let other = self.tables.shapes.at(row);
            let limit = best.map_or(look, |(_, near)| near.distance);
            if !around.grown(limit.max(0.0)).overlaps(&other.fat) {
                continue;
            }
            let b_in_a = self.pose(other).relative(pose);
            let near = approach::closest(&other.solid, solid, &b_in_a, limit);
            if let Some(near) = near
                && best.is_none_or(|(_, b)| near.distance < b.distance)
            {
                best = Some((row, near));
            }
        }
        best
    }

    fn named(&self, row: u32, near: &Nearby) -> NearestShape {
        let other = self.tables.shapes.at(row);
        let at = self.pose(other);
        NearestShape {
            shape: self.tables.shapes.id(row),
            body: self.tables.bodies.id(other.body),
            distance: near.distance,
            point: at.point(near.point_a),
            own_point: at.point(near.point_b),
            normal: at.direction(near.normal),
        }
    }
}

pub(super) fn valid_reach(reach: f32) -> Result<(), DefError> {
    at_least_zero("reach", reach)?;
    within("reach", reach, &limits::DISPLACEMENT)
}
