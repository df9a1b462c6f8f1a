//! Stage 6: fast bodies are stopped at what does not move, instead of passing through it.
//!
//! Reads: shapes, bounds. Writes: bodies (pose), bounds. Runs: parallel over fast bodies; what is found
//! is applied in body order. A ray from the old to the new center must not cross a fixed shape, nor a body
//! that was clear of it end deep in it: contacts made within a body's size are the solver's, so this is only
//! for bodies that move farther than half their inner size in a step.

use super::context::StepContext;
use super::finalize::{Note, fat_box, shape_box};
use crate::base::grow::Slack;
use crate::base::jobs::{Executor, collect_ranges, grain};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::geometry::boxes::Ray;
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
    slack: Slack,
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
    let Scratch { fast, stopped, slack } = scratch;
    fast.clear();
    fast.extend(notes.filter_map(|note| match note {
        Note::Fast(row, from, stood) => Some((row, from, stood)),
        _ => None,
    }));
    if let Some(enough) = slack.look(fast.len()) {
        fast.shrink_to(enough);
    }
    let around = Around { bodies, shapes, bounds };
    collect_ranges(jobs, fast.len(), grain(jobs, fast.len(), 8), stopped, |_, range, out| {
        for (row, from, stood) in &fast[range] {
            let body = around.bodies.at(*row);
            let delta = body.center - *from;
            if let Some(stop) = first_stop(body, *row, (*from, *stood), delta, &around) {
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

/// What stands around.
struct Around<'a> {
    bodies: &'a Bodies,
    shapes: &'a Shapes,
    bounds: &'a Bounds,
}

/// What is swept: a body, or a part of one.
struct Swept<'a> {
    body: &'a Body,
    shapes: &'a [u32],
    /// Where its middle is [m, frame of the center of mass].
    middle: Vec3,
    /// Greatest distance from the middle to its surface [m].
    extent: f32,
}

/// The part of its way after which the body is to stop at a fixed shape. One whose center of mass is outside
/// of itself, as a ring's, is swept shape by shape: what its center meets says nothing, and a ring would
/// hang on the top of the peg that goes through it.
fn first_stop(
    body: &Body,
    row: u32,
    (from, stood): (Vec3, Quat),
    delta: Vec3,
    around: &Around<'_>,
) -> Option<f32> {
    if !body.hollow || body.shapes.len() < 2 {
        let whole = Swept { body, shapes: &body.shapes, middle: Vec3::ZERO, extent: body.extent };
        return first_stop_of(&whole, row, (from, stood), delta, around);
    }
    let mut first: Option<f32> = None;
    for shape in &body.shapes {
        let s = around.shapes.at(*shape);
        let (middle, extent) = s.solid.ball();
        let middle = s.centered.point(middle);
        let begin = from + stood.rotate(middle);
        let way = body.center + body.rotation.rotate(middle) - begin;
        let part = Swept { body, shapes: core::slice::from_ref(shape), middle, extent };
        let stop = first_stop_of(&part, row, (begin, stood), way, around);
        first = match (first, stop) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
    }
    first
}

fn first_stop_of(
    swept: &Swept<'_>,
    row: u32,
    (from, stood): (Vec3, Quat),
    delta: Vec3,
    around: &Around<'_>,
) -> Option<f32> {
    if delta == Vec3::ZERO {
        return None;
    }
    let Around { bodies, shapes, bounds } = around;
    let meets = |other: &ShapeRow| {
        swept
            .shapes
            .iter()
            .map(|s| shapes.at(*s))
            .any(|s| !s.sensor && s.filter.collides_with(other.filter))
    };
    let ahead = AHEAD * swept.extent / delta.length();
    let mut first = None;
    bounds.fixed.ray(&Ray::new(from, delta), 1.0 + ahead, |item| {
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
                stop_at(swept, stood, delta, (hit.fraction, pose.direction(hit.normal)), shapes)
        {
            first = Some(first.unwrap_or(1.0_f32).min(stop.max(hit.fraction - ahead)));
        }
        first.unwrap_or(1.0) + ahead
    });
    first
}

/// Where a body stops whose middle's ray meets a surface: with its own surface about at that of the
/// shape, and the next step's contacts do the rest. A body stopped deeper could be knocked on by another
/// until its center is inside a thin wall, and a leg of it that came through would be pushed out on
/// the other side.
fn stop_at(
    swept: &Swept<'_>,
    stood: Quat,
    delta: Vec3,
    (fraction, normal): (f32, Vec3),
    shapes: &Shapes,
) -> Option<f32> {
    let closing = -normal.dot(delta);
    if fraction > 1.0 && (fraction - 1.0) * closing > swept.extent - swept.body.inner {
        // It ends higher than it can reach.
        return None;
    }
    if closing > 0.0 && fraction * closing >= reach_against(swept, stood, normal, shapes) {
        // It was clear of the surface when the step began.
        let reach = reach_against(swept, swept.body.rotation, normal, shapes);
        let height = (fraction - 1.0) * closing;
        // To less than that a contact answers, by the energy it has at the surface; to be taken back is
        // to be lifted.
        let deep = height < reach - swept.body.inner;
        return deep.then(|| fraction - (reach - 0.05 * swept.body.inner) / closing);
    }
    // It was near, and had contacts: those hold it, unless its center is to pass.
    (fraction <= 1.0).then(|| fraction - 0.95 * swept.body.inner / delta.length())
}

/// How far what is swept stands out from its middle against a direction [m].
fn reach_against(swept: &Swept<'_>, rotation: Quat, normal: Vec3, shapes: &Shapes) -> f32 {
    let rotation = Quat::from_arc(normal, Vec3::X) * rotation;
    let turned = Pose { position: Vec3::ZERO, rotation };
    let middle = turned.direction(swept.middle).x;
    let mut reach = 0.0_f32;
    for row in swept.shapes {
        let shape = shapes.at(*row);
        // A body of many shapes reaches by one.
        let (center, radius) = shape.solid.ball();
        let ball = middle + 1.001 * radius - turned.direction(shape.centered.point(center)).x;
        if !shape.sensor && ball > reach {
            let low = shape.solid.least_x(&turned.compose(&shape.centered));
            reach = reach.max(middle - low);
        }
    }
    reach.min(swept.extent)
}
