//! Rest: a body at rest is in equilibrium, and bodies that must come to rest do.

use std::collections::BTreeMap;

use drystone::{BodyId, Vec3};

use super::moment::{Body, Look, Moment, turn_between};
use crate::finding::{Findings, Kind};

/// Allowed distance of a center of mass outside its support, as a fraction of the body's length:
/// the accuracy of contact points.
const BESIDE: f32 = 5.0e-3;

/// Time without motion after which a body counts as resting, awake or not [s].
const STILL_TIME: f32 = 2.0;

/// Allowed speed of a body that must rest, relative to a fall by its own length. Also its allowed
/// creep in the last third of the time, as a fraction of its length.
const CREEP_SPEED: f32 = 0.01;
const CREEP: f32 = 0.02;

/// Rest over a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Rest {
    still: BTreeMap<BodyId, Still>,
    /// State of all bodies after two thirds of the quiet time.
    mark: Option<(f32, Moment)>,
    fastest: BTreeMap<BodyId, f32>,
    /// Time since which everything is at rest [s].
    pub(super) rest_since: Option<f32>,
}

/// Time that a body has been in place.
#[derive(Clone, Copy, Debug)]
struct Still {
    at: Vec3,
    time: f32,
}

impl Rest {
    pub(super) fn see(&mut self, look: &Look<'_>) {
        for (id, body) in look.now.dynamic() {
            let still = self.still.entry(id).or_insert(Still { at: body.center, time: 0.0 });
            still.time += look.dt;
            if (still.at - body.center).length() > 1.0e-4 * body.large {
                *still = Still { at: body.center, time: 0.0 };
            }
        }
        let is_slow = |b: &Body| b.is_asleep || b.speed() < CREEP_SPEED * look.fall_speed(b);
        let all_slow = look.now.dynamic().all(|(_, b)| is_slow(b));
        self.rest_since = if all_slow { self.rest_since.or(Some(look.time)) } else { None };
    }

    /// Checks the balance rarely, because it is slow, and a body asleep off balance stays so.
    pub(super) fn judge(&self, look: &Look<'_>, findings: &mut Findings) {
        if look.step.is_multiple_of(30) {
            self.balance(look, findings);
        }
    }

    /// Whether a body is asleep, or has not moved for a time in which its weight could have moved
    /// it.
    fn rests(&self, look: &Look<'_>, id: BodyId, body: &Body) -> bool {
        let falls = 0.5 * look.facts.gravity * STILL_TIME * STILL_TIME > 0.05 * body.large;
        let still = self.still.get(&id).is_some_and(|s| s.time > STILL_TIME);
        body.is_asleep || (still && falls)
    }

    /// Checks groups of touching or joined bodies at rest: their center of mass must be over their
    /// support.
    fn balance(&self, look: &Look<'_>, findings: &mut Findings) {
        if look.facts.gravity <= 0.0 {
            return;
        }
        for group in groups(look) {
            let bodies: Vec<(BodyId, &Body)> =
                group.iter().filter_map(|id| Some((*id, look.now.bodies.get(id)?))).collect();
            if bodies.is_empty() || !bodies.iter().all(|(id, body)| self.rests(look, *id, body)) {
                continue;
            }
            if bodies.iter().any(|(_, body)| is_held(look, body)) {
                continue;
            }
            let mass: f32 = bodies.iter().map(|(_, b)| b.mass).sum();
            let center =
                bodies.iter().fold(Vec3::ZERO, |sum, (_, b)| sum + b.center * (b.mass / mass));
            let large = bodies.iter().map(|(_, b)| b.large).fold(0.0, f32::max);
            let Some(feet) = feet(look, &group, large) else { continue };
            let labels: Vec<u32> = bodies.iter().map(|(_, b)| b.label).collect();
            if feet.is_empty() {
                let detail = format!("bodies {labels:?} at height {}", center.y);
                findings.add(Kind::Balance, "rests in mid-air", detail, look.step);
                continue;
            }
            let off = outside(&feet, center);
            // Contact points are those of the beginning of the step in which all fell asleep.
            let way = look.world.config().sleep.speed * look.dt;
            if off > BESIDE * 2.0 * large + way {
                let detail = format!("bodies {labels:?}, {off} m beside what holds them");
                findings.add(Kind::Balance, "rests off balance", detail, look.step);
            }
        }
    }

    /// Records the state of all bodies for [`Self::end`]. `part` is the elapsed fraction of the
    /// last quiet time.
    pub(super) fn mark(&mut self, look: &Look<'_>, part: f32) {
        if part > 0.66 && self.mark.is_none() {
            self.mark = Some((look.time, look.now.clone()));
        }
        if part > 0.9 {
            for (id, body) in look.now.dynamic() {
                let fastest = self.fastest.entry(id).or_default();
                *fastest = fastest.max(body.speed());
            }
        }
    }

    /// Checks that everything that must come to rest has done so.
    pub(super) fn end(&self, look: &Look<'_>, findings: &mut Findings) {
        if !look.facts.must_rest() {
            return;
        }
        let floor = look.facts.half_floor.unwrap_or(0.0);
        let all = look
            .now
            .dynamic()
            .all(|(_, b)| b.center.y > -b.large && b.center.x.abs().max(b.center.z.abs()) < floor);
        // Only after enough time: 25 s, and 40 times the duration of a fall by its own length.
        let large = look.now.dynamic().map(|(_, b)| b.large).fold(0.0, f32::max);
        let fall = (2.0 * large / look.facts.gravity).sqrt();
        if !all || look.quiet < 25.0 || look.quiet < 40.0 * fall {
            return;
        }
        for (id, body) in look.now.dynamic() {
            if body.is_asleep {
                continue;
            }
            let speed = self.fastest.get(&id).copied().unwrap_or(0.0) / look.fall_speed(body);
            if speed > CREEP_SPEED {
                let detail = format!("{speed} of the speed of a fall, {} m/s", body.speed());
                findings.add(Kind::Restless, "moves though it must rest", detail, look.step);
            }
            let Some((_, mark)) = &self.mark else { continue };
            let Some(then) = mark.bodies.get(&id) else { continue };
            let way = (then.center - body.center).length()
                + turn_between(then.pose.rotation, body.pose.rotation) * body.large;
            if way > CREEP * body.large {
                let detail = format!("{way} m, half a length is {} m", body.large);
                findings.add(Kind::Restless, "creeps though it must rest", detail, look.step);
            }
        }
    }
}

/// Whether a joint, or an axis lock, connects a body to a static or kinematic body.
fn is_held(look: &Look<'_>, body: &Body) -> bool {
    look.facts.hangs && look.facts.jointed.contains(&body.label)
}

/// Groups of dynamic bodies that touch or are joined.
fn groups(look: &Look<'_>) -> Vec<Vec<BodyId>> {
    let ids: Vec<BodyId> = look.now.dynamic().map(|(id, _)| id).collect();
    let mut group: BTreeMap<BodyId, usize> =
        ids.iter().enumerate().map(|(i, id)| (*id, i)).collect();
    let touches = look.now.touches.iter().map(|t| t.bodies);
    let joints: Vec<[BodyId; 2]> = look.world.joints().map(|j| [j.body_a(), j.body_b()]).collect();
    for [a, b] in touches.chain(joints) {
        if let (Some(p), Some(q)) = (group.get(&a).copied(), group.get(&b).copied()) {
            group.values_mut().filter(|g| **g == q).for_each(|g| *g = p);
        }
    }
    let mut all: BTreeMap<usize, Vec<BodyId>> = BTreeMap::new();
    for (id, number) in group {
        all.entry(number).or_default().push(id);
    }
    all.into_values().collect()
}

/// Points at which static and kinematic bodies carry a group. `None` if it leans on a wall, or if a
/// carrier moves.
fn feet(look: &Look<'_>, group: &[BodyId], large: f32) -> Option<Vec<Vec3>> {
    let mut feet = Vec::new();
    for touch in &look.now.touches {
        for id in touch.bodies {
            let Some((other, normal)) = touch.toward(id).filter(|_| group.contains(&id)) else {
                continue;
            };
            let Some(body) = look.now.bodies.get(&other).filter(|b| !b.is_dynamic()) else {
                continue;
            };
            if body.speed() > 0.0 {
                return None;
            }
            for point in &touch.points {
                let is_near = point.separation < 2.0e-3 * large + 1.0e-4;
                if point.impulse <= 0.0 && !is_near {
                    continue;
                }
                if normal.y < 0.95 {
                    return None;
                }
                feet.push(point.at);
            }
        }
    }
    Some(feet)
}

/// Distance of a point outside the hull of other points, seen from above [m].
fn outside(points: &[Vec3], center: Vec3) -> f32 {
    // The distance is a maximum over directions. Edges of the hull and pairs of points each give
    // the distance to a line with all points on one side.
    let flat: Vec<(f32, f32)> = points.iter().map(|p| (p.x - center.x, p.z - center.z)).collect();
    let mut most = 0.0_f32;
    // For a direction with all points beyond the center: the distance of the nearest point along
    // it. The best of many directions, each to a point or perpendicular to a pair.
    let mut tried: Vec<(f32, f32)> = flat.clone();
    for (i, a) in flat.iter().enumerate() {
        for b in &flat[i + 1..] {
            let (x, z) = (b.0 - a.0, b.1 - a.1);
            tried.extend([(z, -x), (-z, x)]);
        }
    }
    for (x, z) in tried {
        let length = (x * x + z * z).sqrt();
        if length <= 0.0 {
            continue;
        }
        let along = |p: &(f32, f32)| (p.0 * x + p.1 * z) / length;
        let nearest = flat.iter().map(along).fold(f32::INFINITY, f32::min);
        most = most.max(nearest);
    }
    most
}

#[cfg(test)]
mod tests {
    use drystone::{Vec3, vec3};

    use super::outside;

    #[test]
    fn a_center_over_its_feet_is_not_outside_and_one_beside_them_is() {
        let feet = [vec3(-1.0, 0.0, -1.0), vec3(1.0, 0.0, -1.0), vec3(0.0, 0.0, 1.0)];
        assert!(outside(&feet, Vec3::ZERO) <= 0.0);
        assert!((outside(&feet, vec3(0.0, 5.0, -1.5)) - 0.5).abs() < 1.0e-6);
        assert!((outside(&feet, vec3(0.0, 0.0, 3.0)) - 2.0).abs() < 1.0e-6);
        assert!((outside(&[Vec3::ZERO], vec3(0.3, 0.0, 0.4)) - 0.5).abs() < 1.0e-6);
    }
}
