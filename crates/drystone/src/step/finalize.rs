//! The stage `finalize`: turns solver bodies into poses, then updates bounds, sleep timers and
//! faults.
//!
//! Reads: solver bodies. Writes: bodies (pose, velocity, timers, path lengths), shapes and bounds
//! (boxes). Runs: in parallel over awake bodies; the tree is refitted in parallel when many bodies
//! have moved.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use fearless_simd::{Simd, dispatch};

use super::context::StepContext;
use super::flight;
use super::flight::Spins;
use super::notes::{Flight, Note};
use super::reach::{Need, flies, reach_of_all};
use super::sleep::freeze;
use super::solver::body::integrate;
use super::solver::body::solved::Solved;
use crate::base::aabb::Aabb;
use crate::base::grow::Slack;
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::base::threads::disjoint::{Apart, ReadRows, Rows};
use crate::base::threads::jobs::{Jobs, Output, collect_ranges, grain};
use crate::state::bodies::body::Body;
use crate::state::bodies::stillness::{Stillness, StillnessRule};
use crate::state::bodies::{Bodies, Track};
use crate::state::bounds::Bounds;
use crate::state::def::BodyKind;
use crate::state::shapes::{ShapeRow, Shapes};

/// Findings about some bodies, in the order of the bodies.
#[derive(Clone, Debug, Default)]
struct Found {
    /// Shapes that left their boxes in the tree, with their new boxes.
    escaped: Vec<(u32, Aabb)>,
    /// Bodies that moved far for their size.
    fast: Vec<Flight>,
    notes: Vec<Note>,
}

impl Output for Found {
    fn clear(&mut self) {
        self.escaped.clear();
        self.fast.clear();
        self.notes.clear();
    }
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    found: Vec<Found>,
    boxes: Vec<(u32, Aabb)>,
    slack: Slack,
}

impl Scratch {
    /// Findings, in the order of the awake bodies.
    pub(crate) fn notes(&self) -> impl Iterator<Item = Note> {
        self.found.iter().flat_map(|found| &found.notes).copied()
    }

    /// Bodies that moved far, in the same order, chunk by chunk.
    pub(crate) fn flights(&self) -> impl Iterator<Item = &[Flight]> {
        self.found.iter().map(|found| found.fast.as_slice())
    }
}

/// Moves all awake bodies and enlarges the boxes of those that left theirs.
pub(crate) fn advance_poses(
    ctx: &StepContext,
    bodies: &mut Bodies,
    shapes: &mut Shapes,
    bounds: &mut Bounds,
    solved: &Solved,
    scratch: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    let Scratch { found, boxes, slack } = scratch;
    let (sleep, by_energy) = (&ctx.stillness(), ctx.wakes_alone);
    let Bodies { rows, awake, tracks, stillness, .. } = bodies;
    // SAFETY: awake bodies are all different, and each has shapes of its own.
    let apart = unsafe { Apart::promise() };
    let (tracks, stillness) = (Rows::new(tracks, apart), Rows::new(stillness, apart));
    let (rows, table) = (rows.values_mut(), shapes.rows.values_mut());
    // Bodies with many shapes are more work, so a chunk has fewer of them.
    let each = table.len() / rows.len().max(1);
    let (bodies, table) = (Rows::new(rows, apart), Rows::new(table, apart));
    let minimum = grain(jobs, awake.len(), FLOCK / each.clamp(1, 8));
    collect_ranges(jobs, awake.len(), minimum, found, |range, out| {
        let mut still = false;
        for flock in awake[range].chunks(FLOCK) {
            let before = advance(ctx, flock, &bodies, solved);
            for (k, (row, (center, rotation))) in flock.iter().zip(before).enumerate() {
                if let Some(soon) = flock.get(k + PREFETCH) {
                    prefetch_shapes(ctx, *soon, &bodies, &table);
                }
                let Some(body) = bodies.row(*row as usize) else { continue };
                if !arrive(body, *row, (center, rotation), &mut out.notes) {
                    continue;
                }
                body.history.last_h = if ctx.is_soft { ctx.h } else { 0.0 };
                let known = stillness.row(*row as usize);
                let parting = solved.parting(body.is_dynamic(), *row);
                rate_stillness(ctx, sleep, (by_energy, parting), body, known);
                still |= body.can_sleep && body.sleep.still_time >= sleep.time;
                let moved = max_moved(body, center, rotation);
                body.room -= moved;
                let path = &mut tracks.row(*row as usize).path;
                *path = path.wrapping_add(Track::at_least(moved * ctx.per_track));
                // Most bodies at rest or creeping have enough room; their shapes need not be read.
                let flew = body.flies;
                let mut in_boxes = true;
                if flew || !(body.room > reach_of_all(body, ctx)) {
                    body.flies = body.is_dynamic() && flies(body, ctx);
                    dispatch!(ctx.level, simd => {
                        in_boxes = fit_all(simd, body, flew, ctx, &table, &mut out.escaped);
                    });
                }
                // A link moves with its tree, so it cannot be stopped alone.
                let may_stop = !body.record.is_link;
                if may_stop && moved > 0.5 * body.inner && goes_far(body, center, moved) {
                    let flight =
                        Flight { row: *row, from: center, stood: rotation, in_boxes, flew };
                    out.fast.push(flight);
                }
            }
        }
        if still {
            out.notes.push(Note::Still);
        }
    });
    boxes.clear();
    for Found { escaped, .. } in found.iter() {
        boxes.extend_from_slice(escaped);
        bounds.moved.extend(escaped.iter().map(|(shape, _)| shape));
    }
    bounds.moving.replace_all(boxes, jobs);
    let flights = found.iter().map(|found| found.fast.len()).sum();
    if let Some(enough) = slack.look(boxes.len().max(flights)) {
        boxes.shrink_to(enough);
        bounds.moved.shrink_to(enough);
        for found in found {
            found.escaped.shrink_to(enough);
            found.fast.shrink_to(enough);
            found.notes.shrink_to(enough);
        }
    }
}

/// True if the body may have passed something: its center moved farther than half its inner size,
/// or its ends turned farther than all of it. (A body that is as thick as it is long turns in its
/// place.)
fn goes_far(body: &Body, center: Vec3, moved: f32) -> bool {
    let strides = (body.center - center).length();
    strides > 0.5 * body.inner || (moved - strides > body.inner && body.extent > ROUND * body.inner)
}

/// A body that reaches no farther than this part of its inner size counts as a ball: the corners of
/// a cube reach √3.
const ROUND: f32 = 1.8;

/// Upper bound on the displacement of any point of the body in this step [m].
pub(super) fn max_moved(body: &Body, center: Vec3, rotation: Quat) -> f32 {
    let (q, p) = (body.rotation, rotation);
    let d = [q.x - p.x, q.y - p.y, q.z - p.z, q.w - p.w];
    let chord = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[3] * d[3]).sqrt();
    // The chord of two unit quaternions is 2 sin(angle/4), and asin(x) <= 1.05 x up to 1/2: beyond,
    // the room of any body is spent.
    (body.center - center).length() + 2.1 * chord * body.extent
}

/// Fits the boxes of a body's shapes to its pose, and computes how much room all of them have.
/// False if a shape has left its box.
#[inline(always)]
fn fit_all<S: Simd>(
    simd: S,
    body: &mut Body,
    flew: bool,
    ctx: &StepContext,
    shapes: &Rows<'_, Option<ShapeRow>>,
    escaped: &mut Vec<(u32, Aabb)>,
) -> bool {
    let (mut room, mut in_boxes) = (f32::INFINITY, true);
    let turn = Need::turn_of(body);
    for row in &body.ties.shapes {
        let Some(shape) = shapes.row(*row as usize).as_mut().filter(|s| s.enabled) else {
            continue;
        };
        let need = Need::of(simd, shape, (body, turn), ctx);
        let (tight, fits) = (need.tight, need.fits());
        in_boxes &= shape.fat.contains(&tight);
        // The shape may leave its box in this step or the next, or the box was valid for one step
        // only.
        if flew || !shape.fat.contains(&fits) {
            shape.fat = need.with_room(&fits, body, ctx);
            escaped.push((*row, shape.fat));
        }
        let (low, high) = (tight.min - shape.fat.min, shape.fat.max - tight.max);
        room = room.min(low.min(high).min_element());
    }
    body.room = room;
    in_boxes
}

/// Bodies moved before their boxes are fitted: enough to turn free bodies eight at a time.
const FLOCK: usize = 64;

/// Prefetch distance for shapes, in bodies.
const PREFETCH: usize = 4;

/// Prefetches the first two shapes of a body that flies or may have used up its room, and whose
/// shapes may need other boxes.
#[inline(always)]
fn prefetch_shapes(
    ctx: &StepContext,
    row: u32,
    bodies: &ReadRows<'_, Option<Body>>,
    shapes: &ReadRows<'_, Option<ShapeRow>>,
) {
    if let Some(body) = bodies.read(row as usize)
        && (body.flies || body.room <= 2.0 * reach_of_all(body, ctx))
    {
        for shape in body.ties.shapes.iter().take(2) {
            shapes.prefetch(*shape as usize, 2);
        }
    }
}

/// Moves bodies; returns the centers and rotations from before.
fn advance(
    ctx: &StepContext,
    flock: &[u32],
    bodies: &Rows<'_, Option<Body>>,
    solved: &Solved,
) -> [(Vec3, Quat); FLOCK] {
    let mut before = [(Vec3::ZERO, Quat::IDENTITY); FLOCK];
    let mut spins = Spins::default();
    for (row, before) in flock.iter().zip(&mut before) {
        let Some(body) = bodies.row(*row as usize) else { continue };
        *before = (body.center, body.rotation);
        if move_body(ctx, body, *row, solved) {
            spins.add(ctx, *row, body.inertia.moments, bodies);
        }
    }
    spins.finish(ctx, bodies);
    before
}

/// Moves a body; true if its free rotation remains to be computed.
fn move_body(ctx: &StepContext, body: &mut Body, row: u32, solved: &Solved) -> bool {
    let solver_row = solved.solver_row_of[row as usize] as usize;
    if body.kind == BodyKind::Kinematic {
        body.center += body.v * ctx.dt;
        body.rotation = body.rotation.turned_by(body.w * ctx.dt);
        return false;
    }
    if solver_row == 0 || solved.flew(solver_row) {
        return flight::fly(ctx, body);
    }
    let (before, squeeze) = (body.v, &solved.squeezes[solver_row]);
    let aux = (&solved.aux[solver_row], squeeze.factor);
    integrate::unwhiten(
        ctx,
        &solved.solver_bodies[solver_row],
        &solved.whitening[solver_row],
        aux,
        solved.end(solver_row),
        body,
    );
    if !body.record.is_link {
        integrate::note_load(ctx, squeeze, before, body);
    }
    false
}

/// Checks the new state of a body and updates its timers; false if its state became non-finite.
#[inline(always)]
fn arrive(
    body: &mut Body,
    row: u32,
    (center, rotation): (Vec3, Quat),
    notes: &mut Vec<Note>,
) -> bool {
    body.forces.step_force = Vec3::ZERO;
    body.forces.step_torque = Vec3::ZERO;
    // Beyond these limits no box, distance or product is meaningful in f32, so such values count as
    // infinite. All comparisons are false for NaN.
    let (far, fast) = (limits::POSITION_KEPT.maximum, limits::SPEED_KEPT.maximum);
    let is_kept = body.center.is_below(far) && body.v.is_below(fast) && body.w.is_below(fast);
    if !(is_kept && body.rotation.is_finite()) {
        (body.center, body.rotation) = (center, rotation);
        (body.v, body.w) = (Vec3::ZERO, Vec3::ZERO);
        notes.push(Note::Fault(row));
        return false;
    }
    if body.kind == BodyKind::Kinematic && body.v == Vec3::ZERO && body.w == Vec3::ZERO {
        notes.push(Note::Idle(row));
    }
    true
}

fn rate_stillness(
    ctx: &StepContext,
    rule: &StillnessRule,
    (by_energy, parting): (bool, f32),
    body: &mut Body,
    known: &mut Stillness,
) {
    if !body.is_dynamic() {
        return;
    }
    let by_speed = if by_energy {
        freeze::rests(ctx, rule.speed, body)
    } else {
        body.greatest_speed(rule.length) < body.still_speed(rule.speed)
    };
    let by_speed = by_speed && parting < body.still_speed(rule.speed);
    rule.count(rule.is_slow(body, by_speed), body, known);
}

#[cfg(test)]
mod tests {
    use crate::base::aabb::Aabb;
    use crate::base::math::{Vec3, vec3};
    use crate::state::def::config::WorldConfig;
    use crate::state::def::{BodyDef, ShapeDef};
    use crate::world::World;

    #[test]
    fn the_parts_of_a_long_body_that_turns_stay_in_their_boxes_for_two_steps() {
        let config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
        let mut world = World::new(config).unwrap();
        // 16 m long: the tips move 16 m/s or 0.27 m a step. In two steps they come 4 m/s · 8 m ·
        // (2/60 s)²/2 = 18 mm off the straight path that their boxes follow, and have 0.1 m room.
        let mut body = BodyDef::dynamic().with_angular_velocity(vec3(0.0, 0.0, 2.0));
        for i in 0..16_u8 {
            let at = vec3(0.0, f32::from(i) - 7.5, 0.0);
            body = body.with_shape(ShapeDef::cylinder(0.5, 0.25).with_position(at));
        }
        world.add_body(body).unwrap();
        let mut last: Vec<(Aabb, bool)> = Vec::new();
        let mut changes = 0;
        for _ in 0..120 {
            world.step(1.0 / 60.0);
            let tables = world.tables_mut();
            let (bodies, shapes) = (&tables.bodies, &tables.shapes);
            let now = shapes.rows.iter().map(|(_, shape)| {
                let tight: Aabb = shape.solid.aabb(&shape.placed(bodies.at(shape.body)));
                assert!(shape.fat.contains(&tight), "{shape:?}");
                shape.fat
            });
            let now: Vec<Aabb> = now.collect();
            if last.is_empty() {
                last = now.iter().map(|fat| (*fat, false)).collect();
                continue;
            }
            for ((before, changed), fat) in last.iter_mut().zip(now) {
                let changes_now = fat != *before;
                assert!(!(changes_now && *changed), "a new box in two steps on end: {fat:?}");
                changes += u32::from(changes_now);
                (*before, *changed) = (fat, changes_now);
            }
        }
        assert!(changes > 500, "{changes}");
    }
}
