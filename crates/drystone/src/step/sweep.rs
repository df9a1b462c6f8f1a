//! Stage 6: fast bodies are stopped at what does not move, instead of passing through it.
//!
//! Reads: shapes, bounds. Writes: bodies (pose), bounds. Runs: parallel over fast bodies; what is found
//! is applied in body order. A ray from the old to the new center must not cross a fixed shape: contacts
//! made within a body's size are the solver's, so this is only for bodies that move farther than half
//! their inner size in a step.

use super::context::StepContext;
use super::finalize::{Note, fat_box, shape_box};
use crate::base::jobs::{Executor, collect_ranges, grain};
use crate::base::math::Vec3;
use crate::geometry::cast;
use crate::state::bodies::{Bodies, Body};
use crate::state::bounds::Bounds;
use crate::state::shapes::{ShapeRow, Shapes};

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// Row and where the center was.
    fast: Vec<(u32, Vec3)>,
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
        Note::Fast(row, from) => Some((row, from)),
        _ => None,
    }));
    let (table, solids, trees) = (&*bodies, &*shapes, &*bounds);
    collect_ranges(jobs, fast.len(), grain(jobs, fast.len(), 32), stopped, |range, out| {
        for (row, from) in &fast[range] {
            let body = table.at(*row);
            let delta = body.center - *from;
            if let Some(fraction) = first_hit(body, *row, *from, delta, table, solids, trees) {
                // Stops with its own surface about at that of the shape: the next step's contacts do
                // the rest. A body stopped deeper could be knocked on by another until its center is
                // inside a thin wall.
                let back = 0.95 * body.inner / delta.length();
                out.push((*row, *from + delta * (fraction - back).max(0.0)));
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

fn first_hit(
    body: &Body,
    row: u32,
    from: Vec3,
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
    let mut first = None;
    bounds.fixed.ray(from, delta, 1.0, |item| {
        let limit = first.unwrap_or(1.0);
        let shape = shapes.at(item);
        if shape.body == row || shape.sensor || !meets(shape) {
            return limit;
        }
        let pose = bodies.at(shape.body).pose().compose(&shape.local);
        let (o, d) = (pose.local_point(from), pose.local_direction(delta));
        if let Some(hit) = cast::ray(&shape.solid, o, d, limit) {
            first = Some(hit.fraction);
        }
        first.unwrap_or(1.0)
    });
    first
}
