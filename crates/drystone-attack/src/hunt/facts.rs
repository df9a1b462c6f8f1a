//! Properties that a program guarantees, derived from its operations alone.

use std::collections::{BTreeMap, BTreeSet};

use drystone::joint::{JointDrive, JointMotion};
use drystone::{BodyKind, JointKind, Quat, Shape, Vec3};

use super::floors::{FIRST_BODY, half_of};
use super::measures::{Measures, measures, support};
use crate::apply;
use crate::op::{BodyCall, BodyPlan, JointPlan, Label, Op, Program};

/// A body in its initial state.
#[derive(Clone, Debug)]
pub(super) struct Made {
    pub(super) kind: BodyKind,
    pub(super) position: Vec3,
    pub(super) rotation: Quat,
    pub(super) linear_velocity: Vec3,
    pub(super) angular_velocity: Vec3,
    /// Its shapes are upright as drawn, except for a rotation about the vertical.
    pub(super) is_upright: bool,
    /// Measures of its shape, if that is a single convex one.
    pub(super) single: Option<Measures>,
    /// Half the maximum length and half the minimum thickness of its shapes [m].
    pub(super) large: f32,
    pub(super) thin: f32,
    /// Distances from its origin to its highest and lowest points [m].
    pub(super) up: f32,
    pub(super) down: f32,
    /// It can roll without resistance.
    pub(super) rolls: bool,
    pub(super) belt: f32,
}

/// Properties that a program guarantees.
#[derive(Clone, Debug, Default)]
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
pub(super) struct Facts {
    pub(super) bodies: BTreeMap<Label, Made>,
    /// Downward [m/s²].
    pub(super) gravity: f32,
    pub(super) half_floor: Option<f32>,
    pub(super) has_drives: bool,
    pub(super) has_carriers: bool,
    pub(super) has_belts: bool,
    /// Bodies are pushed, moved, added or removed after the first step.
    pub(super) has_calls: bool,
    pub(super) has_fixed: bool,
    pub(super) restitution: f32,
    pub(super) least_friction: f32,
    pub(super) most_friction: f32,
    /// Bodies with joints.
    pub(super) jointed: BTreeSet<Label>,
    pub(super) pairs: BTreeSet<(Label, Label)>,
    /// Some joint connects to a static or kinematic body, or has a spring.
    pub(super) hangs: bool,
    /// One or several stacks that start at rest and must stay.
    pub(super) stands: bool,
    /// Blocks that fall upright onto each other or the floor.
    pub(super) lands_flat: bool,
    /// The one body that slides without friction.
    pub(super) glider: Option<Label>,
    /// The one body that slides with friction.
    pub(super) slider: Option<Label>,
    /// The length of all steps, if equal [s].
    pub(super) even_dt: Option<f32>,
}

/// Maximum tilt of a block that lies flat on the floor [component of a unit vector].
const UPRIGHT: f32 = 1.0e-5;

impl Facts {
    pub(super) fn of(program: &Program) -> Self {
        let mut facts = Self {
            gravity: -program.config.gravity.y,
            half_floor: half_of(program),
            least_friction: f32::INFINITY,
            ..Self::default()
        };
        let mut has_stepped = false;
        let mut lengths = BTreeSet::new();
        for op in &program.ops {
            match op {
                Op::AddBody(plan) => {
                    facts.has_calls |= has_stepped;
                    facts.add_body(plan);
                }
                Op::AddJoint(plan) => facts.add_joint(plan),
                Op::Step(dt, _) => {
                    has_stepped = true;
                    lengths.insert(dt.to_bits());
                }
                Op::Body(_, BodyCall::Wake) | Op::WakeAll => {}
                Op::Body(label, BodyCall::LinearVelocity(_))
                    if facts.bodies.get(label).is_some_and(|b| b.kind == BodyKind::Kinematic) =>
                {
                    facts.has_carriers = true;
                    facts.has_calls = true;
                }
                _ => facts.has_calls = true,
            }
        }
        if lengths.len() == 1 {
            facts.even_dt = lengths.first().map(|bits| f32::from_bits(*bits));
        }
        facts.promise();
        facts
    }

    fn add_body(&mut self, plan: &BodyPlan) {
        let def = &plan.def;
        let shapes: Vec<(Shape, Vec3, Quat)> = plan
            .shapes
            .iter()
            .filter(|p| !p.def.sensor)
            .filter_map(|p| {
                Some((apply::shape(&p.form)?, p.def.pose.position, p.def.pose.rotation))
            })
            .collect();
        let convex: Vec<Measures> = shapes.iter().filter_map(|(s, ..)| measures(s)).collect();
        let reach = |along: Vec3| {
            let d = def.rotation.unrotate(along);
            let of = |(shape, at, turn): &(Shape, Vec3, Quat)| {
                at.dot(d) + support(shape, turn.unrotate(d))
            };
            shapes.iter().map(of).fold(0.0, f32::max)
        };
        let is_convex = convex.len() == shapes.len() && convex.len() == 1;
        let up = def.rotation.rotate(Vec3::Y);
        let surface = |p: &crate::op::ShapePlan| p.def.material;
        let resists = plan.shapes.iter().all(|p| surface(p).rolling_resistance >= 0.01);
        let belt = plan.shapes.iter().map(|p| p.def.surface_velocity.length()).fold(0.0, f32::max);
        let made = Made {
            kind: def.kind,
            position: def.position,
            rotation: def.rotation,
            linear_velocity: def.linear_velocity,
            angular_velocity: def.angular_velocity,
            is_upright: (up - Vec3::Y).length() < UPRIGHT,
            single: convex.first().copied().filter(|_| is_convex),
            large: convex.iter().map(|m| m.large).fold(0.0, f32::max),
            thin: convex.iter().map(|m| m.thin).fold(f32::INFINITY, f32::min),
            up: reach(Vec3::Y),
            down: reach(-Vec3::Y),
            rolls: convex.iter().any(|m| m.rolls) && !resists,
            belt,
        };
        for material in plan.shapes.iter().map(surface) {
            self.restitution = self.restitution.max(material.restitution);
            self.least_friction = self.least_friction.min(material.friction);
            self.most_friction = self.most_friction.max(material.friction);
        }
        self.has_fixed |= def.kind != BodyKind::Dynamic && !shapes.is_empty();
        let moves = def.linear_velocity != Vec3::ZERO || def.angular_velocity != Vec3::ZERO;
        self.has_carriers |= def.kind == BodyKind::Kinematic && moves;
        self.has_belts |= belt > 0.0;
        self.bodies.insert(plan.label, made);
    }

    fn add_joint(&mut self, plan: &JointPlan) {
        self.jointed.extend(plan.bodies);
        let [a, b] = plan.bodies;
        if !plan.collide_connected {
            self.pairs.insert((a.min(b), a.max(b)));
        }
        let kind = |label: &Label| self.bodies.get(label).map(|body| body.kind);
        self.hangs |= plan.bodies.iter().any(|b| kind(b) != Some(BodyKind::Dynamic));
        if let JointKind::SixDof(axes) = plan.kind {
            let drives = axes.linear.iter().chain(&axes.angular).filter_map(|axis| axis.drive);
            self.has_drives |= drives.clone().any(|d| is_motor(&d));
            self.hangs |=
                axes.linear.iter().chain(&axes.angular).any(|axis| {
                    matches!(axis.motion, JointMotion::Limited { spring: Some(_), .. })
                });
        }
    }

    fn is_dynamic(made: &Made) -> bool {
        made.kind == BodyKind::Dynamic
    }

    /// Bodies that forces move and that do not belong to the floor.
    pub(super) fn movers(&self) -> impl Iterator<Item = (Label, &Made)> {
        let all =
            self.bodies.iter().filter(|(l, made)| **l >= FIRST_BODY && Self::is_dynamic(made));
        all.map(|(label, made)| (*label, made))
    }

    /// The only sources of energy are gravity, calls, and springs with counted energy.
    pub(super) fn is_closed(&self) -> bool {
        !self.has_carriers && !self.has_belts
    }

    /// Everything must come to rest at the end: it lies on a floor with friction, nothing moves it,
    /// and nothing swings or rolls without resistance.
    pub(super) fn must_rest(&self) -> bool {
        let is_driven = self.has_drives || self.has_carriers || self.has_belts;
        let rolls = self.movers().any(|(_, made)| made.rolls);
        let slides = self.least_friction < 0.25;
        self.half_floor.is_some()
            && self.gravity > 0.0
            && !is_driven
            && !rolls
            && !slides
            && !self.hangs
    }

    fn promise(&mut self) {
        let floor = self.half_floor.unwrap_or(0.0);
        let is_plain = self.jointed.is_empty() && !self.has_calls && self.is_closed();
        if !is_plain || self.gravity <= 0.0 || floor <= 0.0 || self.restitution > 0.0 {
            return;
        }
        let movers: Vec<(Label, Made)> = self.movers().map(|(l, m)| (l, m.clone())).collect();
        let over = |m: &Made| {
            let at = m.position;
            at.x.abs().max(at.z.abs()) + 2.0 * m.large < floor
        };
        let is_block = |m: &Made| {
            m.is_upright && m.single.is_some() && over(m) && m.angular_velocity == Vec3::ZERO
        };
        if movers.is_empty() || !movers.iter().all(|(_, m)| is_block(m)) {
            return;
        }
        if let [(label, body)] = movers.as_slice() {
            let gap = body.position.y - body.down;
            let is_level =
                body.linear_velocity.y.abs() < 1.0e-6 && body.linear_velocity != Vec3::ZERO;
            if is_level && gap.abs() < 1.0e-4 * body.large {
                if self.most_friction < 1.0e-6 {
                    self.glider = Some(*label);
                } else {
                    self.slider = Some(*label);
                }
            }
        }
        let falls = movers.iter().all(|(_, m)| m.linear_velocity == Vec3::ZERO && !m.rolls_over());
        if !falls || self.least_friction < 0.25 {
            return;
        }
        let Some(gap) = columns(&movers) else { return };
        self.lands_flat = true;
        let thin = movers.iter().map(|(_, m)| m.thin).fold(f32::INFINITY, f32::min);
        self.stands = gap <= 1.0e-3 * thin;
    }
}

impl Made {
    /// Whether the body cannot stand, because it touches the floor in less than a face.
    fn rolls_over(&self) -> bool {
        // A ball, a capsule, a cone on its tip: the highest and lowest points belong to no face.
        // Only shapes whose whole foot is a face are drawn upright: boxes, cylinders, prisms.
        self.single.is_none_or(|m| m.core.y < 0.99 * self.down && m.core.y > 0.0 && m.rolls)
    }
}

/// Whether a drive is a motor, with a target speed; holding springs are not.
pub(super) fn is_motor(drive: &JointDrive) -> bool {
    drive.velocity.abs() > 0.0
}

/// The maximum gap under any block, if the blocks form columns; otherwise `None`. In a column each
/// block stands, or will stand, on the floor or with its middle well over one other block.
fn columns(movers: &[(Label, Made)]) -> Option<f32> {
    let mut sorted: Vec<&Made> = movers.iter().map(|(_, m)| m).collect();
    sorted.sort_by(|a, b| a.position.y.total_cmp(&b.position.y));
    let mut most = 0.0_f32;
    for (i, body) in sorted.iter().enumerate() {
        let low = body.position.y - body.down;
        let mut ground = 0.0;
        for under in &sorted[..i] {
            let (a, b) = (body.single?, under.single?);
            let off = (body.position - under.position).abs();
            let (near, far) = (a.core + b.core, b.core * 0.5);
            let apart = off.x > near.x.max(near.z) * 1.5 || off.z > near.x.max(near.z) * 1.5;
            if apart {
                continue;
            }
            // Within half of the lower block's foot, whose width is at least half of the upper
            // block's.
            let holds = off.x.max(off.z) <= far.x.min(far.z)
                && b.core.x.min(b.core.z) > 0.5 * a.core.x.max(a.core.z);
            if !holds {
                return None;
            }
            ground = under.position.y + under.up;
        }
        let gap = low - ground;
        if gap < -1.0e-3 * body.thin {
            return None;
        }
        most = most.max(gap);
    }
    Some(most)
}
