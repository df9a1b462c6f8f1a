//! Laws for single motions: frictionless bodies slide on, stacks stand, driven bodies move.

use std::collections::BTreeMap;

use drystone::{BodyId, JointId, JointKind, Vec3};

use super::facts::is_motor;
use super::moment::{Body, Look, turn_between};
use crate::finding::{Findings, Kind};

/// Maximum compression of a stack, as a fraction of the height under a block, and maximum tilt
/// [rad].
const PRESSED: f32 = 0.05;
const LEAN: f32 = 0.05;

/// Minimum fraction of its speed that a frictionless body keeps, and maximum rise relative to its
/// own height.
const KEPT: f32 = 0.98;
const RISE: f32 = 0.02;

/// Maximum rebound speed with restitution 0, as a fraction of the impact speed.
const UP: f32 = 0.1;

/// Allowed slip on a carrier, as a fraction of the carrier's speed, and the time for which more is
/// tolerated [s].
const SLIP: f32 = 0.1;
const SLIP_TIME: f32 = 1.0;

/// Minimum fraction of its speed that a motor must reach, and after how long [s].
const DRIVEN: f32 = 0.5;
const DRIVE_TIME: f32 = 3.0;

/// Motions over a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Motions {
    fall: f32,
    slip: BTreeMap<(BodyId, BodyId), f32>,
    turned: BTreeMap<JointId, Turned>,
}

/// Displacement of a driven axis.
#[derive(Clone, Copy, Debug, Default)]
struct Turned {
    last: f32,
    /// Displacement and time since the motor had time to start.
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

    /// Checks that no body bounces.
    fn land(&mut self, look: &Look<'_>, findings: &mut Findings) {
        for (_, body) in look.now.dynamic() {
            self.fall = self.fall.max(-body.v.y);
            // The second term allows a rise by a hundredth of its length.
            let allowed = UP * self.fall + 0.1 * look.fall_speed(body);
            if body.v.y > allowed {
                let detail =
                    format!("up at {} m/s, the fastest fall was {} m/s", body.v.y, self.fall);
                findings.add(Kind::Bounce, "restitution 0 bounces", detail, look.step);
            }
        }
    }

    /// Checks that a body moves with its only moving carrier or belt, or with the carrier that
    /// pushes it.
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
            // Friction needs time to accelerate a body to the carrier's speed.
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

    /// Checks that motors without obstacles have moved.
    pub(super) fn end(&self, look: &Look<'_>, findings: &mut Findings) {
        for joint in look.world.joints() {
            let Some((speed, is_turn)) = motor_of(&joint.kind()) else { continue };
            let Some(turned) = self.turned.get(&joint.id()).filter(|t| t.time > 1.0) else {
                continue;
            };
            let bodies = [joint.body_a(), joint.body_b()];
            let is_blocked =
                look.now.touches.iter().any(|t| bodies.iter().any(|id| t.bodies.contains(id)));
            // A rotation of more than half a turn per step is ambiguous.
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

/// Speed of the motor of a joint's x axis, and whether it rotates.
fn motor_of(kind: &JointKind) -> Option<(f32, bool)> {
    let JointKind::SixDof(axes) = kind else { return None };
    let of = |axis: &drystone::joint::JointAxis| axis.drive.filter(is_motor).map(|d| d.velocity);
    of(&axes.angular[0]).map(|v| (v, true)).or(of(&axes.linear[0]).map(|v| (v, false)))
}

/// Slip of a body on a carrier at a point, as a fraction of the carrier's speed there. Slip along
/// the surface counts only if the body lies on it. Slip along the normal counts only if they
/// approach.
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
    // A sleeping body hangs in the air if its carrier sinks away.
    let away = if is_floor && body.is_asleep { off.dot(normal).max(0.0) } else { 0.0 };
    Some(toward.max(along).max(away) / speed)
}

/// Checks that a frictionless body moves on in a straight line at constant speed.
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
    // Contacts hold it a rest offset above the floor.
    let offset = 4.0 * look.world.config().contact.rest_offset;
    if rise > RISE * 2.0 * made.down + offset {
        let detail = format!("{rise} m, its height is {} m", 2.0 * made.down);
        findings.add(Kind::Glide, "hops on a flat floor", detail, look.step);
    }
}

/// Checks that the blocks of a stack stay in place.
fn stand(look: &Look<'_>, findings: &mut Findings) {
    // Contacts hold each block a rest offset above the one below.
    #[expect(clippy::cast_precision_loss, reason = "at most some tens")]
    let apart = look.now.bodies.len() as f32;
    for (_, body) in look.now.dynamic() {
        let Some(made) = look.facts.bodies.get(&body.label) else { continue };
        if body.label < super::floors::FIRST_BODY {
            continue;
        }
        let off = body.pose.position - made.position;
        let across = (off.x * off.x + off.z * off.z).sqrt();
        // The height from the floor to its top can be compressed.
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
