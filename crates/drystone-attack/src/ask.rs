//! Asks a world one query in all its forms; the answers must agree.

use core::ops::ControlFlow;

use drystone::query::{Inside, Motion, Query, QueryFilter, RayHit, RayQuery, ShapeHit, ShapeQuery};
use drystone::{Filter, Pose, Shape, Vec3, World};

use crate::apply::{Done, look, shape};
use crate::finding::{Findings, Kind};
use crate::op::{Form, QueryCall};

/// Collects the findings of a query.
struct Report<'a> {
    findings: &'a mut Findings,
    step: u32,
}

impl Report<'_> {
    fn numbers(&mut self, of: &str, answer: &impl core::fmt::Debug) {
        look(self.findings, of, &format!("{answer:?}"), self.step);
    }

    fn agree(&mut self, what: &str, agree: bool, of: &impl core::fmt::Debug) {
        if !agree {
            self.findings.add(Kind::Disagree, what, format!("{of:?}"), self.step);
        }
    }
}

/// Runs a query, and other queries whose answers follow from its answer.
pub(crate) fn ask(world: &World, call: &QueryCall, findings: &mut Findings, step: u32) -> Done {
    let (q, mut report) = (world.query(), Report { findings, step });
    let answered = match call {
        QueryCall::Ray(origin, delta, filter) => {
            let ray = RayQuery::new(*origin, *delta);
            [Inside::Solid, Inside::Hollow, Inside::Ignore]
                .iter()
                .try_for_each(|inside| rays(&q, ray, &asked(*filter, *inside), &mut report))
        }
        QueryCall::OverlapBounds(bounds, filter) => q.overlap_bounds(*bounds, *filter).map(|_| ()),
        QueryCall::OverlapPoint(point, filter) => q.overlap_point(*point, *filter).map(|_| ()),
        QueryCall::OverlapShape(form, pose, filter) => {
            let Some(shape) = shape(form) else { return Done::Refused };
            overlaps(&q, &shape, *pose, *filter, &mut report)
        }
        QueryCall::CastShape(form, pose, [way, turn], filter) => {
            let Some(shape) = shape(form) else { return Done::Refused };
            let cast = ShapeQuery::new(*pose, Motion::by(*way).with_turn(*turn));
            [Inside::Solid, Inside::Ignore].iter().try_for_each(|inside| {
                casts(&q, &shape, cast, &asked(*filter, *inside), &mut report)
            })
        }
        QueryCall::Nearest(form, pose, reach, filter) => {
            let Some(shape) = shape(form) else { return Done::Refused };
            nearest(&q, &shape, *pose, *reach, *filter, &mut report)
        }
        QueryCall::Pair(both, reach) => pair(both, *reach, &mut report),
    };
    if answered.is_ok() { Done::Yes } else { Done::Refused }
}

fn asked(filter: Filter, inside: Inside) -> QueryFilter<'static> {
    let filter = QueryFilter::from(filter).with_inside(inside);
    if inside == Inside::Ignore { filter.with_sensors() } else { filter }
}

type Asked = Result<(), drystone::DefError>;

fn rays(q: &Query<'_>, ray: RayQuery, filter: &QueryFilter<'_>, report: &mut Report<'_>) -> Asked {
    let RayQuery { origin, delta } = ray;
    let closest = q.cast_ray(origin, delta, filter)?;
    report.numbers("RayHit", &closest);
    let mut all: Vec<RayHit> = Vec::new();
    q.cast_ray_all(origin, delta, filter, &mut all)?;
    report.agree("the closest hit is the first of all", all.first() == closest.as_ref(), &all);
    let any = q.cast_ray_any(origin, delta, filter)?;
    report.agree("a ray hits anything if it hits", any == closest.is_some(), &all);
    let mut batch = Vec::new();
    q.cast_rays(&[ray; 3], filter, &mut batch)?;
    report.agree("a batch gives the same hits", batch == [closest; 3], &batch);
    let mut visited = 0;
    q.visit_ray(origin, delta, filter, |_| {
        visited += 1;
        ControlFlow::Continue(1.0)
    })?;
    report.agree("all hits are visited", visited == all.len(), &all);
    Ok(())
}

fn casts(
    q: &Query<'_>,
    shape: &Shape,
    cast: ShapeQuery,
    filter: &QueryFilter<'_>,
    report: &mut Report<'_>,
) -> Asked {
    let ShapeQuery { pose, motion } = cast;
    let closest = q.cast_shape(shape, pose, motion, filter)?;
    report.numbers("ShapeHit", &closest);
    let mut all: Vec<ShapeHit> = Vec::new();
    q.cast_shape_all(shape, pose, motion, filter, &mut all)?;
    report.agree("the closest meeting is the first of all", all.first() == closest.as_ref(), &all);
    let any = q.cast_shape_any(shape, pose, motion, filter)?;
    report.agree("a shape meets anything if it meets", any == closest.is_some(), &all);
    let mut batch = Vec::new();
    q.cast_shapes(shape, &[cast; 2], filter, &mut batch)?;
    report.agree("a batch gives the same meetings", batch == [closest; 2], &batch);
    Ok(())
}

fn overlaps(
    q: &Query<'_>,
    shape: &Shape,
    pose: Pose,
    filter: Filter,
    report: &mut Report<'_>,
) -> Asked {
    let all = q.overlap_shape(shape, pose, filter)?;
    let any = q.overlap_shape_any(shape, pose, filter)?;
    report.agree("a shape overlaps anything if it overlaps", any != all.is_empty(), &all);
    Ok(())
}

fn nearest(
    q: &Query<'_>,
    shape: &Shape,
    pose: Pose,
    reach: f32,
    filter: Filter,
    report: &mut Report<'_>,
) -> Asked {
    let nearest = q.nearest_shape(shape, pose, reach, filter)?;
    report.numbers("NearestShape", &nearest);
    let mut all = Vec::new();
    q.nearest_all(shape, pose, reach, filter, &mut all)?;
    report.numbers("NearestShape", &all);
    report.agree("something is near if it is nearest", nearest.is_some() != all.is_empty(), &all);
    Ok(())
}

fn pair(both: &[(Form, Pose); 2], reach: f32, report: &mut Report<'_>) -> Asked {
    let [(a, at_a), (b, at_b)] = both;
    let (Some(a), Some(b)) = (shape(a), shape(b)) else { return Ok(()) };
    report.numbers("ClosestPoints", &a.closest_points(*at_a, &b, *at_b, reach)?);
    report.numbers("ShapeContact", &a.contacts(*at_a, &b, *at_b, 0.0)?);
    let distance = a.distance(*at_a, &b, *at_b)?;
    report.numbers("distance", &distance);
    let way: Vec3 = at_b.position - at_a.position;
    report.numbers("CastHit", &a.cast(*at_a, way, &b, *at_b)?);
    report.numbers("CastHit", &b.cast_ray(*at_b, at_a.position, way, Inside::Hollow)?);
    Ok(())
}
