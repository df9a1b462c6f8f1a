//! The stage `sweep`: stops fast bodies at the first impact on their path, so that they do not pass
//! through anything.
//!
//! Reads: shapes, bounds, joints, contacts. Writes: bodies (pose), bounds. Runs: in parallel over
//! fast bodies and pairs; results are applied in body order, then in order of time.
//! The stage has two parts. First, a ray from the old to the new center must not cross a static
//! shape, and a body that was clear of it must not end deep in it. Contacts made within a body's
//! size are left to the solver, so this part applies only to bodies that move farther than half
//! their inner size in a step. Second, bodies that move against each other are stopped at their
//! impact (docs/decisions/032-continuous-collision.md). Velocities stay, so the contact of the next
//! step receives the whole impact.

mod hooks;
mod meetings;
mod stops;
mod paths;

use self::hooks::HookCalls;
use self::paths::{Paths, pose_of, put};
use super::context::StepContext;
use super::finalize;
use super::hooks::Hooks;
use super::notes::Flight;
use super::one_way;
use crate::base::bit_set::BitSet;
use crate::base::grow::Slack;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::base::sparse::Sparse;
use crate::base::threads::jobs::{Jobs, Output, collect_ranges, grain};
use crate::geometry::boxes::Ray;
use crate::geometry::cast;
use crate::state::bodies::body::Body;
use crate::state::bodies::{Bodies, NONE};
use crate::state::bounds::Bounds;
use crate::state::contacts::{Contacts, Watch};
use crate::state::events::SensorEvent;
use crate::state::joints::Joints;
use crate::state::shapes::{ShapeRow, Shapes};

/// Distance by which a body's ray extends beyond its path, in body sizes. A body that approaches at
/// an angle flatter than 1 in 5 moves less than its size toward the surface in a step of five
/// sizes, and has contacts before it arrives.
const SIZES_AHEAD: f32 = 5.0;

/// Maximum number of pairs tested for nearness, for each ray that the test may save. Pairs are
/// contiguous in memory, while a ray traverses the trees of shapes and of a mesh.
const REQUESTED: usize = 32;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    fast: Vec<Flight>,
    /// Index in `fast` of each body.
    flight_of: Sparse,
    /// Bodies that may have reached a static body of one of their pairs.
    near: BitSet,
    met: Vec<Met>,
    /// Row, and the new center.
    stopped: Vec<Vec<(u32, Vec3)>>,
    meetings: meetings::Scratch,
    stops: stops::Scratch,
    slack: Slack,
}

impl Scratch {
    /// Sensors that a shape entered and left within the last step.
    pub(crate) fn crossed(&self) -> &[SensorEvent] {
        self.stops.crossed()
    }
}

/// Result for some watched pairs: bodies that may have reached a static one, and contacts of fast
/// bodies that may have met.
#[derive(Clone, Debug, Default)]
struct Met {
    near: Vec<u32>,
    contacts: Vec<u32>,
}

impl Output for Met {
    fn clear(&mut self) {
        self.near.clear();
        self.contacts.clear();
    }
}

/// Stops fast bodies at the first shape on their path.
pub(crate) fn stop_fast_bodies(
    ctx: &StepContext,
    (moved, contacts, joints, hooks): (&finalize::Scratch, &Contacts, &Joints, Option<&Hooks<'_>>),
    bodies: &mut Bodies,
    shapes: &mut Shapes,
    bounds: &mut Bounds,
    scratch: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    let Scratch { fast, flight_of, near, met, stopped, meetings, stops, slack } = scratch;
    fast.clear();
    stops.clear();
    moved.flights().for_each(|some| fast.extend_from_slice(some));
    if let Some(enough) = slack.look(fast.len()) {
        fast.shrink_to(enough);
    }
    if fast.is_empty() {
        return;
    }
    let watches = contacts.awake_watches();
    let hook_calls = watches.len() <= REQUESTED * fast.len();
    flight_of.cover(bodies.rows.slot_count());
    for (number, flight) in (0..).zip(&*fast) {
        flight_of.set(flight.row, number);
    }
    if hook_calls {
        find_met(bodies, watches, flight_of, met, jobs);
        met.iter().flat_map(|met| &met.near).for_each(|body| near.insert(*body));
    } else {
        met.iter_mut().for_each(Output::clear);
    }
    let hooked = hooks.map(|hooks| HookCalls { ctx, hooks, bodies, shapes });
    let around = Around { bodies, shapes, bounds, hook_calls: hooked };
    collect_ranges(jobs, fast.len(), grain(jobs, fast.len(), 8), stopped, |range, out| {
        for Flight { row, from, stood, in_boxes, .. } in &fast[range] {
            // Pairs exist with everything that it may have met, and all of them are still apart.
            if hook_calls && *in_boxes && !near.contains(*row) {
                continue;
            }
            let body = around.bodies.at(*row);
            let delta = body.center - *from;
            if !body.is_dynamic() || delta.length() <= 0.5 * body.inner {
                continue;
            }
            if let Some(stop) = first_stop(body, *row, (*from, *stood), delta, &around) {
                out.push((*row, *from + delta * stop.max(0.0)));
            }
        }
    });
    if hook_calls {
        met.iter().for_each(|met| near.remove_all(&met.near));
    }
    for (row, center) in stopped.iter().flatten() {
        let rotation = bodies.at(*row).rotation;
        put(ctx, *row, Pose { position: *center, rotation }, bodies, shapes, bounds);
    }
    let paths = Paths { ctx, fast, flight_of, bodies };
    let around = meetings::Around { paths, shapes, bounds, contacts, joints };
    let rows = met.iter().flat_map(|met| &met.contacts).copied();
    meetings::find(&around, (fast, hook_calls), rows, meetings, jobs);
    let found = meetings.found();
    if !found.is_empty() {
        let flights = (fast.as_slice(), &*flight_of);
        stops::stop(ctx, flights, found, (contacts, hooks), (bodies, shapes, bounds), stops, jobs);
    }
    for flight in fast {
        flight_of.set(flight.row, NONE);
    }
}

/// Finds bodies that may have reached a static one, and contacts of fast bodies that may have met.
fn find_met(
    bodies: &Bodies,
    watches: &[Watch],
    flight_of: &Sparse,
    met: &mut Vec<Met>,
    jobs: &Jobs<'_>,
) {
    let tracks = &bodies.tracks;
    collect_ranges(jobs, watches.len(), grain(jobs, watches.len(), 1024), met, |range, out| {
        for watch in &watches[range] {
            if !watch.may_have_met(tracks) {
                continue;
            }
            let pair = [watch.body_a, watch.body_b];
            if watch.has_static(tracks) {
                out.near.extend(pair);
            }
            if pair.into_iter().any(|body| flight_of.get(body) != NONE) {
                out.contacts.push(watch.row());
            }
        }
    });
}

/// Tables that the rays need.
struct Around<'a> {
    bodies: &'a Bodies,
    shapes: &'a Shapes,
    bounds: &'a Bounds,
    hook_calls: Option<HookCalls<'a>>,
}

/// A swept object: a body, or a part of one.
struct Swept<'a> {
    body: &'a Body,
    shapes: &'a [u32],
    /// Center of its bounds [m, frame of the center of mass].
    middle: Vec3,
    /// Maximum distance from the middle to its surface [m].
    extent: f32,
}

/// Part of its path after which the body stops at a static shape. A body with its center of mass
/// outside of itself, such as a ring, is swept shape by shape. The ray of its center is
/// meaningless, and a ring would hang on the top of the peg that goes through it.
fn first_stop(
    body: &Body,
    row: u32,
    (from, stood): (Vec3, Quat),
    delta: Vec3,
    around: &Around<'_>,
) -> Option<f32> {
    if !body.inertia.hollow || body.ties.shapes.len() < 2 {
        let whole =
            Swept { body, shapes: &body.ties.shapes, middle: Vec3::ZERO, extent: body.extent };
        return first_stop_of(&whole, row, (from, stood), delta, around);
    }
    let mut first: Option<f32> = None;
    for shape in &body.ties.shapes {
        let s = around.shapes.at(*shape);
        let (middle, extent) = s.solid.ball();
        let middle = s.centered.point(middle);
        let begin = from + stood.rotate(middle);
        let displacement = body.center + body.rotation.rotate(middle) - begin;
        let part = Swept { body, shapes: core::slice::from_ref(shape), middle, extent };
        let stop = first_stop_of(&part, row, (begin, stood), displacement, around);
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
    let Around { bodies, shapes, bounds, hook_calls } = around;
    let meets = |s: u32, other: &ShapeRow| {
        let s = shapes.at(s);
        s.is_solid() && s.filter.collides_with(other.filter)
    };
    // A stopped body has the rotation of the end of the step.
    let is_held = |item: u32, shape: &ShapeRow, stop: f32| {
        let Some(hook_calls) = hook_calls else { return true };
        let own =
            Pose { position: swept.body.center - delta * (1.0 - stop), ..pose_of(swept.body) };
        let fixed = pose_of(bodies.at(shape.body));
        let mut met = swept.shapes.iter().filter(|s| meets(**s, shape));
        met.any(|s| !hook_calls.are_of(*s, item) || hook_calls.stop([*s, item], [own, fixed]))
    };
    let stops_at = |row: u32, shape: &ShapeRow, normal: Vec3| {
        one_way::stops(shapes, row, bodies.at(shape.body), normal, delta)
    };
    let ahead = SIZES_AHEAD * swept.extent / delta.length();
    let mut first = None;
    bounds.fixed.ray(&Ray::new(from, delta), 1.0 + ahead, |item| {
        // A shape farther behind the first stop than this stops the body no earlier.
        let limit = first.unwrap_or(1.0) + ahead;
        let shape = shapes.at(item);
        let passes = shape.body == row || shape.sensor || bodies.are_strangers(row, shape.body);
        if passes || !swept.shapes.iter().any(|s| meets(*s, shape)) {
            return limit;
        }
        let pose = bodies.at(shape.body).pose().compose(&shape.local);
        let (o, d) = (pose.local_point(from), pose.local_direction(delta));
        if let Some(hit) = cast::ray(&shape.solid, o, d, limit)
            && stops_at(item, shape, pose.direction(hit.normal))
            && let Some(stop) =
                stop_at(swept, stood, delta, (hit.fraction, pose.direction(hit.normal)), shapes)
            && is_held(item, shape, stop)
        {
            first = Some(first.unwrap_or(1.0_f32).min(stop.max(hit.fraction - ahead)));
        }
        first.unwrap_or(1.0) + ahead
    });
    first
}

/// Part of the path at which a body stops whose middle's ray meets a surface: with the two surfaces
/// about touching, so that the next step's contacts do the rest. Another body could push a body
/// that was stopped deeper until its center is inside a thin wall. A leg of it that came through
/// would then be pushed out on the other side.
fn stop_at(
    swept: &Swept<'_>,
    stood: Quat,
    delta: Vec3,
    (fraction, normal): (f32, Vec3),
    shapes: &Shapes,
) -> Option<f32> {
    let closing = -normal.dot(delta);
    if fraction > 1.0 && (fraction - 1.0) * closing > swept.extent - swept.body.inner {
        // It ends farther from the surface than it can reach.
        return None;
    }
    let far = fraction * closing;
    let is_clear =
        || far >= swept.extent || far >= reach_against(swept, stood, (normal, far), shapes);
    if closing > 0.0 && is_clear() {
        // It was clear of the surface when the step began.
        let direction = (normal, f32::INFINITY);
        let reach = reach_against(swept, swept.body.rotation, direction, shapes);
        let height = (fraction - 1.0) * closing;
        // Contacts resolve a smaller depth, with the energy that the body has at the surface;
        // moving the body back would lift it.
        let deep = height < reach - swept.body.inner;
        return deep.then(|| fraction - (reach - 0.05 * swept.body.inner) / closing);
    }
    // It was near, and had contacts: those hold it, unless its center is to pass.
    (fraction <= 1.0).then(|| fraction - 0.95 * swept.body.inner / delta.length())
}

/// Extent of a swept object from its middle, against a direction [m]. Stops early above `enough`: a
/// greater value then need not be exact.
fn reach_against(
    swept: &Swept<'_>,
    rotation: Quat,
    (normal, enough): (Vec3, f32),
    shapes: &Shapes,
) -> f32 {
    let seen = rotation.unrotate(normal);
    let rotation = Quat::from_arc(normal, Vec3::X) * rotation;
    let turned = Pose { position: Vec3::ZERO, rotation };
    let middle = turned.direction(swept.middle).x;
    let mut reach = 0.0_f32;
    for row in swept.shapes {
        let shape = shapes.at(*row);
        // In a body with many shapes, one shape determines the reach.
        let (center, radius) = shape.solid.ball();
        let ball = middle + 1.001 * radius - seen.dot(shape.centered.point(center));
        if shape.is_solid() && ball > reach {
            let low = shape.solid.min_x(&turned.compose(&shape.centered));
            reach = reach.max(middle - low);
            if reach > enough {
                break;
            }
        }
    }
    reach.min(swept.extent)
}

#[cfg(test)]
mod tests {
    use super::{Around, first_stop};
    use crate::base::aabb::Aabb;
    use crate::base::math::{Vec3, vec3};
    use crate::base::quat::Quat;
    use crate::base::random::Random;
    use crate::state::bodies::body::Body;
    use crate::state::def::{BodyDef, ShapeDef};
    use crate::world::World;

    /// Bodies with one shape and with two, shot about in a room of thin walls with a step and a
    /// pillar, and others that fall into it.
    fn room(random: &mut Random) -> World {
        let mut world = World::default();
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for side in [-8.0, 8.0] {
                let half = Vec3::splat(8.0) - axis * 7.9;
                let wall = ShapeDef::box_half(half).with_restitution(0.9);
                let wall = BodyDef::fixed().with_position(axis * side).with_shape(wall);
                world.add_body(wall).unwrap();
            }
        }
        let step = ShapeDef::box_half(vec3(2.0, 1.0, 8.0)).with_position(vec3(-6.0, -7.0, 0.0));
        let pillar = ShapeDef::box_half(vec3(0.3, 8.0, 0.3));
        world.add_body(BodyDef::fixed().with_shape(step).with_shape(pillar)).unwrap();
        #[expect(clippy::cast_possible_truncation, reason = "any number will do")]
        let mut side = |maximum: f32| (random.unit() as f32 - 0.5) * 2.0 * maximum;
        for i in 0..60_u8 {
            let turn = vec3(side(3.0), side(3.0), side(3.0));
            let box_of = |half: Vec3| ShapeDef::box_half(half).with_restitution(0.9);
            let mut body = BodyDef::dynamic()
                .with_position(vec3(side(7.0), side(7.0), side(7.0)))
                .with_rotation(Quat::from_rotation_vector(turn))
                .with_linear_velocity(vec3(side(25.0), side(25.0), side(25.0)))
                .with_angular_velocity(turn * 2.0)
                .with_shape(box_of(vec3(0.2, 0.3, 0.4)));
            if i % 3 == 0 {
                let end = box_of(vec3(0.1, 0.1, 0.5)).with_position(vec3(0.0, 0.3, 0.4));
                body = body.with_shape(end);
            }
            world.add_body(body).unwrap();
        }
        world
    }

    #[test]
    fn a_ray_that_is_saved_would_have_stopped_nothing() {
        let mut random = Random::new(17);
        let (mut saved, mut cast) = (0, 0);
        for _ in 0..4 {
            let mut world = room(&mut random);
            for _ in 0..120 {
                let mut then = world.clone();
                world.step(1.0 / 60.0);
                let (then, now) = (then.tables_mut(), world.tables_mut());
                let (bodies, shapes, bounds) = (&now.bodies, &now.shapes, &now.bounds);
                let around = Around { bodies, shapes, bounds, hook_calls: None };
                for (id, body) in bodies.rows.iter().filter(|(_, body)| body.is_dynamic()) {
                    let row = id.index();
                    let before: &Body = then.bodies.at(row);
                    let delta = body.center - before.center;
                    if delta.length() <= 0.5 * body.inner {
                        continue;
                    }
                    let in_boxes = body.ties.shapes.iter().all(|shape| {
                        let solid = &shapes.at(*shape).solid;
                        let tight: Aabb = solid.aabb(&shapes.at(*shape).placed(body));
                        then.shapes.at(*shape).fat.contains(&tight)
                    });
                    let mut watches = now.contacts.awake_watches().iter();
                    let near = watches.any(|watch| {
                        [watch.body_a, watch.body_b].contains(&row)
                            && watch.has_static(&bodies.tracks)
                            && watch.may_have_met(&bodies.tracks)
                    });
                    let stop =
                        first_stop(body, row, (before.center, before.rotation), delta, &around);
                    if in_boxes && !near {
                        assert_eq!(stop, None);
                        saved += 1;
                    } else {
                        cast += 1;
                    }
                }
            }
        }
        assert!(saved > 3000 && cast > 1000, "{saved} {cast}");
    }
}
