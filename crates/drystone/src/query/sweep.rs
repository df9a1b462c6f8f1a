//! Shapes that are asked about as they stand or move in a world: what they meet first, and what is nearest.

use super::{Query, convex};
use crate::base::aabb::Aabb;
use crate::base::id::{BodyId, ShapeId};
use crate::base::limits;
use crate::base::math::{Vec3, greater};
use crate::base::pose::Pose;
use crate::geometry::approach::{self, ALONG, Meeting, Nearby, Sliding};
use crate::geometry::boxes::Ray;
use crate::geometry::shape::Shape;
use crate::geometry::solid::Solid;
use crate::state::check::{all_within, at_least_zero, within};
use crate::state::def::DefError;
use crate::state::material::Filter;

/// Places and ways are known to this part of their coordinates: two roundings of f32 of each of two bodies.
const ROUNDING: f32 = 2.4e-7;

/// Where a moving shape met another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHit {
    /// The shape that was met.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// Part of the way, 0 to 1; 0 where they overlapped at the start.
    pub fraction: f32,
    /// Where they touch [m, world]; of an overlap the middle of its deepest place.
    pub point: Vec3,
    /// Outward normal of the surface that was met [world].
    pub normal: Vec3,
}

/// The shape nearest to another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestShape {
    /// The shape.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// How far apart they are [m]; below 0: they overlap by so much along the normal.
    pub distance: f32,
    /// The closest point of the shape that was found [m, world]; of an overlap the deepest.
    pub point: Vec3,
    /// That of the shape that was asked about [m, world].
    pub own_point: Vec3,
    /// Outward normal of the shape that was found, from `point` to `own_point` where they are apart [world].
    pub normal: Vec3,
}

impl Query<'_> {
    /// The first shape that a convex shape meets which moves from `pose` by `delta` [m, world] without turning, of those that
    /// `filter` collides with. Sensors are passed through. What it overlaps at the start it meets there, at fraction 0; what it
    /// touches and moves away from, or along, it does not meet.
    ///
    /// # Errors
    /// The shape, the pose or `delta` (up to 1e9 m) is invalid, or the shape is a mesh or a half-space.
    pub fn cast_shape(
        &self,
        shape: &Shape,
        pose: Pose,
        delta: impl Into<Vec3>,
        filter: Filter,
    ) -> Result<Option<ShapeHit>, DefError> {
        let (solid, delta) = (convex(shape, pose)?, delta.into());
        all_within("delta", delta, &limits::WAY)?;
        let (sliding, delta) = self.sliding(&solid, &pose, delta, filter);
        let ray = Ray::of_box(&solid.aabb(&pose), delta);
        let mut best: Option<(u32, Meeting)> = None;
        for tree in [&self.tables.bounds.fixed, &self.tables.bounds.moving] {
            let limit = |best: Option<(u32, Meeting)>| best.map_or(1.0, |(_, m)| m.fraction);
            tree.ray(&ray, limit(best), |row| {
                let other = self.tables.shapes.at(row);
                if !other.sensor && filter.collides_with(other.filter) {
                    let at = self.pose(other);
                    let (b_in_a, way) = (at.relative(&pose), at.local_direction(delta));
                    let own = Sliding { off: at.local_direction(sliding.off), ..sliding };
                    let met = approach::meet(&other.solid, &solid, &b_in_a, way, limit(best), &own);
                    // Of several at one place the lowest row is taken, whatever the tree's order.
                    if let Some(met) = met
                        && best.is_none_or(|(r, m)| (met.fraction, row) < (m.fraction, r))
                    {
                        best = Some((row, met));
                    }
                }
                limit(best)
            });
        }
        Ok(best.map(|(row, met)| {
            let other = self.tables.shapes.at(row);
            let at = self.pose(other);
            ShapeHit {
                shape: self.tables.shapes.id(row),
                body: self.tables.bodies.id(other.body),
                fraction: met.fraction,
                point: at.point(met.point),
                normal: at.direction(met.normal),
            }
        }))
    }

    /// What a shape touches where it starts and goes along, and its way along all of that.
    ///
    /// It stays above all of it on its way. So it meets only what stands out, not what is flush: the next tile, the
    /// next triangle.
    pub(super) fn sliding(
        &self,
        solid: &Solid,
        pose: &Pose,
        delta: Vec3,
        filter: Filter,
    ) -> (Sliding, Vec3) {
        let far = greater(pose.position.abs().max_element(), delta.abs().max_element());
        let slack = ROUNDING * far;
        let (mut way, mut off) = (delta, Vec3::ZERO);
        let mut normals: Vec<Vec3> = Vec::new();
        for row in self.candidates(&solid.aabb(pose).grown(slack), filter) {
            let other = self.tables.shapes.at(row);
            if other.sensor {
                continue;
            }
            let at = self.pose(other);
            approach::touched(&other.solid, solid, &at.relative(pose), slack, |normal| {
                let normal = at.direction(normal);
                if normal.dot(delta) >= -ALONG * delta.length() {
                    normals.push(normal);
                }
            });
        }
        for normal in &normals {
            off += *normal * greater(1.0 - normal.dot(off), 0.0);
            way += *normal * greater(-normal.dot(way), 0.0);
        }
        // Between two that look at each other there is no room to be off both.
        if normals.iter().any(|normal| normal.dot(off) < 0.5) {
            return (Sliding::default(), delta);
        }
        (Sliding { off, least: 2.0 * slack }, way)
    }

    /// The shape nearest to a convex shape at `pose` [m, world], no farther away than `reach` [m], of those that `filter` collides
    /// with, sensors left out. Of several that overlap it the one that does so most.
    ///
    /// # Errors
    /// The shape or the pose is invalid, the shape is a mesh or a half-space, or `reach` is not from 0 to 1e9 m.
    pub fn nearest_shape(
        &self,
        shape: &Shape,
        pose: Pose,
        reach: f32,
        filter: Filter,
    ) -> Result<Option<NearestShape>, DefError> {
        let solid = convex(shape, pose)?;
        at_least_zero("reach", reach)?;
        within("reach", reach, &limits::WAY)?;
        let around = solid.aabb(&pose);
        // Wider and wider: what is near is found among few. Far from the origin the box of a small shape has no size,
        // so the first look is no smaller than the least shape: 24 rounds are the most there are.
        let size = around.half_extents().max_element();
        let mut look = reach.min(greater(size, limits::LENGTH.least));
        let best = loop {
            let best = self.nearest_within(&solid, &pose, &around, look, filter);
            if best.is_some() || look >= reach {
                break best;
            }
            look = (4.0 * look).min(reach);
        };
        Ok(best.map(|(row, near)| {
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
        }))
    }

    fn nearest_within(
        &self,
        solid: &Solid,
        pose: &Pose,
        around: &Aabb,
        look: f32,
        filter: Filter,
    ) -> Option<(u32, Nearby)> {
        let mut best: Option<(u32, Nearby)> = None;
        for row in self.candidates(&around.grown(look), filter) {
            let other = self.tables.shapes.at(row);
            let limit = best.map_or(look, |(_, near)| near.distance);
            if other.sensor || !around.grown(limit.max(0.0)).overlaps(&other.fat) {
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
}
