//! Energy and momentum must not increase without a source.

use std::collections::VecDeque;

use drystone::{JointKind, Vec3};

use super::moment::{Look, Touch};
use crate::finding::{Findings, Kind};

/// Gain that rounding and integration errors may add: as a fraction of the last second's energy,
/// and per second [1/s]. Users would notice some percent.
const PART: f64 = 0.03;
const PART_RATE: f64 = 5.0e-4;

/// Number of substeps of the default method. A bounce happens within one substep, in which gravity
/// acts too.
const SUBSTEPS: f64 = 8.0;

/// Time for which the energy of a motion counts [s].
const MEMORY: f64 = 1.0;

/// Number of steps for which a soft contact or joint stores energy. Contacts are overdamped, with a
/// time constant of 2ζ/ω = 16/(2π 54 Hz) at 60 Hz, three steps; joints are stiffer.
const GIVE: usize = 4;

/// Documented speed at which overlaps are pushed out [m/s], and its growth with depth [1/s].
const PUSH: f32 = 0.25;
const PUSH_RATE: f32 = 6.0;

/// The energy balance of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Conservation {
    /// Maximum loss so far, and the reference energy at that time [J].
    lost: Option<f64>,
    /// Losses of the last steps.
    recent: VecDeque<f64>,
    kinetic: f64,
    scale: f64,
    /// Maximum work of drives so far [J].
    driven: f64,
    /// Energy of compliant contacts and joints: load × displacement, the maximum of the last second
    /// [J].
    sag: f64,
    overlapped: f64,
    momentum: Option<(Vec3, Vec3)>,
    /// Maximum rotation of a body in a step so far [rad].
    turn: f32,
    highest: f32,
    fastest: f32,
    /// Maximum gain relative to its tolerance.
    pub(super) worst: f64,
}

impl Conservation {
    pub(super) fn see(&mut self, look: &Look<'_>, findings: &mut Findings) {
        if look.facts.is_closed() {
            self.energy(look, findings);
        } else {
            self.bound(look, findings);
        }
        let is_free = !look.facts.has_fixed && !look.facts.hangs && !look.facts.has_calls;
        if is_free && look.facts.gravity == 0.0 && !look.facts.has_drives {
            self.momentum(look, findings);
        }
    }

    fn energy(&mut self, look: &Look<'_>, findings: &mut Findings) {
        let audit = look.world.audit();
        let Some(ledger) = audit.ledger else { return };
        let fade = (1.0 - f64::from(look.dt) / MEMORY).max(0.0);
        let gravity = f64::from(look.facts.gravity);
        let (mut weight, mut count, mut bounce) = (0.0, 0.0, 0.0);
        for (_, body) in look.now.dynamic() {
            let (mass, v) = (f64::from(body.mass), f64::from(body.v.length()));
            weight += mass * gravity;
            count += 1.0;
            bounce += mass * v * gravity * f64::from(look.dt) / SUBSTEPS;
        }
        // Energy that compliant contacts or joints on top of each other store and return: at most
        // the total weight times these displacements. Contacts keep bodies a rest offset apart.
        let offset = f64::from(look.world.config().contact.rest_offset);
        let own = f64::from(audit.penetration.max) + f64::from(audit.joints.linear) + offset;
        let way = own * count + 1.0e-4 * length(look);
        self.sag = (self.sag * fade).max(weight * way + 2.0 * bounce);
        self.kinetic = (self.kinetic * fade).max(audit.energy.kinetic());
        if look.step == 1 || look.quiet < 1.5 * look.dt {
            // A change between steps may have made bodies overlap.
            self.overlapped = self.overlapped.max(pushed_out(look));
        }
        if look.facts.has_drives {
            self.driven += drive_work(look);
        }
        // A soft contact or joint stores energy in an impact and returns it; that is not a gain.
        let lost = ledger.dissipated + self.driven;
        if self.lost.is_none() {
            self.kinetic = self.kinetic.max(ledger.start.kinetic());
        }
        self.recent.push_back(lost);
        if self.recent.len() > GIVE {
            self.recent.pop_front();
        }
        // Energy counts as lost only if it stayed away for that many steps.
        let stayed = self.recent.iter().copied().fold(f64::INFINITY, f64::min);
        if self.lost.is_none_or(|most| stayed >= most) {
            (self.lost, self.scale) = (Some(stayed), self.kinetic);
        }
        let most = self.lost.unwrap_or(stayed);
        // Rounding of heights far from the origin.
        let rounding = 1.0e-6 * (ledger.now.total().abs() + ledger.start.total().abs());
        let part = PART + PART_RATE * f64::from(look.time);
        let allowed = part * self.scale + self.sag + self.overlapped + rounding;
        let gained = most - lost;
        self.worst = self.worst.max(gained / allowed.max(1.0e-30));
        if gained > allowed {
            let part = gained / self.scale.max(1.0e-30);
            let detail = format!(
                "gained {gained:.3e} J, allowed {allowed:.3e}, {part:.3} of the kinetic energy of the second before"
            );
            findings.add(Kind::Energy, "energy from nothing", detail, look.step);
        }
    }

    /// Bound for worlds with moving carriers and belts: a body's speed is at most that of a bounce
    /// off a carrier plus a fall.
    fn bound(&mut self, look: &Look<'_>, findings: &mut Findings) {
        let mut carrier = look.facts.bodies.values().map(|b| b.belt).fold(0.0, f32::max);
        for body in look.before.bodies.values().filter(|b| !b.is_dynamic()) {
            carrier = carrier.max(body.speed());
        }
        self.fastest = self.fastest.max(carrier);
        let mut lowest = f32::INFINITY;
        for (_, body) in look.now.dynamic() {
            self.highest = self.highest.max(body.center.y);
            lowest = lowest.min(body.center.y);
        }
        if look.facts.has_calls && look.facts.jointed.is_empty() {
            return;
        }
        let start =
            look.facts.movers().map(|(_, m)| m.linear_velocity.length()).fold(0.0, f32::max);
        let fall = 2.0 * look.facts.gravity * (self.highest - lowest).max(0.0);
        let most = 2.0 * self.fastest + (start * start + fall).sqrt();
        for (_, body) in look.now.dynamic() {
            let slack = 0.15 * look.fall_speed(body) + 0.02 * most;
            // A body on a joint swings like a pendulum, at up to twice the speed of its holder.
            if body.v.length() > 1.5 * most + slack {
                let detail = format!("{} m/s, at most {most} m/s", body.v.length());
                findings.add(Kind::Energy, "faster than what carries it", detail, look.step);
            }
        }
    }

    fn momentum(&mut self, look: &Look<'_>, findings: &mut Findings) {
        let m = look.world.audit().momentum;
        let (linear, angular) = (m.linear, m.about_center);
        let Some((p, l)) = self.momentum else {
            self.momentum = Some((linear, angular));
            return;
        };
        let (mut sum, mut turning) = (0.0_f32, 0.0_f32);
        for (id, body) in look.now.dynamic() {
            sum += body.mass * body.v.length();
            let arm = (body.center - m.center_of_mass).length();
            let spin = look.world.body(id).map_or(0.0, |b| b.inertia().mul(body.w).length());
            turning += body.mass * body.v.length() * arm + spin;
        }
        // Rounding: half a unit in the last place per substep, 8 substeps per step.
        #[expect(clippy::cast_precision_loss, reason = "some thousands")]
        let rounding = 8.0 * look.step as f32 * f32::EPSILON;
        let off = (linear - p).length();
        if off > (1.0e-3 + rounding) * (sum + p.length()) {
            let detail = format!("{off:.3e} of {sum:.3e} kg m/s");
            findings.add(Kind::Momentum, "linear momentum from nothing", detail, look.step);
        }
        // A contact acts on both bodies at one point, except for its overlap: a hundredth. Its
        // lever arm is that of the beginning of the step; for a body that rotates by θ in the step,
        // the error is θ²/2.
        let turn = look.before.dynamic().map(|(_, b)| b.w.length() * look.dt).fold(0.0, f32::max);
        self.turn = self.turn.max(turn);
        let off = (angular - l).length();
        let part = 1.0e-2 + rounding + (0.5 * self.turn * self.turn).min(0.5);
        if off > part * (turning + l.length()) {
            let detail = format!("{off:.3e} of {turning:.3e} kg m²/s");
            findings.add(Kind::Momentum, "angular momentum from nothing", detail, look.step);
        }
    }
}

/// Half the length of the smallest body [m].
fn length(look: &Look<'_>) -> f64 {
    look.now.dynamic().map(|(_, b)| f64::from(b.large)).fold(f64::INFINITY, f64::min).min(1.0e6)
}

/// Kinetic energy of overlapping bodies from the documented push-out speeds [J].
fn pushed_out(look: &Look<'_>) -> f64 {
    let depth = look.now.touches.iter().map(Touch::depth).fold(0.0, f32::max);
    if !look.now.dynamic().any(|(_, b)| depth > 0.02 * b.thin) {
        return 0.0;
    }
    let speed = f64::from(PUSH + PUSH_RATE * depth);
    look.now.dynamic().map(|(_, b)| 0.5 * f64::from(b.mass) * speed * speed).sum()
}

/// Maximum work of drives in a step: maximum force times displacement of the axis [J].
fn drive_work(look: &Look<'_>) -> f64 {
    let mut work = 0.0;
    for joint in look.world.joints() {
        let JointKind::SixDof(axes) = joint.kind() else { continue };
        let (Some(a), Some(b)) =
            (look.now.bodies.get(&joint.body_a()), look.now.bodies.get(&joint.body_b()))
        else {
            continue;
        };
        let turning = (b.w - a.w).length();
        let moving = (b.velocity_at(joint.anchor_b()) - a.velocity_at(joint.anchor_b())).length();
        let dt = f64::from(look.dt);
        for (axes, rate) in [(&axes.linear, moving), (&axes.angular, turning)] {
            for drive in axes.iter().filter_map(|axis| axis.drive) {
                // The faster speed of both ends of the step. The energy already includes springs
                // without a target speed.
                let rate = f64::from(rate.max(drive.velocity.abs()));
                if drive.velocity != 0.0 {
                    work += f64::from(drive.max_force) * rate * dt;
                }
            }
        }
    }
    work
}
