//! Attachments: solves particles held by bodies, one row at a time.
//!
//! Symbols: w = 1/m of the particle; α, S, v̂, ŵ of the body as in the solver's rows; r the arm
//! from the body's center, which turns with the body.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use super::pace::{Form, Pace};
use crate::base::math::{Vec3, vec3};
use crate::base::sym3::Sym3;
use crate::base::threads::disjoint::{Apart, ReadRows, Rows};
use crate::state::particles::ParticleState;
use crate::step::context::caps::SHORTEST_OF_PARTICLES;
use crate::step::solver_body::{SolverBody, Whitening, three};

/// Part of the gap of an attachment that a substep removes.
const CLOSE: f32 = 0.8;

/// The body that a particle acts on.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Partner {
    /// Row of the body in the solver; 0: it cannot be pushed.
    pub(crate) solver_row: u32,
    alpha: f32,
    s: Sym3,
}

impl Partner {
    pub(crate) fn new(solver_row: u32, whitening: &ReadRows<'_, Whitening>) -> Self {
        if solver_row == 0 {
            return Self::default();
        }
        let whitening = whitening.read(solver_row as usize);
        Self { solver_row, alpha: whitening.alpha(), s: whitening.s() }
    }

    /// Velocity of its point at `r`.
    fn velocity(&self, solver_bodies: &ReadRows<'_, SolverBody>, r: Vec3) -> Vec3 {
        if self.solver_row == 0 {
            return Vec3::ZERO;
        }
        let solver_body = solver_bodies.read(self.solver_row as usize);
        three(solver_body.v) * self.alpha + self.s.mul(three(solver_body.w)).cross(r)
    }

    /// Displacement of its center, and its rotation, since the step's start.
    fn motion(&self, solver_bodies: &ReadRows<'_, SolverBody>) -> (Vec3, Vec3) {
        if self.solver_row == 0 {
            return (Vec3::ZERO, Vec3::ZERO);
        }
        let solver_body = solver_bodies.read(self.solver_row as usize);
        (three(solver_body.x) * self.alpha, self.s.mul(three(solver_body.t)))
    }

    /// Applies an impulse `p`, and `torque` about the center.
    fn push(&self, solver_bodies: &Rows<'_, SolverBody>, p: Vec3, torque: Vec3) {
        if self.solver_row == 0 {
            return;
        }
        let solver_body = solver_bodies.row(self.solver_row as usize);
        let (v, w) = (p * self.alpha, self.s.mul(torque));
        for (i, (dv, dw)) in v.to_array().into_iter().zip(w.to_array()).enumerate() {
            solver_body.v[i] += dv;
            solver_body.w[i] += dw;
        }
    }
}

/// Rows that a sweep writes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground<'a> {
    pub(crate) pace: &'a Pace,
    pub(crate) particles: Rows<'a, ParticleState>,
    /// Displacements at the substep's start, for the form that keeps positions.
    pub(crate) before: Rows<'a, [f32; 4]>,
    pub(crate) bodies: Rows<'a, SolverBody>,
    /// Time by which positions have advanced in the step [s].
    pub(crate) elapsed: f32,
}

impl<'a> Ground<'a> {
    pub(crate) fn new(
        pace: &'a Pace,
        particles: &'a mut [ParticleState],
        before: &'a mut [[f32; 4]],
        bodies: Rows<'a, SolverBody>,
        elapsed: f32,
    ) -> Self {
        // SAFETY: parallel passes go by colors, whose rows share no particle, and no body that can
        // be pushed.
        let apart = unsafe { Apart::promise() };
        let (particles, before) = (Rows::new(particles, apart), Rows::new(before, apart));
        Self { pace, particles, before, bodies, elapsed }
    }

    /// Velocity of a particle, and its predicted displacement at the substep's end (in the soft
    /// form the present one).
    #[inline]
    fn state(&self, solver_row: u32) -> (Vec3, Vec3) {
        let p = self.particles.read(solver_row as usize);
        match self.pace.form {
            Form::Soft => (p.velocity(), p.displacement()),
            Form::Aim => (p.velocity(), p.displacement() + p.velocity() * self.pace.h),
            Form::Verlet => {
                let before = three(*self.before.read(solver_row as usize));
                ((p.displacement() - before) * self.pace.inv_h, p.displacement())
            }
        }
    }

    /// Changes a particle's velocity.
    #[inline]
    fn kick(&self, solver_row: u32, dv: Vec3) {
        let p = self.particles.row(solver_row as usize);
        let (to, scale) = match self.pace.form {
            Form::Verlet => (&mut p.x, self.pace.h),
            _ => (&mut p.v, 1.0),
        };
        for (i, d) in dv.to_array().into_iter().enumerate() {
            to[i] += d * scale;
        }
    }

    /// Factor of the last substep's impulse on the particle, to apply to the body so that both
    /// carry the part that the row keeps.
    pub(crate) const fn repeat(&self) -> f32 {
        if self.pace.bodies_repeat { 1.0 - self.pace.keep } else { -self.pace.keep }
    }

    /// Displacement of a body at the time of [`Self::state`].
    fn ahead(&self, partner: &Partner) -> (Vec3, Vec3) {
        let (x, t) = partner.motion(&self.bodies);
        if partner.solver_row == 0 || self.pace.form == Form::Soft {
            return (x, t);
        }
        let solver_body = self.bodies.read(partner.solver_row as usize);
        let (v, w) = (three(solver_body.v) * partner.alpha, partner.s.mul(three(solver_body.w)));
        (x + v * self.pace.h, t + w * self.pace.h)
    }
}

/// A particle held at a point of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HoldRow {
    pub(crate) solver_row: u32,
    pub(crate) number: u32,
    partner: Partner,
    /// Arm from the body's center to the anchor, at the step's start and when the impulse was
    /// applied.
    r0: Vec3,
    r: Vec3,
    /// Position of the particle minus that of the anchor, at the step's start [m].
    gap: Vec3,
    drift: Vec3,
    w: f32,
    /// Impulse on the particle in a substep [N s].
    pub(crate) impulse: Vec3,
    /// Sum of the impulse over substeps, beside a classic method.
    pub(crate) total: Vec3,
}

impl HoldRow {
    pub(crate) fn new(
        (solver_row, number): (u32, u32),
        partner: Partner,
        [r, gap, drift, impulse]: [Vec3; 4],
        ground: &Ground<'_>,
    ) -> Self {
        let w = ground.particles.read(solver_row as usize).inverse_mass();
        let row = Self {
            solver_row,
            number,
            partner,
            r0: r,
            r,
            gap,
            drift,
            w,
            impulse,
            total: Vec3::ZERO,
        };
        row.apply(ground, impulse, r.cross(impulse));
        row
    }

    fn apply(&self, ground: &Ground<'_>, p: Vec3, torque: Vec3) {
        ground.kick(self.solver_row, p * self.w);
        self.partner.push(&ground.bodies, -p, -torque);
    }

    pub(crate) fn solve(&mut self, ground: &Ground<'_>, is_relax: bool, first: bool) {
        let pace = ground.pace;
        let soft = pace.form == Form::Soft;
        if first {
            let back = self.impulse * ground.repeat();
            self.partner.push(&ground.bodies, back, self.r.cross(back));
            self.impulse *= pace.keep;
        }
        let (_, displacement) = ground.state(self.solver_row);
        let (x, t) = ground.ahead(&self.partner);
        let once = t.cross(self.r0);
        let r = self.r0 + once + t.cross(once) * 0.5;
        let time = if soft { ground.elapsed } else { ground.elapsed + pace.h };
        let gap = self.gap + displacement - x - (r - self.r0) - self.drift * time;
        if !is_relax {
            // The body carries the impulse at the earlier arm: see the joint kernels.
            self.partner.push(&ground.bodies, Vec3::ZERO, -(r - self.r).cross(self.impulse));
            self.r = r;
        }
        let (v, _) = ground.state(self.solver_row);
        let u = v - self.partner.velocity(&ground.bodies, r) - self.drift;
        let inv_h = pace.inv_h.min(1.0 / SHORTEST_OF_PARTICLES);
        let wanted = if !soft {
            // The gap is that after the substep, with the relative motion in it. That motion is no
            // error: the next sweep must not close again what this one closes.
            let close = |gap: f32, u: f32| {
                let moves = u * (pace.h * inv_h);
                let (speed, open) = (gap * inv_h, gap - u * pace.h);
                let maximum = pace.caps.fastest_row(open, false);
                if (speed - moves).abs() <= maximum {
                    speed
                } else {
                    moves + maximum.copysign(open)
                }
            };
            vec3(close(gap.x, u.x), close(gap.y, u.y), close(gap.z, u.z))
        } else if is_relax {
            u
        } else {
            let close = |gap: f32| pace.caps.closing_row(gap * (CLOSE * inv_h), gap, false);
            u + vec3(close(gap.x), close(gap.y), close(gap.z))
        };
        let d = -self.matrix(r).map_or(Vec3::ZERO, |m| m.mul(wanted));
        self.apply(ground, d, r.cross(d));
        self.impulse += d;
    }

    /// Reduction of the particle's response to an impulse by the body: B = w² A, where A is the
    /// inverse of an impulse's effect on the relative velocity of the two.
    pub(crate) fn less(&self) -> Sym3 {
        let Some(a) = self.matrix(self.r) else { return Sym3::ZERO };
        a.scaled(self.w * self.w)
    }

    /// Applies to the body its part of an impulse on the particle, which has received its own part.
    pub(crate) fn hand_on(&mut self, solver_bodies: &Rows<'_, SolverBody>, p: Vec3) {
        let d = -self.matrix(self.r).map_or(Vec3::ZERO, |a| a.mul(p * self.w));
        self.partner.push(solver_bodies, -d, -self.r.cross(d));
        self.impulse += d;
    }

    /// Inverse of an impulse's effect on the relative velocity of the two.
    fn matrix(&self, r: Vec3) -> Option<Sym3> {
        let k = self.w + self.partner.alpha * self.partner.alpha;
        let (x, y, z) = (
            self.partner.s.mul(vec3(0.0, r.z, -r.y)),
            self.partner.s.mul(vec3(-r.z, 0.0, r.x)),
            self.partner.s.mul(vec3(r.y, -r.x, 0.0)),
        );
        let turn = Sym3 {
            xx: x.dot(x),
            yy: y.dot(y),
            zz: z.dot(z),
            xy: x.dot(y),
            xz: x.dot(z),
            yz: y.dot(z),
        };
        turn.plus(Sym3::diagonal(Vec3::splat(k))).inverse()
    }
}
