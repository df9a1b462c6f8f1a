//! The audit of a world in the words of its scene: for the report, and for people.

use drystone::audit::{Audit, AwakeCause, ConstraintId, ContactPair, Energy, Ledger};
use drystone::{BodyId, BodyKind, JointId, Vec3, World};
use serde::Serialize;

use super::page::{Page, count, si};
use crate::file::events::Names;
use crate::output::one_line;

/// Most awake bodies whose cause is looked up, evenly over all: each lookup goes through a whole
/// island.
const ASKED: usize = 20;

/// Most different causes that are listed.
const TOLD: usize = 5;

/// The `audit` object of a report.
#[derive(Debug, Serialize)]
pub(crate) struct AuditReport {
    energy: EnergyNow,
    /// Only with `--audit`: keeping it takes time in every step.
    ledger: Option<LedgerLines>,
    momentum: MomentumNow,
    penetration: Overlaps,
    joints: JointErrors,
    cone: Option<Cone>,
    residual: Residual,
    worst: Option<Worst>,
    non_finite: Vec<String>,
    awake: Vec<Awake>,
}

/// [J]
#[derive(Debug, Serialize)]
struct EnergyNow {
    linear: f64,
    angular: f64,
    potential: f64,
    elastic: f64,
}

/// [J]
#[derive(Debug, Serialize)]
struct LedgerLines {
    steps: u64,
    start: f64,
    forces: f64,
    impulses: f64,
    changes: f64,
    kinematic: f64,
    now: f64,
    dissipated: f64,
}

/// SI units, world.
#[derive(Debug, Serialize)]
struct MomentumNow {
    mass: f64,
    center_of_mass: [f32; 3],
    linear: [f32; 3],
    about_origin: [f32; 3],
    about_center: [f32; 3],
}

type Between = [String; 2];

/// [m]
#[derive(Debug, Serialize)]
struct Overlaps {
    points: usize,
    max: f32,
    p99: f32,
    mean: f32,
    between: Option<Between>,
}

/// [m] and [rad]
#[derive(Debug, Serialize)]
struct JointErrors {
    linear: f32,
    linear_joint: Option<u32>,
    angular: f32,
    angular_joint: Option<u32>,
}

#[derive(Debug, Serialize)]
struct Cone {
    ratio: f32,
    between: Between,
}

#[derive(Debug, Serialize)]
struct Residual {
    speed: f32,
    relative: f32,
    between: Option<Between>,
    gap: f32,
    gap_between: Option<Between>,
    pull: f32,
}

#[derive(Debug, Serialize)]
struct Worst {
    kind: &'static str,
    joint: Option<u32>,
    between: Between,
    error: f32,
}

/// A body that is awake, and why.
#[derive(Debug, Serialize)]
struct Awake {
    body: String,
    because_of: String,
    why: String,
    path: Vec<String>,
}

impl AuditReport {
    /// The audit of a world as it is now.
    pub(crate) fn of(world: &World, names: &Names) -> Self {
        let audit = world.audit();
        let between = |pair: ContactPair| [names.of(pair.body_a), names.of(pair.body_b)];
        let (p, j, r, m) = (&audit.penetration, &audit.joints, &audit.residual, &audit.momentum);
        let array = Vec3::to_array;
        Self {
            energy: EnergyNow::of(&audit.energy),
            ledger: audit.ledger.as_ref().map(LedgerLines::of),
            momentum: MomentumNow {
                mass: m.mass,
                center_of_mass: array(m.center_of_mass),
                linear: array(m.linear),
                about_origin: array(m.about_origin),
                about_center: array(m.about_center),
            },
            penetration: Overlaps {
                points: p.points,
                max: p.max,
                p99: p.p99,
                mean: p.mean,
                between: p.at.map(between),
            },
            joints: JointErrors {
                linear: j.linear,
                linear_joint: j.linear_joint.map(JointId::index),
                angular: j.angular,
                angular_joint: j.angular_joint.map(JointId::index),
            },
            cone: audit.cone.map(|c| Cone { ratio: c.ratio, between: between(c.at) }),
            residual: Residual {
                speed: r.speed,
                relative: r.relative,
                between: r.at.map(between),
                gap: r.gap,
                gap_between: r.gap_at.map(between),
                pull: r.pull,
            },
            worst: worst(&audit, world, names),
            non_finite: audit.non_finite.iter().map(|id| names.of(*id)).collect(),
            awake: awake(world, names),
        }
    }

    /// For people: the subjects in a column.
    pub(crate) fn rows(&self, page: &mut Page) {
        let e = &self.energy;
        let (linear, angular) = (si(e.linear, "J"), si(e.angular, "J"));
        let (potential, elastic) = (si(e.potential, "J"), si(e.elastic, "J"));
        page.row(
            "audit",
            &format!("motion {linear}, rotation {angular}, height {potential}, springs {elastic}"),
        );
        if let Some(l) = &self.ledger {
            page.row(
                "ledger",
                &format!(
                    "{} at the start, + {} forces, + {} impulses and velocities, + {} changes, + {} \
                     kinematic bodies",
                    si(l.start, "J"),
                    si(l.forces, "J"),
                    si(l.impulses, "J"),
                    si(l.changes, "J"),
                    si(l.kinematic, "J"),
                ),
            );
            page.row(
                "ledger",
                &format!("= {} now, + {} dissipated", si(l.now, "J"), si(l.dissipated, "J")),
            );
        }
        let m = &self.momentum;
        page.row("momentum", &format!("{} kg m/s; mass {} kg", vector(m.linear), short(m.mass)));
        page.row(
            "spin",
            &format!(
                "{} kg m2/s about the center of mass at {} m; about the origin {}",
                vector(m.about_center),
                vector(m.center_of_mass),
                vector(m.about_origin)
            ),
        );
        let p = &self.penetration;
        page.row(
            "overlap",
            &format!(
                "max {}, p99 {}, mean {} of {}{}",
                meters(p.max),
                meters(p.p99),
                meters(p.mean),
                count(p.points, "point"),
                of(p.between.as_ref())
            ),
        );
        if let Some(cone) = &self.cone {
            let between = of(Some(&cone.between));
            page.row("friction", &format!("{:.4} of its cone at most{between}", cone.ratio));
        }
        let r = &self.residual;
        page.row(
            "residual",
            &format!(
                "{}, {:.2e} of a step's gravity{}",
                si(f64::from(r.speed), "m/s"),
                r.relative,
                of(r.between.as_ref())
            ),
        );
        page.row(
            "residual",
            &format!(
                "complementarity {} (gap times load in weights){}; pull {:.1e}",
                meters(r.gap),
                of(r.gap_between.as_ref()),
                r.pull
            ),
        );
        if let Some(w) = &self.worst {
            let joint = w.joint.map_or(String::new(), |number| format!(" {number}"));
            let error = meters(w.error);
            page.row("worst", &format!("{error} at {}{joint}{}", w.kind, of(Some(&w.between))));
        }
        for body in &self.non_finite {
            page.row("not finite", &one_line(body));
        }
        for a in &self.awake {
            let way = if a.path.len() > 2 {
                format!(" ({} away)", count(a.path.len() - 1, "body"))
            } else {
                String::new()
            };
            let whom = if a.body == a.because_of {
                String::new()
            } else {
                format!("because of '{}'{way}: ", a.because_of)
            };
            page.row("awake", &one_line(&format!("'{}': {whom}{}", a.body, a.why)));
        }
    }
}

impl EnergyNow {
    const fn of(e: &Energy) -> Self {
        let &Energy { linear, angular, potential, elastic, .. } = e;
        Self { linear, angular, potential, elastic }
    }
}

impl LedgerLines {
    fn of(l: &Ledger) -> Self {
        Self {
            steps: l.steps,
            start: l.start.total(),
            forces: l.forces,
            impulses: l.impulses,
            changes: l.changes,
            kinematic: l.kinematic,
            now: l.now.total(),
            dissipated: l.dissipated,
        }
    }
}

fn worst(audit: &Audit, world: &World, names: &Names) -> Option<Worst> {
    let worst = audit.worst?;
    let (kind, joint, a, b) = match worst.id {
        ConstraintId::Contact(pair) => ("contact", None, pair.body_a, pair.body_b),
        ConstraintId::Joint(id) => {
            let joint = world.joint(id)?;
            ("joint", Some(id.index()), joint.body_a(), joint.body_b())
        }
        _ => return None,
    };
    Some(Worst { kind, joint, between: [names.of(a), names.of(b)], error: worst.error })
}

/// Why bodies are awake: one for each that keeps others so.
fn awake(world: &World, names: &Names) -> Vec<Awake> {
    let mut told: Vec<(BodyId, Awake)> = Vec::new();
    let awake = || world.bodies().filter(|b| b.kind() == BodyKind::Dynamic && !b.is_asleep());
    let stride = awake().count().div_ceil(ASKED).max(1);
    for body in awake().step_by(stride) {
        let Some(why) = world.why_awake(body.id()) else { continue };
        let everywhere = why.cause == AwakeCause::SleepDisabled;
        if told.len() < TOLD && told.iter().all(|(culprit, _)| *culprit != why.body) {
            let line = Awake {
                body: names.of(body.id()),
                because_of: names.of(why.body),
                why: why.cause.to_string(),
                path: why.path.iter().map(|id| names.of(*id)).collect(),
            };
            told.push((why.body, line));
        }
        if everywhere {
            break;
        }
    }
    told.into_iter().map(|(_, line)| line).collect()
}

fn of(between: Option<&Between>) -> String {
    between.map_or(String::new(), |[a, b]| one_line(&format!(", '{a}' and '{b}'")))
}

fn meters(value: f32) -> String {
    si(f64::from(value), "m")
}

fn vector([x, y, z]: [f32; 3]) -> String {
    format!("({}, {}, {})", short(f64::from(x)), short(f64::from(y)), short(f64::from(z)))
}

/// Four digits.
fn short(value: f64) -> String {
    let size = value.abs();
    if size > 0.0 && !(1.0e-3..1.0e5).contains(&size) {
        format!("{value:.3e}")
    } else {
        format!("{value:.3}")
    }
}
