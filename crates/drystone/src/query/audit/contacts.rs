//! Errors of contacts: overlaps, friction cones, and the residual of the step.

use crate::base::id::{BodyId, ShapeId};
use crate::base::math::{Vec3, bounded};
use crate::base::quat::Quat;
use crate::state::bodies::body::Body;
use crate::state::contacts::{Contact, Point};
use crate::state::tables::Tables;

/// The two sides of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ContactPair {
    /// First shape.
    pub shape_a: ShapeId,
    /// Second shape.
    pub shape_b: ShapeId,
    /// Body of the first shape.
    pub body_a: BodyId,
    /// Body of the second shape.
    pub body_b: BodyId,
}

/// Current overlaps of shapes [m], over the points that carry load or overlap; 0 is a touch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Penetration {
    /// Number of these points.
    pub points: usize,
    /// The deepest overlap.
    pub max: f32,
    /// 99 of 100 points are at most this deep.
    pub p99: f32,
    /// Mean over the points.
    pub mean: f32,
    /// The contact with the deepest overlap; `None` if nothing overlaps.
    pub at: Option<ContactPair>,
}

/// The part of its friction cone that a contact uses.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConeUse {
    /// Friction impulse over friction coefficient times normal impulse: at most 1 if Coulomb's law
    /// holds, 1 where the contact slides; `f32::MAX` for friction without normal impulse.
    pub ratio: f32,
    /// The contact.
    pub at: ContactPair,
}

/// Errors that contacts left unsolved in the last step, each the largest of all contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ContactResidual {
    /// Remaining normal speed of a point under load [m/s]; 0 for an exact solution. A separating
    /// point does not count where the contact may bounce.
    pub speed: f32,
    /// `speed` over the speed that gravity adds in a step: the missing impulse, relative to the
    /// gravity impulse of the lighter body. A world without gravity counts as 9.81 m/s².
    pub relative: f32,
    /// The contact with the largest `speed`.
    pub at: Option<ContactPair>,
    /// Complementarity: gap of a point under load [m], times its impulse over the gravity impulse
    /// of the lighter body in a substep. It is 0 if only touching points carry load.
    pub gap: f32,
    /// The contact with the largest `gap`.
    pub gap_at: Option<ContactPair>,
    /// Largest pulling normal impulse, over the gravity impulse of the lighter body in a substep;
    /// 0: contacts only push.
    pub pull: f32,
}

/// All measurements of contacts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ContactAudit {
    pub(super) penetration: Penetration,
    pub(super) cone: Option<ConeUse>,
    pub(super) residual: ContactResidual,
}

impl ContactAudit {
    /// Measures all contacts. `h` is the last substep [s], 0 before the first; `substeps` is the
    /// number of substeps in a step.
    pub(super) fn of(tables: &Tables, h: f32, substeps: u32) -> Self {
        let gravity = tables.config.gravity.length();
        let gravity = if gravity > 0.0 { gravity } else { 9.81 };
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let fall = Fall { substep: gravity * h, step: gravity * h * substeps as f32 };
        let mut audit = Self::default();
        let mut depths = Vec::new();
        for (row, c) in tables.contacts.iter().filter(|(_, c)| c.count > 0 && !c.sensor) {
            let (a, b) = (tables.bodies.at(c.body_a), tables.bodies.at(c.body_b));
            if !a.is_dynamic() && !b.is_dynamic() {
                continue;
            }
            let pair = pair_of(tables, c);
            let motion = Motion::since(tables.contacts.rotations_of(row), a, b);
            audit.add_points(c, [a, b], &motion, fall, pair, &mut depths);
            audit.add_cone(c, pair);
        }
        audit.penetration.summarize(&mut depths);
        audit
    }

    fn add_points(
        &mut self,
        c: &Contact,
        [a, b]: [&Body; 2],
        motion: &Motion,
        fall: Fall,
        pair: ContactPair,
        depths: &mut Vec<f32>,
    ) {
        let unit = lighter_mass(a, b) * fall.substep;
        for p in c.points() {
            let separation = if c.recyclable {
                anchors_apart(c, p, motion.then, a, b)
            } else {
                motion.apart(c, p)
            };
            let pressed = p.impulse > 0.0;
            if pressed || separation < 0.0 {
                depths.push((-separation).max(0.0));
            }
            if -separation > self.penetration.max {
                (self.penetration.max, self.penetration.at) = (-separation, Some(pair));
            }
            // No contact is solved before the first step.
            if !(fall.substep > 0.0) {
                continue;
            }
            let r = &mut self.residual;
            r.pull = r.pull.max(bounded(-p.impulse / unit));
            if !pressed {
                continue;
            }
            let speed = c.normal.dot(b.velocity_at(c.r_b(p)) - a.velocity_at(p.r_a));
            let left = if c.restitution > 0.0 { -speed } else { speed.abs() };
            if left > r.speed {
                (r.speed, r.relative, r.at) = (left, bounded(left / fall.step), Some(pair));
            }
            let gap = bounded(separation * (p.impulse / unit));
            if gap > r.gap {
                (r.gap, r.gap_at) = (gap, Some(pair));
            }
        }
    }

    fn add_cone(&mut self, c: &Contact, at: ContactPair) {
        // Sliding and twist share one limit.
        let twist = c.twist_impulse;
        let friction = (c.tangent_impulse.length_squared() + twist * twist).sqrt();
        let normal: f32 = c.points().iter().map(|p| p.impulse.max(0.0)).sum();
        let limit = c.friction * normal;
        if !(limit > 0.0 || friction > 0.0) {
            return;
        }
        let ratio = if limit > 0.0 { bounded(friction / limit) } else { f32::MAX };
        if self.cone.is_none_or(|worst| ratio > worst.ratio) {
            self.cone = Some(ConeUse { ratio, at });
        }
    }
}

impl Penetration {
    fn summarize(&mut self, depths: &mut [f32]) {
        self.points = depths.len();
        if depths.is_empty() {
            return;
        }
        depths.sort_unstable_by(f32::total_cmp);
        // Nearest rank: the smallest depth that 99 of 100 points do not exceed.
        self.p99 = depths[(depths.len() * 99).div_ceil(100) - 1];
        #[expect(clippy::cast_precision_loss, reason = "far fewer than 2^52 points")]
        let count = depths.len() as f64;
        let mean = depths.iter().map(|d| f64::from(*d)).sum::<f64>() / count;
        #[expect(clippy::cast_possible_truncation, reason = "a mean of f32")]
        {
            self.mean = mean as f32;
        }
    }
}

/// Speed that gravity adds [m/s].
#[derive(Clone, Copy, Debug)]
struct Fall {
    substep: f32,
    step: f32,
}

fn pair_of(tables: &Tables, c: &Contact) -> ContactPair {
    ContactPair {
        shape_a: tables.shapes.id(c.shape_a),
        shape_b: tables.shapes.id(c.shape_b),
        body_a: tables.bodies.id(c.body_a),
        body_b: tables.bodies.id(c.body_b),
    }
}

fn lighter_mass(a: &Body, b: &Body) -> f32 {
    let mass = |body: &Body| if body.is_dynamic() { body.inertia.mass } else { f32::INFINITY };
    mass(a).min(mass(b))
}

/// Current separation of a contact between flat shapes: its anchors move with the bodies, as in
/// recycling.
fn anchors_apart(c: &Contact, p: &Point, [then_a, then_b]: [Quat; 2], a: &Body, b: &Body) -> f32 {
    let n_a = then_a.rotate(a.rotation.unrotate(c.normal));
    let n_b = then_b.rotate(b.rotation.unrotate(c.normal));
    p.base + (c.normal.dot(b.center - a.center) + (n_b.dot(c.r_b(p)) - n_a.dot(p.r_a)))
}

/// Motion of two bodies since their manifold was computed.
struct Motion {
    then: [Quat; 2],
    /// Current center of B minus center of A [m, world].
    offset: Vec3,
    turn_a: Vec3,
    turn_b: Vec3,
}

impl Motion {
    fn since([then_a, then_b]: [Quat; 2], a: &Body, b: &Body) -> Self {
        let turn = |now: Quat, then: Quat| (now * then.conjugate()).to_rotation_vector();
        Self {
            then: [then_a, then_b],
            offset: b.center - a.center,
            turn_a: turn(a.rotation, then_a),
            turn_b: turn(b.rotation, then_b),
        }
    }

    /// Current separation of a contact with a round shape, whose surface does not turn with it. It
    /// is first order in the rotation, since the solver's rows are linear in it too.
    fn apart(&self, c: &Contact, p: &Point) -> f32 {
        let r_b = c.r_b(p);
        let between = self.offset + (r_b - p.r_a);
        let turned = self.turn_b.cross(r_b) - self.turn_a.cross(p.r_a);
        p.base + c.normal.dot(between + turned)
    }
}
