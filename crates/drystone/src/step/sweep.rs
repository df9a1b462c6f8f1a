//! Stage 6: fast bodies are stopped at what does not move, instead of passing through it.
//!
//! Reads: shapes, bounds. Writes: bodies (pose), bounds. Runs: parallel over fast bodies; what is found
//! is applied in body order. A ray from the old to the new center must not cross a fixed shape, nor a body
//! that was clear of it end deep in it: contacts made within a body's size are the solver's, so this is only
//! for bodies that move farther than half their inner size in a step.

use super::context::StepContext;
use super::finalize::{Note, fat_box, shape_box};
use crate::base::jobs::{Executor, collect_ranges, grain};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::geometry::cast;
use crate::state::bodies::{Bodies, Body};
use crate::state::bounds::Bounds;
use crate::state::shapes::{ShapeRow, Shapes};

/// How far beyond its way a body's ray is cast, in its own sizes: what comes in flatter than 1 in 5 moves
/// less than its size toward the surface in a step of five, and has contacts before it is there.
const AHEAD: f32 = 5.0;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// Row, where the center was and how the body stood.
    fast: Vec<(u32, Vec3, Quat)>,
    /// Row and where the center is to be.
    stopped: Vec<Vec<(u32, Vec3)>>,
}

/// Pulls fast bodies back to the first fixed shape on their way.
pub(crate) fn stop_fast_bodies(
    ctx: &StepContext,
    notes: impl Iterator<Item = Note>,
    bodies: &mut Bodies,
    shapes: &mut Shapes,
    bounds: &mut Bounds,
    scratch: &mut Scratch,
    jobs: &dyn Executor,
) {
    let Scratch { fast, stopped } = scratch;
    fast.clear();
    fast.extend(notes.filter_map(|note| match note {
        Note::Fast(row, from, stood) => Some((row, from, stood)),
        _ => None,
    }));
    let (table, solids, trees) = (&*bodies, &*shapes, &*bounds);
    collect_ranges(jobs, fast.len(), grain(jobs, fast.len(), 32), stopped, |range, out| {
        for (row, from, stood) in &fast[range] {
            let body = table.at(*row);
            let delta = body.center - *from;
            if let Some(stop) = first_stop(body, *row, (*from, *stood), delta, table, solids, trees)
            {
                out.push((*row, *from + delta * stop.max(0.0)));
            }
        }
    });
    for (row, center) in stopped.iter().flatten() {
        let body = bodies.at_mut(*row);
        body.center = *center;
        body.room = 0.0;
        for i in 0..bodies.at(*row).shapes.len() {
            let body = bodies.at(*row);
            let shape = body.shapes[i];
            let fits = shape_box(shapes, shape, body, ctx);
            if !shapes.at(shape).fat.contains(&fits) {
                let fat = fat_box(&fits, body, ctx);
                bounds.replace(shape, fat, shapes);
            }
        }
    }
}

/// The part of its way after which the body is to stop at a fixed shape.
fn first_stop(
    body: &Body,
    row: u32,
    (from, stood): (Vec3, Quat),
    delta: Vec3,
    bodies: &Bodies,
    shapes: &Shapes,
    bounds: &Bounds,
) -> Option<f32> {
    let meets = |other: &ShapeRow| {
        body.shapes
            .iter()
            .map(|s| shapes.at(*s))
            .any(|s| !s.sensor && s.filter.collides_with(other.filter))
    };
    let ahead = AHEAD * body.extent / delta.length();
    let mut first = None;
    bounds.fixed.ray(from, delta, 1.0 + ahead, |item| {
        // What is farther than that behind the first stop stops the body no earlier.
        let limit = first.unwrap_or(1.0) + ahead;
        let shape = shapes.at(item);
        if shape.body == row || shape.sensor || !meets(shape) {
            return limit;
        }
        let pose = bodies.at(shape.body).pose().compose(&shape.local);
        let (o, d) = (pose.local_point(from), pose.local_direction(delta));
        if let Some(hit) = cast::ray(&shape.solid, o, d, limit)
            && let Some(stop) =
                stop_at(body, stood, delta, (hit.fraction, pose.direction(hit.normal)), shapes)
        {
            first = Some(first.unwrap_or(1.0_f32).min(stop.max(hit.fraction - ahead)));
        }
        first.unwrap_or(1.0) + ahead
    });
    first
}

/// Where a body stops whose center's ray meets a surface: with its own surface about at that of the
/// shape, and the next step's contacts do the rest. A body stopped deeper could be knocked on by another
/// until its center is inside a thin wall, and a leg of it that came through would be pushed out on
/// the other side.
fn stop_at(
    body: &Body,
    stood: Quat,
    delta: Vec3,
    (fraction, normal): (f32, Vec3),
    shapes: &Shapes,
) -> Option<f32> {
    let closing = -normal.dot(delta);
    if fraction > 1.0 && (fraction - 1.0) * closing > body.extent - body.inner {
        // It ends higher than it can reach.
        return None;
    }
    if closing > 0.0 && fraction * closing >= reach_against(body, stood, normal, shapes) {
        // It was clear of the surface when the step began.
        let reach = reach_against(body, body.rotation, normal, shapes);
        let height = (fraction - 1.0) * closing;
        // To less than that a contact answers, by the energy it has at the surface; to be taken back is
        // to be lifted.
        let deep = height < reach - body.inner;
        return deep.then(|| fraction - (reach - 0.05 * body.inner) / closing);
    }
    // It was near, and had contacts: those hold it, unless its center is to pass.
    (fraction <= 1.0).then(|| fraction - 0.95 * body.inner / delta.length())
}

/// How far the body's shapes stand out from its center against a direction [m].
fn reach_against(body: &Body, rotation: Quat, normal: Vec3, shapes: &Shapes) -> f32 {
    let rotation = Quat::from_arc(normal, Vec3::X) * rotation;
    let turned = Pose { position: Vec3::ZERO, rotation };
    let mut reach = 0.0_f32;
    for row in &body.shapes {
        let shape = shapes.at(*row);
        // A body of many shapes reaches by one.
        let (center, radius) = shape.solid.ball();
        let ball = 1.001 * radius - turned.direction(shape.centered.point(center)).x;
        if !shape.sensor && ball > reach {
            reach = reach.max(-shape.solid.aabb(&turned.compose(&shape.centered)).min.x);
        }
    }
    reach.min(body.extent)
}
