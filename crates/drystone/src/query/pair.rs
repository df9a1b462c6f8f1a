//! Two shapes without a world: distance, overlap depth, casts and contacts.

use super::cast::Motion;
use super::filter::Inside;
use super::nearest::valid_reach;
use super::ray::{self, RayQuery};
use super::{ROUNDING, placed};
use crate::base::limits;
use crate::base::math::{Vec3, greater};
use crate::base::pose::Pose;
use crate::base::simd::wide::SimdLevel;
use crate::geometry::approach::{self, Course, Nearby, Sliding};
use crate::geometry::collide::{MAX_PARTS, MeshScratch, Reach, collide, collide_mesh};
use crate::geometry::manifold::{Manifold, PairCache};
use crate::geometry::shape::Shape;
use crate::geometry::solid::{Core, Solid};
use crate::state::def::DefError;
use crate::state::def::check::within;

/// The closest points of two shapes, A and B.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ClosestPoints {
    /// Distance of the shapes [m]; below 0: the depth of their overlap along the normal.
    pub distance: f32,
    /// Closest point of A [m, in the frame of both poses]; in an overlap, its deepest point.
    pub point_a: Vec3,
    /// Closest point of B [m, in the frame of both poses]; in an overlap, its deepest point.
    pub point_b: Vec3,
    /// Unit normal, from A to B.
    pub normal: Vec3,
}

/// A hit of a ray or a moving shape on a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CastHit {
    /// Fraction of the motion, 0 to 1.
    pub fraction: f32,
    /// Point of the hit [m, in the frame of the poses].
    pub point: Vec3,
    /// Outward unit normal of the surface that was hit.
    pub normal: Vec3,
    /// Whether the cast starts in the shape.
    pub inside: bool,
}

/// Contact points of two shapes, A and B, that share a normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeContact {
    manifold: Manifold,
}

/// A point of a [`ShapeContact`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ShapeContactPoint {
    /// Midpoint between the two surfaces [m, in the frame of both poses].
    pub position: Vec3,
    /// Distance of the surfaces along the normal [m]; negative: overlap.
    pub separation: f32,
}

impl ShapeContact {
    /// Unit normal, from A to B.
    #[must_use]
    pub const fn normal(&self) -> Vec3 {
        self.manifold.normal
    }

    /// The contact points, 1 to 4.
    pub fn points(&self) -> impl Iterator<Item = ShapeContactPoint> {
        let point = |p: &crate::geometry::manifold::ManifoldPoint| ShapeContactPoint {
            position: p.position,
            separation: p.separation,
        };
        self.manifold.points().iter().map(point)
    }
}

/// Two valid shapes; `b` is convex.
struct Pair {
    a: Solid,
    b: Solid,
    at: Pose,
    b_in_a: Pose,
    /// Whether the caller gave the shapes in the other order.
    flipped: bool,
}

impl Pair {
    fn new(a: &Shape, pose_a: &Pose, b: &Shape, pose_b: &Pose) -> Result<Self, DefError> {
        placed("pose", a, pose_a)?;
        placed("other_pose", b, pose_b).map_err(|e| named_other(e, b))?;
        let (first, second) = (Solid::of(a), Solid::of(b));
        if !second.is_surface() {
            let b_in_a = pose_a.relative(pose_b);
            return Ok(Self { a: first, b: second, at: *pose_a, b_in_a, flipped: false });
        }
        if !first.is_surface() {
            let b_in_a = pose_b.relative(pose_a);
            return Ok(Self { a: second, b: first, at: *pose_b, b_in_a, flipped: true });
        }
        let allowed = format!("a convex shape, because the first shape is a {}", a.kind());
        Err(DefError::unsuitable("other", b.kind(), &allowed))
    }

    fn closest(&self, reach: f32) -> Option<ClosestPoints> {
        let near = approach::closest(&self.a, &self.b, &self.b_in_a, reach)?;
        let Nearby { distance, point_a, point_b, normal } = near;
        let (point_a, point_b) = (self.at.point(point_a), self.at.point(point_b));
        let normal = self.at.direction(normal);
        Some(if self.flipped {
            ClosestPoints { distance, point_a: point_b, point_b: point_a, normal: -normal }
        } else {
            ClosestPoints { distance, point_a, point_b, normal }
        })
    }

    /// Computes the manifolds with points no farther apart than `margin` [m].
    fn contacts(&self, margin: f32) -> Vec<ShapeContact> {
        let mut made = [Manifold::default(); MAX_PARTS];
        let level = SimdLevel::best().0;
        if let Core::Mesh(mesh) = &self.a.core {
            let (reach, scratch) = (Reach::still(margin), &mut MeshScratch::default());
            collide_mesh(level, mesh, &self.b, &self.b_in_a, &reach, scratch, &mut made);
        } else {
            let cache = &mut PairCache::default();
            made[0] = collide(level, &self.a, &self.b, &self.b_in_a, margin, cache);
        }
        let with_points = made.into_iter().filter(|manifold| manifold.count > 0);
        with_points.map(|manifold| ShapeContact { manifold: self.shown(manifold) }).collect()
    }

    /// Converts a manifold to the frame of the poses and to the caller's order of shapes.
    fn shown(&self, mut manifold: Manifold) -> Manifold {
        let normal = self.at.direction(manifold.normal);
        manifold.normal = if self.flipped { -normal } else { normal };
        for p in &mut manifold.points {
            p.position = self.at.point(p.position);
        }
        manifold
    }
}

/// Adds `other` to the field name of an error of the second shape.
fn named_other(e: DefError, other: &Shape) -> DefError {
    if e.field().starts_with("other") || other.validate().is_ok() { e } else { e.within("other") }
}

/// Pairs of shapes, without a world. Poses and results share one frame. At least one shape of a
/// pair must be convex: two meshes, two half-spaces, or a mesh and a half-space are refused.
impl Shape {
    /// Returns the closest points of this shape at `pose` and of `other` at `other_pose`, unless
    /// they are farther apart than `reach` [m].
    ///
    /// ```
    /// use drystone::{DefError, Pose, Shape};
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let (ball, wall) = (Shape::sphere(0.5), Shape::box_half([0.1, 2.0, 2.0]));
    ///     let near = ball.closest_points(Pose::IDENTITY, &wall, Pose::at([2.0, 0.0, 0.0]), 10.0)?;
    ///     assert_eq!(near.map(|near| (near.point_a.x, near.point_b.x)), Some((0.5, 1.9)));
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// A shape or a pose is invalid, none of the shapes is convex, or `reach` is not from 0 to 1e9
    /// m.
    pub fn closest_points(
        &self,
        pose: Pose,
        other: &Self,
        other_pose: Pose,
        reach: f32,
    ) -> Result<Option<ClosestPoints>, DefError> {
        let pair = Pair::new(self, &pose, other, &other_pose)?;
        valid_reach(reach)?;
        Ok(pair.closest(reach))
    }

    /// Returns the distance of this shape at `pose` from `other` at `other_pose` [m]; below 0: the
    /// depth of their overlap.
    ///
    /// # Errors
    /// A shape or a pose is invalid, or none of the shapes is convex.
    pub fn distance(&self, pose: Pose, other: &Self, other_pose: Pose) -> Result<f32, DefError> {
        let found =
            Pair::new(self, &pose, other, &other_pose)?.closest(limits::DISPLACEMENT.maximum);
        // Positions are bounded, so no valid shapes are farther apart than the maximum
        // displacement.
        Ok(found.map_or(limits::DISPLACEMENT.maximum, |near| near.distance))
    }

    /// Returns whether this shape at `pose` overlaps or touches `other` at `other_pose`.
    ///
    /// # Errors
    /// A shape or a pose is invalid, or none of the shapes is convex.
    pub fn overlaps(&self, pose: Pose, other: &Self, other_pose: Pose) -> Result<bool, DefError> {
        Ok(!Pair::new(self, &pose, other, &other_pose)?.contacts(0.0).is_empty())
    }

    /// Returns the contacts of this shape at `pose` with `other` at `other_pose`: points whose
    /// surfaces are no farther apart than `margin` [m], one [`ShapeContact`] for each normal. Two
    /// convex shapes, or one and a half-space, have at most one; a mesh has up to four.
    ///
    /// ```
    /// use drystone::{DefError, Pose, Shape};
    /// use drystone::query::{ShapeContact, ShapeContactPoint};
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let (cube, ground) = (Shape::box_half([0.5; 3]), Shape::half_space([0.0, 1.0, 0.0], 0.0));
    ///     let stands = Pose::at([0.0, 0.49, 0.0]);
    ///     let contacts: Vec<ShapeContact> = ground.contacts(Pose::IDENTITY, &cube, stands, 0.0)?;
    ///     let corners: Vec<ShapeContactPoint> = contacts.iter().flat_map(|c| c.points()).collect();
    ///     assert!(corners.len() == 4 && corners.iter().all(|p| (p.separation + 0.01).abs() < 1e-6));
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// A shape or a pose is invalid, none of the shapes is convex, or `margin` is not from 0 to
    /// 1000 m.
    pub fn contacts(
        &self,
        pose: Pose,
        other: &Self,
        other_pose: Pose,
        margin: f32,
    ) -> Result<Vec<ShapeContact>, DefError> {
        let pair = Pair::new(self, &pose, other, &other_pose)?;
        within("margin", margin, &limits::CONTACT_DISTANCE)?;
        Ok(pair.contacts(margin))
    }

    /// Returns the first hit of this convex shape, which starts at `pose` and moves by `motion`, on
    /// `other` at `other_pose`. An overlap at the start is a hit at fraction 0. A surface that the
    /// shape only touches is not hit where the shape moves away or along it.
    ///
    /// ```
    /// use drystone::{DefError, Pose, Shape};
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let (ball, ground) = (Shape::sphere(0.5), Shape::half_space([0.0, 1.0, 0.0], 0.0));
    ///     let hit = ball.cast(Pose::at([0.0, 2.5, 0.0]), [0.0, -4.0, 0.0], &ground, Pose::IDENTITY)?;
    ///     assert_eq!(hit.map(|hit| hit.fraction), Some(0.5));
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// A shape, a pose or `motion` is invalid, or this shape is a mesh or a half-space.
    pub fn cast(
        &self,
        pose: Pose,
        motion: impl Into<Motion>,
        other: &Self,
        other_pose: Pose,
    ) -> Result<Option<CastHit>, DefError> {
        let (own, motion) = (super::convex(self, &pose)?, motion.into());
        placed("other_pose", other, &other_pose).map_err(|e| named_other(e, other))?;
        motion.validate()?;
        let at = other_pose;
        let course = Course {
            delta: at.local_direction(motion.delta),
            turn: at.local_direction(motion.turn),
            limit: 1.0,
        };
        let (met, none) = (Solid::of(other), Sliding::default());
        let met = approach::meet(&met, &own, &at.relative(&pose), &course, &none);
        Ok(met.map(|met| CastHit {
            fraction: met.fraction,
            point: at.point(met.point),
            normal: at.direction(met.normal),
            inside: met.overlap,
        }))
    }

    /// Returns the first hit of the segment from `origin` to `origin + delta` [m] on this shape at
    /// `pose`; `inside` says how a start in the shape is treated.
    ///
    /// ```
    /// use drystone::{DefError, Pose, Shape};
    /// use drystone::query::{CastHit, Inside};
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let (ball, from, way) = (Shape::sphere(1.0), [0.0; 3], [4.0, 0.0, 0.0]);
    ///     let hit = |inside| ball.cast_ray(Pose::IDENTITY, from, way, inside);
    ///     assert_eq!(hit(Inside::Solid)?.map(|hit: CastHit| hit.fraction), Some(0.0));
    ///     assert_eq!(hit(Inside::Hollow)?.map(|hit| hit.fraction), Some(0.25));
    ///     assert_eq!(hit(Inside::Ignore)?, None);
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// The shape or the pose is invalid, or a number of the ray is not finite or beyond 1e9 m.
    pub fn cast_ray(
        &self,
        pose: Pose,
        origin: impl Into<Vec3>,
        delta: impl Into<Vec3>,
        inside: Inside,
    ) -> Result<Option<CastHit>, DefError> {
        placed("pose", self, &pose)?;
        let ray = RayQuery::new(origin, delta);
        ray.validate()?;
        let RayQuery { origin, delta } = ray;
        let far = greater(origin.abs().max_element(), delta.abs().max_element());
        let (o, d) = (pose.local_point(origin), pose.local_direction(delta));
        let hit = ray::meet(&Solid::of(self), o, d, 1.0, inside, ROUNDING * far);
        Ok(hit.map(|(hit, inside)| CastHit {
            fraction: hit.fraction,
            point: origin + delta * hit.fraction,
            normal: pose.direction(hit.normal),
            inside,
        }))
    }
}
