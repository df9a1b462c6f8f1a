//! Stage 5: lines become poses; bounds, sleep timers and faults follow.
//!
//! Reads: solver lines. Writes: bodies (pose, velocity, timers), shapes and bounds (boxes). Runs:
//! parallel over awake bodies; trees are changed serially in body order.

use super::context::StepContext;
use super::solver;
use super::solver::integrate;
use crate::base::aabb::Aabb;
use crate::base::disjoint::Rows;
use crate::base::jobs::{Executor, collect_ranges, grain};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::state::bodies::{Bodies, Body};
use crate::state::bounds::Bounds;
use crate::state::def::BodyKind;
use crate::state::shapes::Shapes;

/// What finalize found out about a body.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Note {
    /// A shape left its box in the tree: row and new box.
    Escaped(u32, Aabb),
    /// The body moved far for its size: row and where its center was.
    Fast(u32, Vec3),
    /// The body's state became non-finite; it was put back.
    Fault(u32),
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    notes: Vec<Vec<Note>>,
    boxes: Vec<(u32, Aabb)>,
}

impl Scratch {
    pub(crate) fn notes(&self) -> impl Iterator<Item = Note> {
        self.notes.iter().flatten().copied()
    }
}

/// Moves all awake bodies and enlarges the boxes of those that left theirs.
pub(crate) fn advance_poses(
    ctx: &StepContext,
    sleep_speed: f32,
    bodies: &mut Bodies,
    shapes: &mut Shapes,
    bounds: &mut Bounds,
    lines: &solver::Scratch,
    scratch: &mut Scratch,
    jobs: &dyn Executor,
) {
    let Bodies { rows, awake } = bodies;
    let slots = Rows::new(rows.values_mut());
    let table = &*shapes;
    let least = grain(jobs, awake.len(), 64);
    collect_ranges(jobs, awake.len(), least, &mut scratch.notes, |range, out| {
        for row in &awake[range] {
            let Some(body) = slots.row(*row as usize) else { continue };
            advance(ctx, body, *row, lines, out);
            if let Some(Note::Fault(_)) = out.last() {
                continue;
            }
            rate_stillness(ctx, sleep_speed, body);
            for shape in &body.shapes {
                let fits = shape_box(table, *shape, body, ctx);
                if !table.at(*shape).fat.contains(&fits) {
                    out.push(Note::Escaped(*shape, fat_box(&fits, body, ctx)));
                }
            }
        }
    });
    scratch.boxes.clear();
    for note in scratch.notes.iter().flatten().copied() {
        if let Note::Escaped(shape, fat) = note {
            shapes.at_mut(shape).fat = fat;
            scratch.boxes.push((shape, fat));
            bounds.moved.push(shape);
        }
    }
    bounds.moving.replace_all(&scratch.boxes, jobs);
}

/// How far a body moves in a step [m], but no farther than its size: contacts are not looked for
/// beyond that (narrowphase), only rays are cast (sweep).
fn reach(body: &Body, ctx: &StepContext) -> Vec3 {
    let step = body.v * ctx.dt;
    let length = step.length();
    let most = if body.extent > 0.0 { body.extent } else { length };
    if length > most { step * (most / length) } else { step }
}

/// The box that a shape needs: its own with the contact margin, reaching as far as it moves in a step.
pub(crate) fn shape_box(shapes: &Shapes, shape: u32, body: &Body, ctx: &StepContext) -> Aabb {
    let row = shapes.at(shape);
    let pose = Pose { position: body.center, rotation: body.rotation }.compose(&row.centered);
    let tight = row.solid.aabb(&pose).grown(0.5 * ctx.margin);
    let step = reach(body, ctx);
    tight.union(&Aabb::new(tight.min + step, tight.max + step))
}

/// That box with room to move, so that the tree is not changed every step.
pub(crate) fn fat_box(fits: &Aabb, body: &Body, ctx: &StepContext) -> Aabb {
    let step = reach(body, ctx);
    let room = ctx.margin + (0.1 * body.extent).min(0.1);
    fits.union(&Aabb::new(fits.min + step, fits.max + step)).grown(room)
}

fn advance(
    ctx: &StepContext,
    body: &mut Body,
    row: u32,
    lines: &solver::Scratch,
    out: &mut Vec<Note>,
) {
    let (center, rotation) = (body.center, body.rotation);
    let line = lines.line_of[row as usize] as usize;
    if body.kind == BodyKind::Kinematic {
        body.center += body.v * ctx.dt;
        body.rotation = body.rotation.turned_by(body.w * ctx.dt);
    } else if line == 0 {
        integrate::fly(ctx, body);
    } else {
        integrate::unwhiten(&lines.lines[line], &lines.whitening[line], body);
    }
    body.step_force = Vec3::ZERO;
    body.step_torque = Vec3::ZERO;
    let pose_ok = body.center.is_finite() && body.rotation.is_finite();
    // Beyond this no box or distance is meaningful in f32; it is as good as infinite.
    let near = body.center.abs().max_element() < 1.0e9;
    if !(pose_ok && near && body.v.is_finite() && body.w.is_finite()) {
        (body.center, body.rotation) = (center, rotation);
        (body.v, body.w) = (Vec3::ZERO, Vec3::ZERO);
        out.push(Note::Fault(row));
        return;
    }
    let moved = (body.center - center).length();
    if body.is_dynamic() && moved > 0.5 * body.inner {
        out.push(Note::Fast(row, center));
    }
}

fn rate_stillness(ctx: &StepContext, sleep_speed: f32, body: &mut Body) {
    let limit = if body.sleep_speed >= 0.0 { body.sleep_speed } else { sleep_speed };
    // A body without shapes has no extent, but may well spin.
    let reach = if body.extent > 0.0 { body.extent } else { 1.0 };
    let speed = body.v.length() + body.w.length() * reach;
    body.still_time = if speed < limit { body.still_time + ctx.dt } else { 0.0 };
}
