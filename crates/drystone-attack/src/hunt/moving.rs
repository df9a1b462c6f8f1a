//! What is known of single motions: what slides without friction goes on, stacks stand, what is driven moves.

use std::collections::BTreeMap;

use drystone::{BodyId, JointId, JointKind, Vec3};

use super::facts::is_motor;
use super::moment::{Body, Look, turn_between};
use crate::finding::{Findings, Kind};

/// A stack may be pressed together by this part of what is under a block, and lean by this angle [rad].
const PRESSED: f32 = 0.05;
const LEAN: f32 = 0.05;

/// What slides without friction keeps this part of its speed, and rises by no more of its own height.
const KEPT: f32 = 0.98;
const RISE: f32 = 0.02;

/// What lands with restitution 0 comes up again with no more of its speed.
const UP: f32 = 0.1;

/// Slip on what carries a body, as a part of the speed of the carrier, and for how long it is forgiven [s].
const SLIP: f32 = 0.1;
const SLIP_TIME: f32 = 1.0;

/// Part of its speed that a motor must have, and after what time [s].
const DRIVEN: f32 = 0.5;
const DRIVE_TIME: f32 = 3.0;

/// Motions over a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Motions {
    fall: f32,
    slip: BTreeMap<(BodyId, BodyId), f32>,
    turned: BTreeMap<JointId, Turned>,
}

/// How far a driven axis has come.
#[derive(Clone, Copy, Debug, Default)]
struct Turned {
    last: f32,
    /// Since the motor had time to start.
    way: f32,
    time: f32,
}

impl Motions {
    pub(super) fn see(&mut self, look: &Look<'_>, findings: &mut Findings) {
        if let Some((_, body)) = look.facts.glider.and_then(|label| look.now.named(label)) {
            glide(look, body, findings);
        }
        if look.facts.stands {
            stand(look, findings);
        }
        if look.facts.lands_flat {
            self.land(look, findings);
        }
        if look.facts.has_carriers || look.facts.has_belts {
            self.carried(look, findings);
        }
        if look.facts.has_drives {
            self.driven(look);
        }
    }

    /// No body comes up again.
    fn land(&mut self, look: &Look<'_>, findings: &mut Findings) {
        for (_, body) in look.now.dynamic() {
            self.fall = self.fall.max(-body.v.y);
            // The second: it rises by a hundredth of its length.
            let allowed = UP * self.fall + 0.1 * look.fall_speed(body);
            if body.v.y > allowed {
                let detail =
                    format!("up at {} m/s, the fastest fall was {} m/s", body.v.y, self.fall);
                findings.add(Kind::Bounce, "restitution 0 bounces", detail, look.step);
            }
        }
    }

    /// What only one moving carrier, or a belt, carries or pushes goes with it.
    fn carried(&mut self, look: &Look<'_>, findings: &mut Findings) {
        let mut slips: BTreeMap<(BodyId, BodyId), f32> = BTreeMap::new();
        for (id, body) in look.now.dynamic() {
            if look.facts.jointed.contains(&body.label) {
                continue;
            }
            let own = || look.now.touches.iter().filter_map(|t| Some((t, t.toward(id)?)));
            let mut others: Vec<BodyId> = own().map(|(_, (other, _))| other).collect();
            others.dedup();
            for (touch, (other, normal)) in own() {
                let Some(carrier) = look.now.bodies.get(&other).filter(|b| !b.is_dynamic()) else {
                    continue;
                };
                let is_floor = normal.y > 0.9;
                for point in &touch.points {
                    let Some(slip) = slip(
                        look,
                        touch,
                        (body, carrier),
                        point.at,
                        normal,
                        is_floor && others.len() == 1,
                    ) else {
                        continue;
                    };
                    let most = slips.entry((id, other)).or_default();
                    *most = most.max(slip);
                }
            }
        }
        self.slip.retain(|pair, _| slips.contains_key(pair));
        for (pair, part) in slips {
            let time = self.slip.entry(pair).or_default();
            *time = if part > SLIP { *time + look.dt } else { 0.0 };
            // Friction takes its time to bring what it holds to the carrier's speed.
            let carrier = look.now.bodies.get(&pair.1).map_or(0.0, Body::speed);
            let belt = look.facts.bodies.values().map(|b| b.belt).fold(0.0, f32::max);
            let start = 2.0 * carrier.max(belt)
                / (look.facts.least_friction * look.facts.gravity).max(1.0e-6);
            if *time > SLIP_TIME + start {
                let detail = format!("{part} of the speed of what carries it");
                findings.add(Kind::Stalled, "does not go with what carries it", detail, look.step);
            }
        }
    }

    fn driven(&mut self, look: &Look<'_>) {
        for joint in look.world.joints() {
            let Some((_, is_turn)) = motor_of(&joint.kind()) else { continue };
            let Some([moves, turns]) = joint.coordinates() else { continue };
            let now = if is_turn { turns.x } else { moves.x };
            let entry =
                self.turned.entry(joint.id()).or_insert(Turned { last: now, ..Turned::default() });
            let mut way = now - entry.last;
            if is_turn {
                let round = 2.0 * core::f32::consts::PI;
                way -= round * (way / round).round();
            }
            entry.last = now;
            if look.quiet > DRIVE_TIME {
                entry.way += way;
                entry.time += look.dt;
            }
        }
    }

    /// Motors that nothing blocks have turned.
    pub(super) fn end(&self, look: &Look<'_>, findings: &mut Findings) {
        for joint in look.world.joints() {
            let Some((speed, is_turn)) = motor_of(&joint.kind()) else { continue };
            let Some(turned) = self.turned.get(&joint.id()).filter(|t| t.time > 1.0) else {
                continue;
            };
            let bodies = [joint.body_a(), joint.body_b()];
            let is_blocked =
                look.now.touches.iter().any(|t| bodies.iter().any(|id| t.bodies.contains(id)));
            // A turn of more than half a round in a step cannot be told.
            let is_told = !is_turn || speed.abs() * look.dt < 2.0;
            if is_blocked || !is_told || !look.facts.hangs {
                continue;
            }
            if turned.way / turned.time / speed < DRIVEN {
                let detail = format!("{} in {} s at {speed} a second", turned.way, turned.time);
                findings.add(Kind::Stalled, "a motor stands", detail, look.step);
            }
        }
    }
}

/// The speed of the motor of a joint's x axis, and whether it turns.
fn motor_of(kind: &JointKind) -> Option<(f32, bool)> {
    let JointKind::SixDof(axes) = kind else { return None };
    let of = |axis: &drystone::joint::JointAxis| axis.drive.filter(is_motor).map(|d| d.velocity);
    of(&axes.angular[0]).map(|v| (v, true)).or(of(&axes.linear[0]).map(|v| (v, false)))
}

/// Slip of a body on a carrier at a point, as a part of the carrier's speed there. Along the surface only where it lies
/// on it; along the normal only what comes nearer.
fn slip(
    look: &Look<'_>,
    touch: &super::moment::Touch,
    (body, carrier): (&Body, &Body),
    at: Vec3,
    normal: Vec3,
    is_floor: bool,
) -> Option<f32> {
    let mut surface = carrier.velocity_at(at);
    for id in touch.shapes {
        let shape = look.world.shape(id)?;
        if look.now.bodies.get(&shape.body()).is_some_and(|b| b.label == carrier.label) {
            surface += shape.pose().rotation.rotate(shape.surface_velocity());
        }
    }
    let speed = surface.length();
    if speed < 1.0e-4 * look.fall_speed(body) {
        return None;
    }
    let off = body.velocity_at(at) - surface;
    let toward = (-off.dot(normal)).max(0.0);
    let along = if is_floor { (off - normal * off.dot(normal)).length() } else { 0.0 };
    // Away from what sinks under it: held in the air.
    let away = if is_floor && body.is_asleep { off.dot(normal).max(0.0) } else { 0.0 };
    Some(toward.max(along).max(away) / speed)
}

/// What slides without friction goes straight on, as fast as before.
fn glide(look: &Look<'_>, body: &Body, findings: &mut Findings) {
    let Some(made) = look.facts.bodies.get(&body.label) else { return };
    let floor = look.facts.half_floor.unwrap_or(0.0);
    let at = body.center;
    if at.x.abs().max(at.z.abs()) + 2.0 * body.large > floor {
        return;
    }
    let start = made.linear_velocity;
    let along = body.v.dot(start) / start.dot(start);
    if !(KEPT..=2.0 - KEPT).contains(&along) {
        let detail = format!("{along} of its speed {}", start.length());
        findings.add(Kind::Glide, "speed is lost without friction", detail, look.step);
    }
    let rise = body.pose.position.y - made.position.y;
    // It is held a rest offset above the floor.
    let offset = 4.0 * look.world.config().contact.rest_offset;
    if rise > RISE * 2.0 * made.down + offset {
        let detail = format!("{rise} m, its height is {} m", 2.0 * made.down);
        findings.add(Kind::Glide, "hops on a flat floor", detail, look.step);
    }
}

/// Blocks of a stack stay where they were put.
fn stand(look: &Look<'_>, findings: &mut Findings) {
    // Each is held a rest offset above the one below.
    #[expect(clippy::cast_precision_loss, reason = "at most some tens")]
    let apart = look.now.bodies.len() as f32;
    for (_, body) in look.now.dynamic() {
        let Some(made) = look.facts.bodies.get(&body.label) else { continue };
        if body.label < super::floors::FIRST_BODY {
            continue;
        }
        let off = body.pose.position - made.position;
        let across = (off.x * off.x + off.z * off.z).sqrt();
        // The height from the floor to its top is that of all that can be pressed.
        let height = made.position.y + made.up;
        let offset = 2.0 * apart * look.world.config().contact.rest_offset;
        let is_off = off.y.abs() > PRESSED * height + offset || across > LEAN * height + offset;
        let turn = turn_between(body.pose.rotation, made.rotation);
        if is_off || turn > LEAN {
            let detail = format!("{off:?} m, {turn} rad, its top was at {height} m");
            findings.add(Kind::Fallen, "a stack does not stand", detail, look.step);
        }
    }
}
