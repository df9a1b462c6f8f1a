//! Ray casts: the closest hit, any hit, all hits, and batches of rays.

use core::ops::ControlFlow;

use super::filter::{Inside, QueryFilter};
use super::{Query, ROUNDING};
use crate::base::id::{BodyId, ShapeId};
use crate::base::limits;
use crate::base::math::{Vec3, greater};
use crate::base::pose::Pose;
use crate::base::threads::jobs::{for_items, grain};
use crate::geometry::boxes::Ray;
use crate::geometry::cast;
use crate::geometry::solid::{Core, Solid};
use crate::state::def::{DefError, all_within};

/// A hit of a ray on a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RayHit {
    /// The shape.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// Fraction of the ray's length, 0 to 1.
    pub fraction: f32,
    /// Point of the hit [m, world].
    pub point: Vec3,
    /// Outward unit normal of the surface [world]. On a mesh it faces the side that the ray came
    /// from. Where a ray starts in a solid shape, it is the normal of the surface nearest to the
    /// start.
    pub normal: Vec3,
    /// Whether the ray starts in the shape: see [`Inside`](crate::query::Inside).
    pub inside: bool,
}

/// A ray of a batch: the segment from `origin` to `origin + delta`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayQuery {
    /// Start of the ray [m, world]; components up to 1e9 m.
    pub origin: Vec3,
    /// Vector from the start to the end [m, world]; components up to 1e9 m.
    pub delta: Vec3,
}

impl RayQuery {
    /// The ray from `origin` by `delta` [m, world].
    #[must_use]
    pub fn new(origin: impl Into<Vec3>, delta: impl Into<Vec3>) -> Self {
        Self { origin: origin.into(), delta: delta.into() }
    }

    pub(super) fn validate(&self) -> Result<(), DefError> {
        all_within("origin", self.origin, &limits::DISPLACEMENT)?;
        all_within("delta", self.delta, &limits::DISPLACEMENT)
    }
}

/// Minimum number of rays for one more thread: fewer are not worth it.
const MIN_RAYS: usize = 32;

/// A hit on the shape of a row.
#[derive(Clone, Copy)]
struct Found {
    row: u32,
    hit: cast::RayHit,
    inside: bool,
}

impl Found {
    /// Orders hits at equal fractions by row, whatever the order of the tree.
    fn is_before(&self, other: &Self) -> bool {
        (self.hit.fraction, self.row) < (other.hit.fraction, other.row)
    }
}

impl Query<'_> {
    /// Returns the first shape on the segment from `origin` to `origin + delta` [m, world] that the
    /// filter sees. Of two at the same fraction, the one in the lower slot wins. The query sees
    /// sensors only if the filter includes them.
    ///
    /// A shape in which the ray starts is hit at fraction 0, unless [`QueryFilter::inside`] says
    /// otherwise. A half-space is hit from above. A ray that starts on a surface and moves along it
    /// or away does not hit it. A mesh has no inside and is hit from both sides. A ray from a point
    /// on a mesh may therefore hit it there, if rounding put the point on the side that the ray
    /// comes from.
    ///
    /// # Errors
    /// A number is not finite, or beyond 1e9 m.
    pub fn cast_ray<'f>(
        &self,
        origin: impl Into<Vec3>,
        delta: impl Into<Vec3>,
        filter: impl Into<QueryFilter<'f>>,
    ) -> Result<Option<RayHit>, DefError> {
        let ray = RayQuery::new(origin, delta);
        ray.validate()?;
        Ok(self.closest_hit(&ray, &filter.into()))
    }

    /// Returns whether the segment from `origin` to `origin + delta` [m, world] hits a shape that
    /// the filter sees. This is cheaper than [`Self::cast_ray`], since it stops at the first hit
    /// found.
    ///
    /// # Errors
    /// The errors of [`Self::cast_ray`].
    pub fn cast_ray_any<'f>(
        &self,
        origin: impl Into<Vec3>,
        delta: impl Into<Vec3>,
        filter: impl Into<QueryFilter<'f>>,
    ) -> Result<bool, DefError> {
        let ray = RayQuery::new(origin, delta);
        ray.validate()?;
        let mut any = false;
        self.each_hit(&ray, &filter.into(), |_, _| {
            any = true;
            -1.0
        });
        Ok(any)
    }

    /// Collects all shapes that the segment from `origin` to `origin + delta` [m, world] hits, each
    /// once, at its first hit. `hits` is cleared first; the hits are sorted by fraction, then by
    /// slot.
    ///
    /// # Errors
    /// The errors of [`Self::cast_ray`]; `hits` is then unchanged.
    pub fn cast_ray_all<'f>(
        &self,
        origin: impl Into<Vec3>,
        delta: impl Into<Vec3>,
        filter: impl Into<QueryFilter<'f>>,
        hits: &mut Vec<RayHit>,
    ) -> Result<(), DefError> {
        let ray = RayQuery::new(origin, delta);
        ray.validate()?;
        hits.clear();
        self.each_hit(&ray, &filter.into(), |found, ray| {
            hits.push(self.ray_hit(ray, &found));
            1.0
        });
        hits.sort_unstable_by(|a, b| {
            a.fraction.total_cmp(&b.fraction).then(a.shape.index().cmp(&b.shape.index()))
        });
        Ok(())
    }

    /// Calls `visit` with the hit of each shape that the segment hits, in unspecified order.
    /// `visit` returns how far the ray continues: `Continue(1.0)` for all of it,
    /// `Continue(hit.fraction)` for nearer hits only, `Break(())` to end it. A shortened ray never
    /// becomes longer again.
    ///
    /// ```
    /// use core::ops::ControlFlow;
    /// use drystone::{BodyDef, DefError, ShapeDef, World};
    /// use drystone::query::QueryFilter;
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let mut world = World::default();
    ///     for x in [2.0, 4.0, 6.0] {
    ///         let pane = BodyDef::fixed().with_position([x, 0.0, 0.0]);
    ///         world.add_body(pane.with_shape(ShapeDef::box_half([0.01, 1.0, 1.0])))?;
    ///     }
    ///     let mut panes = 0;
    ///     world.query().visit_ray([0.0; 3], [5.0, 0.0, 0.0], QueryFilter::default(), |_| {
    ///         panes += 1;
    ///         ControlFlow::Continue(1.0)
    ///     })?;
    ///     assert_eq!(panes, 2);
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// The errors of [`Self::cast_ray`].
    pub fn visit_ray<'f>(
        &self,
        origin: impl Into<Vec3>,
        delta: impl Into<Vec3>,
        filter: impl Into<QueryFilter<'f>>,
        mut visit: impl FnMut(&RayHit) -> ControlFlow<(), f32>,
    ) -> Result<(), DefError> {
        let ray = RayQuery::new(origin, delta);
        ray.validate()?;
        let mut limit = 1.0;
        self.each_hit(&ray, &filter.into(), |found, ray| {
            limit = match visit(&self.ray_hit(ray, &found)) {
                ControlFlow::Continue(shorter) if shorter < limit => greater(shorter, 0.0),
                ControlFlow::Continue(_) => limit,
                ControlFlow::Break(()) => -1.0,
            };
            limit
        });
        Ok(())
    }

    /// Runs [`Self::cast_ray`] for each ray of a batch, on the threads of the world's executor.
    /// `hits` is cleared first; hit `k` belongs to ray `k`. The hits are the same for any number of
    /// threads.
    ///
    /// ```
    /// use drystone::{BodyDef, DefError, ShapeDef, World};
    /// use drystone::query::{QueryFilter, RayQuery};
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let mut world = World::default();
    ///     world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    ///     let rays: Vec<_> = (0..100_u8)
    ///         .map(|k| RayQuery::new([f32::from(k), 2.0, 0.0], [0.0, -4.0, 0.0]))
    ///         .collect();
    ///     let mut hits = Vec::new();
    ///     world.query().cast_rays(&rays, QueryFilter::default(), &mut hits)?;
    ///     assert!(hits.iter().all(|hit| hit.is_some_and(|hit| hit.fraction == 0.5)));
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// A number of a ray is not finite, or beyond 1e9 m; `hits` is then unchanged.
    pub fn cast_rays<'f>(
        &self,
        rays: &[RayQuery],
        filter: impl Into<QueryFilter<'f>>,
        hits: &mut Vec<Option<RayHit>>,
    ) -> Result<(), DefError> {
        for (k, ray) in rays.iter().enumerate() {
            ray.validate().map_err(|e| e.within(&format!("rays[{k}]")))?;
        }
        let filter = filter.into();
        hits.clear();
        hits.resize(rays.len(), None);
        self.with_jobs(|jobs| {
            for_items(jobs, hits, grain(jobs, rays.len(), MIN_RAYS), |first, hits| {
                for (ray, hit) in rays[first..].iter().zip(hits) {
                    *hit = self.closest_hit(ray, &filter);
                }
            });
        });
        Ok(())
    }

    /// The closest hit of a validated ray.
    fn closest_hit(&self, ray: &RayQuery, filter: &QueryFilter<'_>) -> Option<RayHit> {
        let mut best: Option<(Found, RayQuery)> = None;
        self.each_hit(ray, filter, |found, ray| {
            if best.is_none_or(|(best, _)| found.is_before(&best)) {
                best = Some((found, *ray));
            }
            best.map_or(1.0, |(best, _)| best.hit.fraction)
        });
        best.map(|(found, ray)| self.ray_hit(&ray, &found))
    }

    /// Calls `visit` with the first hit of each shape within the limit, and with the ray as cast:
    /// lifted off the surfaces that it slides along. `visit` returns the new limit as a fraction of
    /// the ray; a negative limit stops the query.
    fn each_hit(
        &self,
        ray: &RayQuery,
        filter: &QueryFilter<'_>,
        mut visit: impl FnMut(Found, &RayQuery) -> f32,
    ) {
        let point = Solid { core: Core::Point, radius: 0.0 };
        let (sliding, delta) = self.sliding(&point, &Pose::at(ray.origin), ray.delta, filter);
        let origin = ray.origin + sliding.off * sliding.minimum;
        let ray = RayQuery { origin, delta };
        let slack = ROUNDING * greater(origin.abs().max_element(), delta.abs().max_element());
        let mut limit = 1.0;
        for tree in [&self.tables.bounds.fixed, &self.tables.bounds.moving] {
            if limit < 0.0 {
                return;
            }
            tree.ray(&Ray::new(origin, delta), limit, |row| {
                let shape = self.tables.shapes.at(row);
                let pose = self.pose(shape);
                let (o, d) = (pose.local_point(origin), pose.local_direction(delta));
                let found = meet(&shape.solid, o, d, limit, filter.inside, slack);
                if let Some((hit, inside)) = found
                    && filter.sees(self.tables, row)
                {
                    let normal = pose.direction(hit.normal);
                    let hit = cast::RayHit { normal, ..hit };
                    limit = visit(Found { row, hit, inside }, &ray);
                }
                limit
            });
        }
    }

    fn ray_hit(&self, ray: &RayQuery, found: &Found) -> RayHit {
        let fraction = found.hit.fraction;
        RayHit {
            shape: self.tables.shapes.id(found.row),
            body: self.tables.bodies.id(self.tables.shapes.at(found.row).body),
            fraction,
            point: ray.origin + ray.delta * fraction,
            normal: found.hit.normal,
            inside: found.inside,
        }
    }
}

/// Returns the hit of a ray on a solid (both in the solid's frame) up to the fraction `limit`, and
/// whether the ray starts inside. A start no deeper than `slack` [m] plus a few roundings counts as
/// on the surface.
pub(super) fn meet(
    solid: &Solid,
    origin: Vec3,
    delta: Vec3,
    limit: f32,
    inside: Inside,
    slack: f32,
) -> Option<(cast::RayHit, bool)> {
    let Some(depth) = cast::depth(solid, origin) else {
        return cast::ray(solid, origin, delta, limit).map(|hit| (hit, false));
    };
    let at_start = cast::RayHit { fraction: 0.0, normal: depth.normal };
    if depth.is_on_surface(slack) {
        return depth.is_entered_along(delta).then_some((at_start, false));
    }
    match inside {
        Inside::Solid => Some((at_start, true)),
        Inside::Hollow => cast::exit(solid, origin, delta, limit).map(|hit| (hit, true)),
        Inside::Ignore => None,
    }
}
