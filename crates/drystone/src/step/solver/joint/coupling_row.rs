//! The rows of couplings and pulleys. A coupling is one row over the bodies of two joints, up to
//! four. A pulley is one row over two bodies and fixed points.
//!
//! Few scenes have any, and their bodies are more than the two of a block. So one worker of the
//! group solves them one by one, in the order of their rows, before the joints through which they
//! act.
//!
//! Symbols: x are the coordinates, C = x_b - ratio x_a - offset, J its row, λ its impulse.
//! Coordinates advance from the step's start, and the warm start is mapped to the current rows, as
//! for joints: see six_dof/kernel.rs and ball_distance.rs.

use super::sweep::JointSweep;
use crate::base::id::JointId;
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;
use crate::base::threads::disjoint::{ReadRows, Rows};
use crate::state::bodies::Bodies;
use crate::state::bodies::body::Body;
use crate::state::coupling::{Coupling, CouplingDef, coordinate};
use crate::state::def::Pulley;
use crate::state::joints::{Joint, JointModel};
use crate::step::solver::vec6;
use crate::step::solver_body::SolverBody;

/// A row's part for one body: v̂ and ŵ.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Part {
    pub(crate) solver_row: usize,
    pub(crate) v: Vec3,
    pub(crate) w: Vec3,
}

/// A coordinate of a joint at the step's start.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct End {
    solver_rows: [usize; 2],
    /// α and S of both bodies.
    alpha: [f32; 2],
    s: [Sym3; 2],
    /// Lever arms.
    r: [Vec3; 2],
    gap: Vec3,
    /// Axis [world].
    axis: Vec3,
    is_turn: bool,
    /// Coordinate of a translation.
    start: f32,
    /// Derivative of C by the coordinate.
    factor: f32,
    /// Velocities of kinematic bodies: B's less A's, and angular velocities.
    drift: Vec3,
    spin: [Vec3; 2],
}

/// A pulley's rope at the step's start.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rope {
    solver_rows: [usize; 2],
    alpha: [f32; 2],
    s: [Sym3; 2],
    /// Lever arms.
    r: [Vec3; 2],
    /// Anchors less the fixed points of the rope.
    displacement: [Vec3; 2],
    /// Derivative of C by each length.
    factor: [f32; 2],
    /// Velocities of kinematic bodies' anchors, and angular velocities.
    drift: [Vec3; 2],
    spin: [Vec3; 2],
}

/// Constraint of a row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) enum Source {
    #[default]
    Nothing,
    Joints([End; 2]),
    Rope(Rope),
}

/// A coupling or pulley in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CouplingRow {
    pub(crate) source: Source,
    /// C at the step's start; for a rope, less its length.
    pub(crate) c: f32,
    /// The row only pulls: λ is at most 0.
    pub(crate) is_slack: bool,
    pub(crate) impulse: f32,
    /// The part of the warm start that the bodies carry.
    pub(crate) carried: [Part; 4],
}

/// C, its rate by kinematic bodies, and J, with the parts of one body merged.
pub(crate) struct Now {
    pub(crate) c: f32,
    drift: f32,
    pub(crate) parts: [Part; 4],
}

fn vector(four: [f32; 4]) -> Vec3 {
    Vec3::from([four[0], four[1], four[2]])
}

/// Displacement of `r` by the rotation vector `t`, up to 2.8 rad.
fn shift(r: Vec3, t: Vec3) -> Vec3 {
    vec6::shift(t.into(), r.into()).single()
}

impl End {
    /// Change of the coordinate since the step's start, its rate by kinematic bodies, and its row.
    fn now(&self, motion: impl Fn(usize) -> [Vec3; 2], elapsed: f32) -> (f32, f32, [Part; 2]) {
        let moved = |i: usize| {
            let [x, t] = motion(self.solver_rows[i]);
            (x * self.alpha[i], self.s[i].mul(t) + self.spin[i] * elapsed)
        };
        let ((shift_a, turn_a), (shift_b, turn_b)) = (moved(0), moved(1));
        let axis = self.axis + shift(self.axis, turn_a);
        let part = |i: usize, v: Vec3, w: Vec3| Part {
            solver_row: self.solver_rows[i],
            v: v * self.factor,
            w: w * self.factor,
        };
        if self.is_turn {
            let turn = turn_b - turn_a - turn_a.cross(turn_b) * 0.5;
            let x = self.axis.dot(turn);
            let drift = axis.dot(self.spin[1] - self.spin[0]);
            let parts = [
                part(0, Vec3::ZERO, -self.s[0].mul(axis)),
                part(1, Vec3::ZERO, self.s[1].mul(axis)),
            ];
            return (x, drift, parts);
        }
        let (turn_a, turn_b) = (shift(self.r[0], turn_a), shift(self.r[1], turn_b));
        let (ra, rb) = (self.r[0] + turn_a, self.r[1] + turn_b);
        let gap = self.gap + (shift_b - shift_a + self.drift * elapsed) + (turn_b - turn_a);
        let arm = ra + gap;
        let drift = self.drift + self.spin[1].cross(rb) - self.spin[0].cross(arm);
        let parts = [
            part(0, -axis * self.alpha[0], -self.s[0].mul(arm.cross(axis))),
            part(1, axis * self.alpha[1], self.s[1].mul(rb.cross(axis))),
        ];
        (axis.dot(gap) - self.start, axis.dot(drift), parts)
    }
}

impl Rope {
    fn add(&self, now: &mut Now, motion: impl Fn(usize) -> [Vec3; 2], elapsed: f32) {
        for i in 0..2 {
            let [x, t] = motion(self.solver_rows[i]);
            let turn = self.s[i].mul(t) + self.spin[i] * elapsed;
            let turned = shift(self.r[i], turn);
            let r = self.r[i] + turned;
            let moved = x * self.alpha[i] + self.drift[i] * elapsed + turned;
            let displacement = self.displacement[i] + moved;
            let length = displacement.length();
            // At the fixed point itself the rope has no direction and exerts no force.
            let along = if length > 1.0e-9 { displacement * (1.0 / length) } else { Vec3::ZERO };
            let along = along * self.factor[i];
            now.c += self.factor[i] * length;
            now.drift += along.dot(self.drift[i] + self.spin[i].cross(r));
            let (v, w) = (along * self.alpha[i], self.s[i].mul(r.cross(along)));
            now.parts[i] = Part { solver_row: self.solver_rows[i], v, w };
        }
    }
}

impl Source {
    /// True if C is an angle: it has the unit of the second joint's coordinate.
    pub(crate) const fn is_turn(&self) -> bool {
        matches!(self, Self::Joints([_, second]) if second.is_turn)
    }

    /// The constraint after the bodies' `motion` since the step's start; `c` is C at that time.
    pub(crate) fn now(&self, c: f32, motion: impl Fn(usize) -> [Vec3; 2], elapsed: f32) -> Now {
        let mut now = Now { c, drift: 0.0, parts: [Part::default(); 4] };
        let ends = match self {
            Self::Nothing => return now,
            Self::Joints(ends) => ends,
            Self::Rope(rope) => {
                rope.add(&mut now, motion, elapsed);
                return now;
            }
        };
        for (i, end) in ends.iter().enumerate() {
            let (x, drift, parts) = end.now(&motion, elapsed);
            now.c += end.factor * x;
            now.drift += end.factor * drift;
            for (j, part) in parts.into_iter().enumerate() {
                let before =
                    now.parts[..2 * i].iter().position(|p| p.solver_row == part.solver_row);
                match before {
                    _ if part.solver_row == 0 => {}
                    Some(k) => {
                        now.parts[k].v += part.v;
                        now.parts[k].w += part.w;
                    }
                    None => now.parts[2 * i + j] = part,
                }
            }
        }
        now
    }
}

impl CouplingRow {
    pub(crate) fn now(&self, solver_bodies: &ReadRows<'_, SolverBody>, sweep: &JointSweep) -> Now {
        let back = if sweep.is_relax { sweep.back } else { 0.0 };
        let motion = |solver_row: usize| {
            let solver_body = solver_bodies.read(solver_row);
            [
                vector(solver_body.x) - vector(solver_body.v) * back,
                vector(solver_body.t) - vector(solver_body.w) * back,
            ]
        };
        self.source.now(self.c, motion, sweep.elapsed)
    }

    pub(crate) fn solve(&mut self, solver_bodies: &Rows<'_, SolverBody>, sweep: &JointSweep) {
        let now = self.now(solver_bodies, sweep);
        let old = self.impulse;
        if !sweep.is_relax {
            for (part, carried) in now.parts.iter().zip(&self.carried) {
                push(
                    solver_bodies,
                    part.solver_row,
                    part.v * old - carried.v,
                    part.w * old - carried.w,
                );
            }
        }
        let (mut k, mut speed) = (0.0, now.drift);
        for part in now.parts.iter().filter(|p| p.solver_row != 0) {
            let solver_body = solver_bodies.read(part.solver_row);
            k += part.v.length_squared() + part.w.length_squared();
            speed += part.v.dot(vector(solver_body.v)) + part.w.dot(vector(solver_body.w));
        }
        if !(k > 0.0) {
            return;
        }
        let s = &sweep.softness;
        // A slack rope lets its ends separate until it is taut.
        let is_open = self.is_slack && now.c < 0.0;
        let (gain, bias, give) = if is_open {
            (1.0, now.c * sweep.inv_h, 0.0)
        } else {
            (
                s.mass,
                sweep.caps.closing_row(s.rate * now.c, now.c, self.source.is_turn()),
                s.impulse,
            )
        };
        let new = old - (gain * speed + bias) / k - give * old;
        let new = if self.is_slack { new.min(0.0) } else { new };
        let d = new - old;
        self.impulse = new;
        for (part, carried) in now.parts.iter().zip(&mut self.carried) {
            push(solver_bodies, part.solver_row, part.v * d, part.w * d);
            let (v, w) = if sweep.is_relax {
                (carried.v + part.v * d, carried.w + part.w * d)
            } else {
                (part.v * self.impulse, part.w * self.impulse)
            };
            *carried = Part { solver_row: part.solver_row, v, w };
        }
    }
}

/// Adds to a solver body's velocity. Solver body 0 is shared and never written.
pub(crate) fn push(solver_bodies: &Rows<'_, SolverBody>, solver_row: usize, v: Vec3, w: Vec3) {
    if solver_row == 0 {
        return;
    }
    let solver_body = solver_bodies.row(solver_row);
    for (i, (v, w)) in v.to_array().into_iter().zip(w.to_array()).enumerate() {
        solver_body.v[i] += v;
        solver_body.w[i] += w;
    }
}

impl CouplingRow {
    /// The solver bodies that the row acts on.
    pub(crate) fn solver_rows(&self) -> impl Iterator<Item = usize> + '_ {
        self.carried.iter().map(|part| part.solver_row).filter(|solver_row| *solver_row != 0)
    }

    /// The impulse of this sweep, the speed at which it closed, and the rate of C by kinematic
    /// bodies.
    pub(crate) fn pushed(
        &self,
        solver_bodies: &ReadRows<'_, SolverBody>,
        sweep: &JointSweep,
    ) -> [f32; 3] {
        let now = self.now(solver_bodies, sweep);
        let speed = sweep.softness.rate * now.c;
        let closed = sweep.caps.closing_row(speed, now.c, self.source.is_turn());
        [self.impulse, closed, now.drift]
    }

    /// Scales its impulse by `part`.
    pub(crate) fn restrain(&mut self, part: f32) {
        if !(part > 0.0) {
            self.impulse = 0.0;
            self.carried.iter_mut().for_each(|at| (at.v, at.w) = (Vec3::ZERO, Vec3::ZERO));
            return;
        }
        self.impulse *= part;
        for carried in &mut self.carried {
            (carried.v, carried.w) = (carried.v * part, carried.w * part);
        }
    }
}

/// A coupling or pulley at the step's start: C (for a rope, less its length), and the last impulse.
pub(crate) struct Start {
    pub(crate) source: Source,
    pub(crate) c: f32,
    pub(crate) is_slack: bool,
    pub(crate) impulse: f32,
}

impl Start {
    /// `None` for other joints. `look` finds a joint; `mass` gives a body's solver body, α and S.
    pub(crate) fn new<'a>(
        joint: &Joint,
        look: impl Fn(JointId) -> Option<&'a Joint>,
        bodies: &Bodies,
        mass: impl Fn(u32) -> (usize, f32, Sym3),
    ) -> Option<Self> {
        match &joint.model {
            JointModel::Coupling(coupling) => {
                let Coupling { def, impulse } = coupling.as_ref();
                let CouplingDef { joint_a, axis_a, joint_b, axis_b, ratio, .. } = *def;
                let (a, x_a) = End::new(look(joint_a)?, axis_a.index(), -ratio, bodies, &mass)?;
                let (b, x_b) = End::new(look(joint_b)?, axis_b.index(), 1.0, bodies, &mass)?;
                let (source, c) = (Source::Joints([a, b]), def.excess(x_a, x_b));
                Some(Self { source, c, is_slack: false, impulse: *impulse })
            }
            JointModel::Pulley(pulley) => Some(Self {
                source: Source::Rope(Rope::new(joint, pulley, bodies, mass)),
                c: -pulley.length,
                is_slack: !pulley.is_rigid,
                impulse: joint.impulse.x,
            }),
            _ => None,
        }
    }
}

/// Velocities of a moving kinematic body; zero for others.
fn driven(body: &Body) -> [Vec3; 2] {
    let is_moved = !body.is_dynamic() && body.active();
    if is_moved { [body.v, body.w] } else { [Vec3::ZERO; 2] }
}

impl Rope {
    fn new(
        joint: &Joint,
        pulley: &Pulley,
        bodies: &Bodies,
        mass: impl Fn(u32) -> (usize, f32, Sym3),
    ) -> Self {
        let of = [joint.body_a, joint.body_b];
        let masses = of.map(mass);
        let bodies = of.map(|row| bodies.at(row));
        let anchors = [joint.anchor_a, joint.anchor_b];
        let r = [0, 1].map(|i| bodies[i].rotation.rotate(anchors[i]));
        Self {
            solver_rows: masses.map(|(solver_row, ..)| solver_row),
            alpha: masses.map(|(_, alpha, _)| alpha),
            s: masses.map(|(.., s)| s),
            r,
            displacement: [0, 1].map(|i| bodies[i].center + r[i] - pulley.points[i]),
            factor: [1.0, pulley.ratio],
            drift: bodies.map(|body| driven(body)[0]),
            spin: bodies.map(|body| driven(body)[1]),
        }
    }
}

impl End {
    /// The coordinate of a joint that a coupling names, and its value.
    fn new(
        joint: &Joint,
        axis: usize,
        factor: f32,
        bodies: &Bodies,
        mass: &impl Fn(u32) -> (usize, f32, Sym3),
    ) -> Option<(Self, f64)> {
        let JointModel::SixDof(six_dof) = &joint.model else { return None };
        let of = [joint.body_a, joint.body_b];
        let masses = of.map(mass);
        let [a, b] = of.map(|row| bodies.at(row));
        let r = [a.rotation.rotate(joint.anchor_a), b.rotation.rotate(joint.anchor_b)];
        let axes = (a.rotation * six_dof.def.frame_a).to_mat3();
        let turns = six_dof.joint_angles(a.rotation, b.rotation);
        let is_turn = axis > 2;
        let direction = if is_turn { turns.rows[axis - 3] } else { [axes.x, axes.y, axes.z][axis] };
        let gap = (b.center - a.center) + (r[1] - r[0]);
        let x = coordinate(joint, six_dof, bodies, axis);
        let ([v_a, w_a], [v_b, w_b]) = (driven(a), driven(b));
        let end = Self {
            solver_rows: masses.map(|(solver_row, ..)| solver_row),
            alpha: masses.map(|(_, alpha, _)| alpha),
            s: masses.map(|(.., s)| s),
            r,
            gap,
            axis: direction,
            is_turn,
            start: if is_turn { 0.0 } else { direction.dot(gap) },
            factor,
            drift: v_b - v_a,
            spin: [w_a, w_b],
        };
        Some((end, x))
    }
}
