//! Events: every landing and every crossing of a sensor must be reported.

use std::collections::{BTreeMap, BTreeSet};

use drystone::{BodyId, Pose, ShapeId, Vec3};

use super::measures::{measures, meets_box};
use super::moment::{Body, Look};
use crate::finding::{Findings, Kind};
use crate::oracle::Pairs;

/// Number of steps within which a landing must be reported: braking a body may take two steps.
const NEAR: u32 = 3;

/// Factor on the speed above which hits are reported; slower landings may go unreported.
const OVER: f32 = 1.5;

/// A landing without an event so far.
#[derive(Clone, Copy, Debug)]
struct Landing {
    bodies: [BodyId; 2],
    speed: f32,
    step: u32,
}

/// Events of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Told {
    pairs: Pairs,
    hits: BTreeMap<[BodyId; 2], u32>,
    landings: Vec<Landing>,
    entered: BTreeSet<(ShapeId, ShapeId)>,
    inside: BTreeSet<(ShapeId, ShapeId)>,
    crossed: BTreeMap<(ShapeId, ShapeId), u32>,
}

impl Told {
    pub(super) fn see(&mut self, look: &Look<'_>, findings: &mut Findings) {
        self.pairs.follow(look.world, findings, look.step);
        let events = look.world.events();
        for hit in &events.hits {
            self.hits.insert(sorted(hit.body_a, hit.body_b), look.step);
        }
        self.find_landings(look);
        self.miss_landings(look, findings);
        for e in &events.sensor_enter {
            self.entered.insert((e.sensor, e.visitor));
            self.inside.insert((e.sensor, e.visitor));
        }
        for e in &events.sensor_exit {
            self.inside.remove(&(e.sensor, e.visitor));
        }
        self.cross_sensors(look, findings);
    }

    /// Finds pairs of bodies that touch only each other, approached, and stopped approaching.
    fn find_landings(&mut self, look: &Look<'_>) {
        let speed = OVER * look.world.config().contact.hit_speed;
        let mut partners: BTreeMap<BodyId, BTreeSet<BodyId>> = BTreeMap::new();
        for touch in &look.now.touches {
            let [a, b] = touch.bodies;
            partners.entry(a).or_default().insert(b);
            partners.entry(b).or_default().insert(a);
        }
        for touch in &look.now.touches {
            let [a, b] = touch.bodies;
            let alone = |id: BodyId, body: &Body| {
                let is_only = partners.get(&id).is_some_and(|p| p.len() == 1);
                !body.is_dynamic() || (is_only && !look.facts.jointed.contains(&body.label))
            };
            let pair = |moment: &super::moment::Moment| {
                Some((*moment.bodies.get(&a)?, *moment.bodies.get(&b)?))
            };
            let (Some(now), Some(before)) = (pair(look.now), pair(look.before)) else { continue };
            if !alone(a, &now.0) || !alone(b, &now.1) {
                continue;
            }
            // The whole touch counts, because a single corner of a rotating body approaches and
            // recedes anyway.
            let close = |(a, b): (Body, Body)| {
                let of = |p: &super::moment::Point| {
                    (a.velocity_at(p.at) - b.velocity_at(p.at)).dot(touch.normal)
                };
                touch.points.iter().map(of).fold(f32::INFINITY, f32::min)
            };
            let (was, is) = (close(before), close(now));
            let is_slow_turn = (before.0.w - before.1.w).length() * look.dt < 0.1;
            if was > speed && is < 0.1 * was && is_slow_turn && was.is_finite() {
                let bodies = sorted(a, b);
                let is_new = !self.landings.iter().any(|l| l.bodies == bodies);
                if is_new {
                    self.landings.push(Landing { bodies, speed: was, step: look.step });
                }
            }
        }
    }

    fn miss_landings(&mut self, look: &Look<'_>, findings: &mut Findings) {
        let hits = &self.hits;
        self.landings.retain(|landing| {
            let told = hits.get(&landing.bodies).is_some_and(|at| at + NEAR >= landing.step);
            let is_late = look.step > landing.step + NEAR;
            if !told && is_late {
                let detail = format!("came at {} m/s", landing.speed);
                findings.add(Kind::Missed, "a landing without a hit", detail, landing.step);
            }
            !told && !is_late
        });
    }

    /// A body whose middle crosses a sensor within a step must have entered it.
    fn cross_sensors(&mut self, look: &Look<'_>, findings: &mut Findings) {
        for holder in look.world.bodies() {
            for sensor in holder.shapes() {
                let Some(shape) = look.world.shape(sensor).filter(drystone::ShapeRef::is_sensor)
                else {
                    continue;
                };
                let Some(m) = measures(shape.shape()) else { continue };
                let Some(base) = look.before.bodies.get(&holder.id()) else { continue };
                let local = shape.local_pose();
                let (from, to) = (base.pose.compose(&local), holder.pose().compose(&local));
                self.cross(look, (sensor, holder.id()), [from, to], m.core);
            }
        }
        let step = look.step;
        let entered = &self.entered;
        self.crossed.retain(|pair, at| {
            if entered.contains(pair) {
                return false;
            }
            let is_late = step > *at + NEAR;
            if is_late {
                findings.add(Kind::Missed, "a sensor passed without entering", "", *at);
            }
            !is_late
        });
    }

    fn cross(
        &mut self,
        look: &Look<'_>,
        (sensor, holder): (ShapeId, BodyId),
        [from, to]: [Pose; 2],
        half: Vec3,
    ) {
        for (id, body) in look.now.dynamic() {
            let (Some(then), true) = (look.before.bodies.get(&id), id != holder) else { continue };
            let visitors =
                look.world.body(id).into_iter().flat_map(|b| b.shapes().collect::<Vec<_>>());
            for visitor in visitors {
                let Some(shape) = look.world.shape(visitor) else { continue };
                let Some(m) = measures(shape.shape()) else { continue };
                let middle = shape.local_pose().point(m.middle);
                let a = from.local_point(then.pose.point(middle));
                let b = to.local_point(body.pose.point(middle));
                if meets_box(a, b, half * 0.9) {
                    self.crossed.entry((sensor, visitor)).or_insert(look.step);
                }
            }
        }
    }

    /// Bodies inside a sensor at the end must be near it.
    pub(super) fn end(&self, look: &Look<'_>, findings: &mut Findings) {
        for (sensor, visitor) in &self.inside {
            let (Some(a), Some(b)) = (look.world.shape(*sensor), look.world.shape(*visitor)) else {
                continue;
            };
            if !a.bounds().overlaps(&b.bounds()) {
                findings.add(Kind::Missed, "a sensor left without an exit", "", look.step);
            }
        }
    }
}

fn sorted(a: BodyId, b: BodyId) -> [BodyId; 2] {
    [a.min(b), a.max(b)]
}
