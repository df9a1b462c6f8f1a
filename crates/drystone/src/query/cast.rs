//! Shape casts with translation and rotation: the closest hit, any hit, all hits, and batches.

use super::filter::{Inside, QueryFilter};
use super::{Query, convex, placed};
use crate::base::aabb::Aabb;
use crate::base::id::{BodyId, ShapeId};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::threads::jobs::{for_items, grain};
use crate::geometry::approach::{self, Course, Meeting, Sliding};
use crate::geometry::boxes::Ray;
use crate::geometry::shape::Shape;
use crate::geometry::solid::Solid;
use crate::state::def::DefError;
use crate::state::def::check::all_within;

/// A hit of a moving shape on another one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ShapeHit {
    /// The shape that was hit.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// Fraction of the motion, 0 to 1; 0 for an overlap at the start.
    pub fraction: f32,
    /// Contact point [m, world]; for an overlap, the middle of its deepest place.
    pub point: Vec3,
    /// Outward unit normal of the surface that was hit [world].
    pub normal: Vec3,
    /// Whether the shapes overlapped at the start: see [`Inside`](crate::query::Inside).
    pub inside: bool,
}

/// Motion of a shape in a cast: it translates evenly by `delta` while it turns by `turn`. A vector
/// alone converts to a motion without rotation.
///
/// ```
/// use drystone::{BodyDef, DefError, Pose, Shape, ShapeDef, World};
/// use drystone::query::{Motion, QueryFilter};
///
/// fn main() -> Result<(), DefError> {
///     let mut world = World::default();
///     world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
///     // A bar of 2 m, 0.6 m over the ground, turned by a right angle: its end comes down at arcsin(0.5 / 1).
///     let bar = Shape::capsule(1.0, 0.1);
///     let quarter = core::f32::consts::FRAC_PI_2;
///     let level = Pose::new([0.0, 0.6, 0.0], drystone::Quat::from_axis_angle([0.0, 0.0, 1.0], quarter));
///     let motion = Motion::by([0.0; 3]).with_turn([0.0, 0.0, quarter]);
///     let hit = world.query().cast_shape(&bar, level, motion, QueryFilter::default())?;
///     let angle = hit.map(|hit| (hit.fraction * 90.0).round());
///     assert_eq!(angle, Some(30.0));
///     Ok(())
/// }
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Displacement of the shape's origin [m, world]; components up to 1e9 m.
    pub delta: Vec3,
    /// Rotation of the shape about its origin, as a rotation vector [rad, world]; components up to
    /// 100 rad.
    pub turn: Vec3,
}

impl Motion {
    /// A motion by `delta` [m, world] without rotation.
    #[must_use]
    pub fn by(delta: impl Into<Vec3>) -> Self {
        Self { delta: delta.into(), turn: Vec3::ZERO }
    }

    /// The motion from one pose to another [m, world], with the shorter rotation.
    #[must_use]
    pub fn between(from: Pose, to: Pose) -> Self {
        let turn = (to.rotation * from.rotation.conjugate()).to_rotation_vector();
        Self { delta: to.position - from.position, turn }
    }

    /// This motion with `turn` as its rotation vector about the shape's origin [rad, world].
    #[must_use]
    pub fn with_turn(self, turn: impl Into<Vec3>) -> Self {
        Self { turn: turn.into(), ..self }
    }

    pub(super) fn validate(&self) -> Result<(), DefError> {
        all_within("delta", self.delta, &limits::DISPLACEMENT)?;
        all_within("turn", self.turn, &limits::TURN)
    }
}

impl<V: Into<Vec3>> From<V> for Motion {
    fn from(delta: V) -> Self {
        Self::by(delta)
    }
}

/// A cast of a batch: the start pose and the motion of the shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShapeQuery {
    /// Start pose of the shape [m, world].
    pub pose: Pose,
    /// Motion of the shape.
    pub motion: Motion,
}

impl ShapeQuery {
    /// The cast from `pose` [m, world] by `motion`.
    #[must_use]
    pub fn new(pose: Pose, motion: impl Into<Motion>) -> Self {
        Self { pose, motion: motion.into() }
    }
}

/// Checks the shape, the pose and the motion of a cast.
fn checked(
    shape: &Shape,
    pose: Pose,
    motion: impl Into<Motion>,
) -> Result<(Solid, ShapeQuery), DefError> {
    let (solid, motion) = (convex(shape, &pose)?, motion.into());
    motion.validate()?;
    Ok((solid, ShapeQuery { pose, motion }))
}

/// Minimum number of casts for one more thread: fewer are not worth it.
const MIN_CASTS: usize = 4;

impl Query<'_> {
    /// Returns the first shape that a convex shape hits when it starts at `pose` [m, world] and
    /// moves by `motion`, of those that the filter sees. Of several at the same fraction, the one
    /// in the lowest slot wins. The query sees sensors only if the filter includes them.
    ///
    /// A shape that overlaps it at the start is hit there, at fraction 0, unless
    /// [`QueryFilter::inside`] says otherwise. A surface that it only touches is not hit where the
    /// shape moves away or along it.
    ///
    /// # Errors
    /// The shape, the pose or `motion` is invalid, or the shape is a mesh or a half-space.
    pub fn cast_shape<'f>(
        &self,
        shape: &Shape,
        pose: Pose,
        motion: impl Into<Motion>,
        filter: impl Into<QueryFilter<'f>>,
    ) -> Result<Option<ShapeHit>, DefError> {
        let (solid, cast) = checked(shape, pose, motion)?;
        Ok(self.closest_meeting(&solid, &cast, &filter.into()))
    }

    /// Returns whether a shape that moves as in [`Self::cast_shape`] hits anything; stops at the
    /// first hit found.
    ///
    /// # Errors
    /// The errors of [`Self::cast_shape`].
    pub fn cast_shape_any<'f>(
        &self,
        shape: &Shape,
        pose: Pose,
        motion: impl Into<Motion>,
        filter: impl Into<QueryFilter<'f>>,
    ) -> Result<bool, DefError> {
        let (solid, cast) = checked(shape, pose, motion)?;
        let mut any = false;
        self.each_meeting(&solid, &cast, &filter.into(), |_, _| {
            any = true;
            -1.0
        });
        Ok(any)
    }

    /// Collects all shapes that a shape hits while it moves as in [`Self::cast_shape`], each at its
    /// first hit. `hits` is cleared first; the hits are sorted by fraction, then by slot.
    ///
    /// # Errors
    /// The errors of [`Self::cast_shape`]; `hits` is then unchanged.
    pub fn cast_shape_all<'f>(
        &self,
        shape: &Shape,
        pose: Pose,
        motion: impl Into<Motion>,
        filter: impl Into<QueryFilter<'f>>,
        hits: &mut Vec<ShapeHit>,
    ) -> Result<(), DefError> {
        let (solid, cast) = checked(shape, pose, motion)?;
        hits.clear();
        self.each_meeting(&solid, &cast, &filter.into(), |row, met| {
            hits.push(self.shape_hit(row, met));
            1.0
        });
        hits.sort_unstable_by(|a, b| {
            a.fraction.total_cmp(&b.fraction).then(a.shape.index().cmp(&b.shape.index()))
        });
        Ok(())
    }

    /// Runs [`Self::cast_shape`] of one shape for each cast of a batch, on the threads of the
    /// world's executor. `hits` is cleared first; hit `k` belongs to cast `k`. The hits are the
    /// same for any number of threads.
    ///
    /// ```
    /// use drystone::{BodyDef, DefError, Pose, Shape, ShapeDef, World};
    /// use drystone::query::{QueryFilter, ShapeQuery};
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let mut world = World::default();
    ///     world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    ///     let casts: Vec<_> = (0..8_u8)
    ///         .map(|k| ShapeQuery::new(Pose::at([f32::from(k), 3.0, 0.0]), [0.0, -4.0, 0.0]))
    ///         .collect();
    ///     let mut hits = Vec::new();
    ///     world.query().cast_shapes(&Shape::sphere(1.0), &casts, QueryFilter::default(), &mut hits)?;
    ///     assert!(hits.iter().all(|hit| hit.is_some_and(|hit| (hit.fraction - 0.5).abs() < 1e-5)));
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// The shape, a pose or a motion is invalid, or the shape is a mesh or a half-space; `hits` is
    /// then unchanged.
    pub fn cast_shapes<'f>(
        &self,
        shape: &Shape,
        casts: &[ShapeQuery],
        filter: impl Into<QueryFilter<'f>>,
        hits: &mut Vec<Option<ShapeHit>>,
    ) -> Result<(), DefError> {
        let (solid, filter) = (convex(shape, &Pose::IDENTITY)?, filter.into());
        for (k, cast) in casts.iter().enumerate() {
            let valid = placed("pose", shape, &cast.pose).and_then(|()| cast.motion.validate());
            valid.map_err(|e| e.within(&format!("casts[{k}]")))?;
        }
        hits.clear();
        hits.resize(casts.len(), None);
        self.with_jobs(|jobs| {
            for_items(jobs, hits, grain(jobs, casts.len(), MIN_CASTS), |first, hits| {
                for (cast, hit) in casts[first..].iter().zip(hits) {
                    *hit = self.closest_meeting(&solid, cast, &filter);
                }
            });
        });
        Ok(())
    }

    /// The closest hit of a validated cast.
    fn closest_meeting(
        &self,
        solid: &Solid,
        cast: &ShapeQuery,
        filter: &QueryFilter<'_>,
    ) -> Option<ShapeHit> {
        let mut best: Option<(u32, Meeting)> = None;
        self.each_meeting(solid, cast, filter, |row, met| {
            // At equal fractions the lowest row wins, whatever the tree's order.
            if best.is_none_or(|(r, m)| (met.fraction, row) < (m.fraction, r)) {
                best = Some((row, *met));
            }
            best.map_or(1.0, |(_, met)| met.fraction)
        });
        best.map(|(row, met)| self.shape_hit(row, &met))
    }

    /// Calls `visit` with the first hit on each shape within the limit, in the frame of that shape.
    /// `visit` returns the new limit as a fraction of the motion; a negative limit stops the query.
    fn each_meeting(
        &self,
        solid: &Solid,
        cast: &ShapeQuery,
        filter: &QueryFilter<'_>,
        mut visit: impl FnMut(u32, &Meeting) -> f32,
    ) {
        let ShapeQuery { pose, motion } = cast;
        let (sliding, delta) = self.sliding(solid, pose, motion.delta, filter);
        let around = if motion.turn == Vec3::ZERO {
            solid.aabb(pose)
        } else {
            Aabb::new(pose.position, pose.position).grown(solid.max_extent(Vec3::ZERO))
        };
        let ray = Ray::of_box(&around, delta);
        let mut limit = 1.0;
        for tree in [&self.tables.bounds.fixed, &self.tables.bounds.moving] {
            if limit < 0.0 {
                return;
            }
            tree.ray(&ray, limit, |row| {
                if !filter.sees(self.tables, row) {
                    return limit;
                }
                let other = self.tables.shapes.at(row);
                let at = self.pose(other);
                let own = Sliding { off: at.local_direction(sliding.off), ..sliding };
                let course = Course {
                    delta: at.local_direction(delta),
                    turn: at.local_direction(motion.turn),
                    limit,
                };
                let met = approach::meet(&other.solid, solid, &at.relative(pose), &course, &own);
                let met = met.filter(|met| !met.overlap || filter.inside == Inside::Solid);
                if let Some(met) = met {
                    limit = visit(row, &met);
                }
                limit
            });
        }
    }

    fn shape_hit(&self, row: u32, met: &Meeting) -> ShapeHit {
        let other = self.tables.shapes.at(row);
        let at = self.pose(other);
        ShapeHit {
            shape: self.tables.shapes.id(row),
            body: self.tables.bodies.id(other.body),
            fraction: met.fraction,
            point: at.point(met.point),
            normal: at.direction(met.normal),
            inside: met.overlap,
        }
    }
}
