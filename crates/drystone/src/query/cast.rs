//! Shapes that move, and turn on their way: the closest shape that they meet, any, all, and many casts at once.

use super::filter::{Inside, QueryFilter};
use super::{Query, convex, placed};
use crate::base::aabb::Aabb;
use crate::base::id::{BodyId, ShapeId};
use crate::base::jobs::{for_items, grain};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::approach::{self, Course, Meeting, Sliding};
use crate::geometry::boxes::Ray;
use crate::geometry::shape::Shape;
use crate::geometry::solid::Solid;
use crate::state::check::all_within;
use crate::state::def::DefError;

/// Where a moving shape met another one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
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
    /// They overlapped at the start: see [`Inside`](crate::query::Inside).
    pub inside: bool,
}

/// How a shape moves in a cast: evenly, by `delta`, while it turns by `turn`. A vector alone is a motion that does not turn.
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
    /// How far the origin of the shape moves [m, world]; components up to 1e9 m.
    pub delta: Vec3,
    /// How far the shape turns about its origin, as a rotation vector [rad, world]; components up to 100 rad.
    pub turn: Vec3,
}

impl Motion {
    /// A motion by `delta` [m, world] that does not turn.
    #[must_use]
    pub fn by(delta: impl Into<Vec3>) -> Self {
        Self { delta: delta.into(), turn: Vec3::ZERO }
    }

    /// The motion from one pose to another [m, world], by the shorter turn.
    #[must_use]
    pub fn between(from: Pose, to: Pose) -> Self {
        let turn = (to.rotation * from.rotation.conjugate()).to_rotation_vector();
        Self { delta: to.position - from.position, turn }
    }

    /// The same with this turn about the shape's origin, as a rotation vector [rad, world].
    #[must_use]
    pub fn with_turn(self, turn: impl Into<Vec3>) -> Self {
        Self { turn: turn.into(), ..self }
    }

    pub(super) fn validate(&self) -> Result<(), DefError> {
        all_within("delta", self.delta, &limits::WAY)?;
        all_within("turn", self.turn, &limits::TURN)
    }
}

impl<V: Into<Vec3>> From<V> for Motion {
    fn from(delta: V) -> Self {
        Self::by(delta)
    }
}

/// A cast of a batch: where the shape starts, and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShapeQuery {
    /// Where it starts [m, world].
    pub pose: Pose,
    /// How it moves.
    pub motion: Motion,
}

impl ShapeQuery {
    /// The cast from `pose` [m, world] by `motion`.
    #[must_use]
    pub fn new(pose: Pose, motion: impl Into<Motion>) -> Self {
        Self { pose, motion: motion.into() }
    }
}

/// A cast of a convex shape, if all of it is valid.
fn checked(
    shape: &Shape,
    pose: Pose,
    motion: impl Into<Motion>,
) -> Result<(Solid, ShapeQuery), DefError> {
    let (solid, motion) = (convex(shape, &pose)?, motion.into());
    motion.validate()?;
    Ok((solid, ShapeQuery { pose, motion }))
}

/// Fewer casts than this are not worth another thread.
const LEAST_CASTS: usize = 4;

impl Query<'_> {
    /// The first shape that a convex shape meets which starts at `pose` [m, world] and moves by `motion`, of those that the filter
    /// sees. Of several at one place that of the lowest slot. Sensors are seen only if the filter asks for them.
    ///
    /// A shape that it overlaps at the start is met there, at fraction 0, unless [`QueryFilter::inside`] says otherwise. A shape that it
    /// only touches is not met where it moves away from the surface, or along it.
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

    /// Whether a shape that moves as in [`Self::cast_shape`] meets anything: the first that is found answers it.
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

    /// All shapes that a shape that moves as in [`Self::cast_shape`] meets on its whole way, each where it is met first. `hits` is
    /// emptied before; the hits in it are in the order of their fractions, then of their slots.
    ///
    /// # Errors
    /// The errors of [`Self::cast_shape`]; then `hits` is as it was.
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

    /// [`Self::cast_shape`] of one shape for each cast of a batch, by the threads of the world's executor. `hits` is emptied before;
    /// hit `k` is that of cast `k`. The hits are the same for any number of threads.
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
    /// The shape, a pose or a motion is invalid, or the shape is a mesh or a half-space; then `hits` is as it was.
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
            for_items(jobs, hits, grain(jobs, casts.len(), LEAST_CASTS), |first, hits| {
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
            // Of several at one place the lowest row is taken, whatever the tree's order.
            if best.is_none_or(|(r, m)| (met.fraction, row) < (m.fraction, r)) {
                best = Some((row, *met));
            }
            best.map_or(1.0, |(_, met)| met.fraction)
        });
        best.map(|(row, met)| self.shape_hit(row, &met))
    }

    /// Calls `visit` with the first meeting with each shape within the limit, in the frame of that shape. `visit` answers the new
    /// limit as a part of the way; negative: stop.
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
