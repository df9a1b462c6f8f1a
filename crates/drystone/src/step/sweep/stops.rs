//! Impacts of fast bodies with moving ones: stops them in the order of time, and records sensors
//! that were crossed.
//!
//! Two bodies that end deep in each other, or past each other, are put where they met, and continue
//! together from there for the rest of the step. Velocities stay: the next step has a contact with
//! the normal, the place and the speed of the impact. A body that was not fast, or cannot be
//! pushed, ends where it is, with the other in front of it. Two fast bodies both continue with the
//! motion of their common center of mass.

use super::hooks::HookCalls;
use super::meetings::Meeting;
use super::paths::{Paths, pose_of, put};
use crate::base::bit_set::BitSet;
use crate::base::pose::Pose;
use crate::base::sparse::Sparse;
use crate::base::threads::jobs::{Jobs, collect_ranges, grain};
use crate::geometry::solid::{Core, Solid};
use crate::geometry::toi::{Course, Mover, Pair};
use crate::state::bodies::Bodies;
use crate::state::bodies::body::Body;
use crate::state::bounds::Bounds;
use crate::state::contacts::Contacts;
use crate::state::events::SensorEvent;
use crate::state::shapes::{ShapeRow, Shapes};
use crate::step::broadphase::rank;
use crate::step::context::StepContext;
use crate::step::hooks::Hooks;
use crate::step::narrowphase::overlap;
use crate::step::notes::Flight;
use crate::step::one_way;
use crate::step::touches::events_between;

/// Maximum number of rounds: a stopped body may meet others at its new place.
const MAX_ROUNDS: usize = 8;

/// Size of the part of a body that must not pass, as a fraction of its inner size.
const CORE: f32 = 0.5;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Candidates of a round, and the resulting stops.
    asked: Vec<Meeting>,
    lists: Vec<Vec<Stop>>,
    stops: Vec<Stop>,
    /// Bodies that were moved in a round.
    moved: Vec<u32>,
    is_moved: BitSet,
    crossings: Vec<Vec<Meeting>>,
    crossed: Vec<SensorEvent>,
}

impl Scratch {
    pub(super) fn clear(&mut self) {
        self.crossed.clear();
    }

    pub(super) fn crossed(&self) -> &[SensorEvent] {
        &self.crossed
    }
}

/// Two shapes meet after this part of the step.
#[derive(Clone, Copy, Debug)]
struct Stop {
    part: f32,
    meeting: Meeting,
}

/// Stops bodies that meet, and lists sensors that were crossed.
pub(super) fn stop(
    ctx: &StepContext,
    (fast, flight_of): (&[Flight], &Sparse),
    meetings: &[Meeting],
    (contacts, hooks): (&Contacts, Option<&Hooks<'_>>),
    (bodies, shapes, bounds): (&mut Bodies, &mut Shapes, &mut Bounds),
    scratch: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    let Scratch { asked, lists, stops, moved, is_moved, crossings, crossed } = scratch;
    asked.clear();
    asked.extend(meetings.iter().filter(|meeting| !is_of_sensor(**meeting, shapes)));
    for _ in 0..MAX_ROUNDS {
        let hook_calls = hooks.map(|hooks| HookCalls { ctx, hooks, bodies, shapes });
        let steps = Steps { paths: Paths { ctx, fast, flight_of, bodies }, shapes, hook_calls };
        collect_ranges(jobs, asked.len(), grain(jobs, asked.len(), 8), lists, |range, out| {
            let some = asked[range].iter();
            out.extend(some.filter_map(|m| steps.meet(*m).map(|part| Stop { part, meeting: *m })));
        });
        stops.clear();
        stops.extend(lists.iter().flatten());
        if stops.is_empty() {
            break;
        }
        stops.sort_unstable_by(|s, t| s.part.total_cmp(&t.part).then(s.meeting.cmp(&t.meeting)));
        for stop in &*stops {
            let [a, b] = bodies_of(stop.meeting, shapes);
            // Pairs of moved bodies are tested again in the next round.
            if is_moved.contains(a) || is_moved.contains(b) {
                continue;
            }
            let paths = Paths { ctx, fast, flight_of, bodies };
            let ends = Steps { paths, shapes, hook_calls: None }.ends(*stop);
            for (row, pose) in ends.into_iter().flatten() {
                put(ctx, row, pose, bodies, shapes, bounds);
                is_moved.insert(row);
                moved.push(row);
            }
        }
        asked.clear();
        asked.extend(meetings.iter().filter(|meeting| {
            !is_of_sensor(**meeting, shapes)
                && bodies_of(**meeting, shapes).into_iter().any(|body| is_moved.contains(body))
        }));
        is_moved.remove_all(moved);
        moved.clear();
    }
    let steps = Steps { paths: Paths { ctx, fast, flight_of, bodies }, shapes, hook_calls: None };
    asked.clear();
    asked.extend(meetings.iter().filter(|meeting| is_of_sensor(**meeting, shapes)));
    collect_ranges(jobs, asked.len(), grain(jobs, asked.len(), 8), crossings, |range, out| {
        out.extend(asked[range].iter().filter(|meeting| steps.crosses(**meeting, contacts)));
    });
    crossed.extend(
        crossings
            .iter()
            .flatten()
            .flat_map(|(a, b)| events_between([*a, *b], shapes, steps.paths.bodies)),
    );
}

fn is_of_sensor((a, b): Meeting, shapes: &Shapes) -> bool {
    shapes.at(a).sensor || shapes.at(b).sensor
}

fn bodies_of((a, b): Meeting, shapes: &Shapes) -> [u32; 2] {
    [shapes.at(a).body, shapes.at(b).body]
}

/// Motion of shapes in the step, with the changes so far.
struct Steps<'a> {
    paths: Paths<'a>,
    shapes: &'a Shapes,
    hook_calls: Option<HookCalls<'a>>,
}

impl Steps<'_> {
    fn pair(&self, meeting @ (a, b): Meeting) -> Pair<'_> {
        let yields =
            bodies_of(meeting, self.shapes).map(|row| self.paths.bodies.at(row).is_dynamic());
        let [a, b] = [a, b].map(|shape| {
            let ShapeRow { solid, centered, body, .. } = self.shapes.at(shape);
            Mover::new(solid, *centered, self.paths.path(*body))
        });
        Pair::new(a, b).yielding(yields == [true, true])
    }

    /// Part of the step after which two shapes meet that end deep in each other or past each other.
    fn meet(&self, meeting: Meeting) -> Option<f32> {
        let pair = self.pair(meeting);
        let [a, b] = bodies_of(meeting, self.shapes).map(|row| self.paths.bodies.at(row));
        let core = |body: &Body| if body.is_dynamic() { CORE * body.inner } else { f32::INFINITY };
        if pair.hardly_moves(core(a).min(core(b))) || !pair.may_meet() {
            return None;
        }
        let is_one_way = self.is_one_way(meeting);
        if is_one_way && !self.comes_to_front(meeting) {
            return None;
        }
        let part = match pair.course() {
            Course::Clear => None,
            Course::Deep(part) => Some(part),
            // A body that passes a one-way surface is let out; one that is held has contacts.
            Course::Overlap if is_one_way => None,
            Course::Overlap => self.meet_inside(meeting),
        };
        part.filter(|part| self.is_held(meeting, *part))
    }

    /// False if hooks let two shapes pass each other that meet after a part of the step.
    fn is_held(&self, meeting @ (a, b): Meeting, part: f32) -> bool {
        let hook_calls = self.hook_calls.as_ref().filter(|hook_calls| hook_calls.are_of(a, b));
        hook_calls.is_none_or(|hook_calls| {
            let poses = bodies_of(meeting, self.shapes).map(|row| self.paths.path(row).at(part));
            hook_calls.stop([a, b], poses)
        })
    }

    fn is_one_way(&self, (a, b): Meeting) -> bool {
        [a, b].into_iter().any(|shape| self.shapes.at(shape).reports.is_one_way())
    }

    /// True if two shapes approach so that a one-way surface of them may hold.
    fn comes_to_front(&self, (a, b): Meeting) -> bool {
        let rows = bodies_of((a, b), self.shapes);
        let bodies = rows.map(|row| self.paths.bodies.at(row));
        let [from, to] = rows.map(|row| self.paths.path(row).shift());
        one_way::may_stop(self.shapes, [a, b], bodies, to - from)
    }

    /// Time of impact for two shapes that overlap from the start, as a part of the step. Their
    /// contacts hold them, unless the middle of the smaller one is to pass.
    fn meet_inside(&self, (a, b): Meeting) -> Option<f32> {
        let [body_a, body_b] = [a, b].map(|shape| self.paths.bodies.at(self.shapes.at(shape).body));
        let a_is_smaller =
            !body_b.is_dynamic() || (body_a.is_dynamic() && body_a.extent <= body_b.extent);
        let (small, other) = if a_is_smaller { (a, b) } else { (b, a) };
        let (small, other) = (self.shapes.at(small), self.shapes.at(other));
        let body = self.paths.bodies.at(small.body);
        if body.inertia.hollow {
            return None;
        }
        let core = Solid { core: Core::Point, radius: CORE * body.inner };
        let core = Mover::new(&core, Pose::IDENTITY, self.paths.path(small.body));
        let other = Mover::new(&other.solid, other.centered, self.paths.path(other.body));
        match Pair::new(core, other).course() {
            Course::Deep(part) => Some(part),
            Course::Clear | Course::Overlap => None,
        }
    }

    /// Final poses of two bodies that meet.
    fn ends(&self, Stop { part, meeting }: Stop) -> [Option<(u32, Pose)>; 2] {
        let rows = bodies_of(meeting, self.shapes);
        let bodies = rows.map(|row| self.paths.bodies.at(row));
        let gives = [0, 1].map(|i| bodies[i].is_dynamic() && self.paths.flight(rows[i]).is_some());
        // Moving a body with a joint would tear the joint open.
        let free = [0, 1].map(|i| gives[i] && bodies[i].ties.joints.is_empty());
        let alone = match (gives, free) {
            ([true, false], _) | ([true, true], [true, false]) => Some(0),
            ([false, true], _) | ([true, true], [false, true]) => Some(1),
            ([false, false], _) => Some(usize::from(!bodies[0].is_dynamic())),
            _ => None,
        };
        let masses = bodies.map(|body| body.inertia.mass);
        let light = alone.unwrap_or(usize::from(masses[1] <= masses[0]));
        let heavy = 1 - light;
        let paths = rows.map(|row| self.paths.path(row));
        let mut end = pose_of(bodies[heavy]);
        if alone.is_none() {
            let [a, b] = [0, 1].map(|i| paths[i].shift() * (masses[i] / (masses[0] + masses[1])));
            end.position = paths[heavy].at(part).position + (a + b) * (1.0 - part);
        }
        // The surface carries the other body with it; rotation of a round surface does not.
        let surface = [meeting.0, meeting.1][heavy];
        let ShapeRow { solid, centered, .. } = self.shapes.at(surface);
        let seen = *Mover::new(solid, *centered, paths[heavy]).motion();
        let turn = seen.at(1.0).rotation * seen.at(part).rotation.conjugate();
        let met = paths.map(|path| path.at(part));
        let arm = turn.rotate(met[light].position - met[heavy].position);
        let with = Pose {
            position: end.position + arm,
            rotation: (turn * met[light].rotation).normalized(),
        };
        let stays = alone.is_some();
        [Some((rows[light], with)), (!stays).then_some((rows[heavy], end))]
    }

    /// True if two shapes, of which one is a sensor, met within the step, and are apart again.
    fn crosses(&self, meeting: Meeting, contacts: &Contacts) -> bool {
        let pair = self.pair(meeting);
        pair.may_meet()
            && !self.touches(meeting, contacts)
            && pair.enters()
            && !self.overlap(meeting)
    }

    /// True if they overlap now: the next step will find that.
    fn overlap(&self, (a, b): Meeting) -> bool {
        let [first, second] = [a, b].map(|shape| self.shapes.at(shape));
        let swap = rank(second) < rank(first);
        let (first, second) = if swap { (second, first) } else { (first, second) };
        let [x, y] = [first, second].map(|shape| (self.paths.bodies.at(shape.body), shape));
        overlap(self.paths.ctx, x, y)
    }

    /// True if they touched when the step began: the next step reports their separation.
    fn touches(&self, (a, b): Meeting, contacts: &Contacts) -> bool {
        let body = self.paths.bodies.at(self.shapes.at(a).body);
        contacts
            .of_body(body)
            .map(|(row, _)| contacts.at(row))
            .any(|c| (c.shape_a.min(c.shape_b), c.shape_a.max(c.shape_b)) == (a, b) && c.touching)
    }
}
