//! Particles against shapes, and held by bodies, one row at a time.
//!
//! Symbols: w = 1/m of the particle; α, S, v̂, ŵ of the body as in the solver's rows; n the normal from the
//! body to the particle, r the arm from the body's center. Normals and arms of contacts are those of the
//! step's start; arms of attachments turn with the body.

use super::meet::Meeting;
use super::pace::{Form, Pace};
use crate::base::disjoint::Rows;
use crate::base::math::{Vec3, greater, vec3};
use crate::base::sym3::Sym3;
use crate::state::particles::ParticleLine;
use crate::step::solver::rows::{Line, Whitening};

/// Part of an overlap that a substep removes.
const PUSH_OUT: f32 = 0.2;

/// The same of the gap of an attachment.
const CLOSE: f32 = 0.8;

/// What a particle is against.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Partner {
    /// Line of the body in the solver; 0: it cannot be pushed.
    pub(crate) line: u32,
    alpha: f32,
    s: Sym3,
}

impl Partner {
    pub(crate) fn new(line: u32, whitening: &Rows<'_, Whitening>) -> Self {
        if line == 0 {
            return Self::default();
        }
        let whitening = whitening.read(line as usize);
        Self { line, alpha: whitening.alpha(), s: whitening.s() }
    }

    /// Velocity of its point at `r`.
    fn velocity(&self, lines: &Rows<'_, Line>, r: Vec3) -> Vec3 {
        if self.line == 0 {
            return Vec3::ZERO;
        }
        let line = lines.read(self.line as usize);
        three(line.v) * self.alpha + self.s.mul(three(line.w)).cross(r)
    }

    /// How far its center went since the step's start, and how it turned.
    fn motion(&self, lines: &Rows<'_, Line>) -> (Vec3, Vec3) {
        if self.line == 0 {
            return (Vec3::ZERO, Vec3::ZERO);
        }
        let line = lines.read(self.line as usize);
        (three(line.x) * self.alpha, self.s.mul(three(line.t)))
    }

    /// An impulse `p`, and `torque` about the center.
    fn push(&self, lines: &Rows<'_, Line>, p: Vec3, torque: Vec3) {
        if self.line == 0 {
            return;
        }
        let line = lines.row(self.line as usize);
        let (v, w) = (p * self.alpha, self.s.mul(torque));
        for (i, (dv, dw)) in v.to_array().into_iter().zip(w.to_array()).enumerate() {
            line.v[i] += dv;
            line.w[i] += dw;
        }
    }
}

const fn three(v: [f32; 4]) -> Vec3 {
    vec3(v[0], v[1], v[2])
}

/// The rows that a sweep writes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground<'a> {
    pub(crate) pace: &'a Pace,
    pub(crate) particles: Rows<'a, ParticleLine>,
    /// Ways at the substep's start, of the form that keeps positions.
    pub(crate) before: Rows<'a, [f32; 4]>,
    pub(crate) bodies: Rows<'a, Line>,
    /// Time of the step that positions have advanced [s].
    pub(crate) elapsed: f32,
}

impl Ground<'_> {
    /// Velocity of a particle, and its way at the substep's end as far as it is known.
    #[inline]
    fn state(&self, line: u32) -> (Vec3, Vec3) {
        let p = self.particles.read(line as usize);
        match self.pace.form {
            Form::Soft => (p.velocity(), p.way()),
            Form::Aim => (p.velocity(), p.way() + p.velocity() * self.pace.h),
            Form::Verlet => {
                let before = three(*self.before.read(line as usize));
                ((p.way() - before) * self.pace.inv_h, p.way())
            }
        }
    }

    /// Changes a particle's velocity.
    #[inline]
    fn kick(&self, line: u32, dv: Vec3) {
        let p = self.particles.row(line as usize);
        let (to, scale) = match self.pace.form {
            Form::Verlet => (&mut p.x, self.pace.h),
            _ => (&mut p.v, 1.0),
        };
        for (i, d) in dv.to_array().into_iter().enumerate() {
            to[i] += d * scale;
        }
    }

    /// What is to be given back to a body, for each impulse of the last substep on the particle, so that it has
    /// what the row keeps.
    const fn repeat(&self) -> f32 {
        if self.pace.bodies_repeat { 1.0 - self.pace.keep } else { -self.pace.keep }
    }

    /// Way of a body at the moment that [`Self::state`] tells of.
    fn ahead(&self, partner: &Partner) -> (Vec3, Vec3) {
        let (x, t) = partner.motion(&self.bodies);
        if partner.line == 0 || self.pace.form == Form::Soft {
            return (x, t);
        }
        let line = self.bodies.read(partner.line as usize);
        let (v, w) = (three(line.v) * partner.alpha, partner.s.mul(three(line.w)));
        (x + v * self.pace.h, t + w * self.pace.h)
    }
}

/// A particle against a shape. Along each of its directions d the body has the row (α d, a = S (r × d)) of the
/// whitened solver, so a sweep multiplies no matrix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointRow {
    pub(crate) line: u32,
    pub(crate) shape: u32,
    /// Line of the body in the solver; 0: it cannot be pushed.
    body: u32,
    alpha: f32,
    /// The normal, and two directions along the surface.
    axes: [Vec3; 3],
    /// S (r × d) of each.
    turns: [Vec3; 3],
    /// Velocity of the surface itself along each [m/s].
    drift: [f32; 3],
    separation: f32,
    w: f32,
    mass: f32,
    mass_slide: f32,
    friction: f32,
    restitution: f32,
    /// Normal velocity at the step's start, if that is an arrival; else 0.
    arrival: f32,
    /// Impulses of a substep on the particle: along the normal, and along the surface.
    pub(crate) press: f32,
    rub: [f32; 2],
    /// Greatest `press` in the step.
    most: f32,
}

impl PointRow {
    /// The row of a meeting, with the impulses of the last step if it was there, which are given to both.
    pub(crate) fn new(
        m: &Meeting,
        partner: Partner,
        ground: &Ground<'_>,
        (press, rub): (f32, Vec3),
        arrival: f32,
    ) -> Self {
        let w = ground.particles.read(m.line as usize).inverse_mass();
        let t1 = m.n.any_perpendicular();
        let t2 = m.n.cross(t1);
        let turn = |d: Vec3| partner.s.mul(m.r.cross(d));
        let (alpha, turns) = (partner.alpha, [turn(m.n), turn(t1), turn(t2)]);
        let k = w + alpha * alpha + turns[0].dot(turns[0]);
        // Of both directions together: at least the greater of the two.
        let k_slide = w + alpha * alpha + turns[1].dot(turns[1]) + turns[2].dot(turns[2]);
        let each = |k: f32| if k > 0.0 { 1.0 / k } else { 0.0 };
        let row = Self {
            line: m.line,
            shape: m.shape,
            body: partner.line,
            alpha,
            axes: [m.n, t1, t2],
            turns,
            drift: [m.n.dot(m.drift), t1.dot(m.drift), t2.dot(m.drift)],
            separation: m.separation,
            w,
            mass: each(k),
            mass_slide: each(k_slide),
            friction: m.friction,
            restitution: m.restitution,
            arrival,
            press,
            rub: [t1.dot(rub), t2.dot(rub)],
            most: 0.0,
        };
        if press > 0.0 || rub != Vec3::ZERO {
            row.apply(ground, [row.press, row.rub[0], row.rub[1]]);
        }
        row
    }

    /// Impulse on the particle along the surface [N s, world].
    pub(crate) fn rub(&self) -> Vec3 {
        self.axes[1] * self.rub[0] + self.axes[2] * self.rub[1]
    }

    /// Impulses along the three directions.
    fn apply(&self, ground: &Ground<'_>, p: [f32; 3]) {
        let whole = self.axes[0] * p[0] + self.axes[1] * p[1] + self.axes[2] * p[2];
        ground.kick(self.line, whole * self.w);
        self.push_body(ground, whole, p);
    }

    /// The body's part of them.
    #[inline]
    fn push_body(&self, ground: &Ground<'_>, whole: Vec3, p: [f32; 3]) {
        if self.body == 0 {
            return;
        }
        let turn = self.turns[0] * p[0] + self.turns[1] * p[1] + self.turns[2] * p[2];
        let line = ground.bodies.row(self.body as usize);
        let (dv, dw) = ((whole * self.alpha).to_array(), turn.to_array());
        for i in 0..3 {
            line.v[i] -= dv[i];
            line.w[i] -= dw[i];
        }
    }

    /// Velocity of the particle less that of the body's center, and the whitened spin of that.
    #[inline]
    fn motion(&self, ground: &Ground<'_>) -> (Vec3, Vec3, Vec3) {
        let (v, way) = ground.state(self.line);
        if self.body == 0 {
            return (v, Vec3::ZERO, way);
        }
        let line = ground.bodies.read(self.body as usize);
        (v - three(line.v) * self.alpha, three(line.w), way)
    }

    /// Velocity along a direction.
    #[inline]
    fn along(&self, axis: usize, u: Vec3, spin: Vec3) -> f32 {
        self.axes[axis].dot(u) - self.turns[axis].dot(spin) - self.drift[axis]
    }

    /// How far the body's surface went along the normal since the step's start, without its drift.
    #[inline]
    fn went(&self, ground: &Ground<'_>) -> f32 {
        if self.body == 0 {
            return 0.0;
        }
        let line = ground.bodies.read(self.body as usize);
        let (mut x, mut t) = (three(line.x), three(line.t));
        if ground.pace.form != Form::Soft {
            // At the moment that the particle's state tells of.
            x += three(line.v) * ground.pace.h;
            t += three(line.w) * ground.pace.h;
        }
        self.axes[0].dot(x) * self.alpha + self.turns[0].dot(t)
    }

    /// Solves the row once; without bias in a relax sweep.
    pub(crate) fn solve(&mut self, ground: &Ground<'_>, is_relax: bool, first: bool) {
        let pace = ground.pace;
        let soft = pace.form == Form::Soft;
        if first {
            let back = -ground.repeat();
            let p = [self.press * back, self.rub[0] * back, self.rub[1] * back];
            let whole = self.axes[0] * p[0] + self.axes[1] * p[1] + self.axes[2] * p[2];
            self.push_body(ground, whole, p);
            self.press *= pace.keep;
            self.rub = [self.rub[0] * pace.keep, self.rub[1] * pace.keep];
        }
        let (mut u, mut spin, way) = self.motion(ground);
        let time = if soft { ground.elapsed } else { ground.elapsed + pace.h };
        let moved = self.axes[0].dot(way) - self.went(ground) - self.drift[0] * time;
        let gap = self.separation + moved;
        let vn = self.along(0, u, spin);
        let speed = if !soft {
            // The gap is that of the substep's end: velocity is in it.
            gap * pace.inv_h
        } else if gap > 0.0 {
            vn + gap * pace.inv_h
        } else if is_relax {
            vn
        } else {
            vn + (PUSH_OUT * gap * pace.inv_h).max(-pace.push_speed)
        };
        let press = greater(self.press - self.mass * speed, 0.0);
        if press <= 0.0 && self.press <= 0.0 {
            // Near, and not touched: most rows of what lies beside edges.
            return;
        }
        let dn = press - self.press;
        self.press = press;
        self.most = greater(self.most, press);

        u += self.axes[0] * (dn * (self.w + self.alpha * self.alpha));
        spin -= self.turns[0] * dn;
        let wanted = [
            self.rub[0] - self.along(1, u, spin) * self.mass_slide,
            self.rub[1] - self.along(2, u, spin) * self.mass_slide,
        ];
        let size = (wanted[0] * wanted[0] + wanted[1] * wanted[1]).sqrt();
        let limit = self.friction * press;
        let part = if size > limit { limit / size } else { 1.0 };
        let rub = [wanted[0] * part, wanted[1] * part];
        self.apply(ground, [dn, rub[0] - self.rub[0], rub[1] - self.rub[1]]);
        self.rub = rub;
    }

    /// What arrived bounces.
    pub(crate) fn bounce(&mut self, ground: &Ground<'_>) {
        if self.arrival < 0.0 && self.most > 0.0 {
            let (u, spin, _) = self.motion(ground);
            let vn = self.along(0, u, spin);
            let p = greater(-self.mass * (vn + self.restitution * self.arrival), 0.0);
            self.apply(ground, [p, 0.0, 0.0]);
        }
    }
}

/// A particle held at a point of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HoldRow {
    pub(crate) line: u32,
    pub(crate) number: u32,
    partner: Partner,
    /// From the body's center to where it holds, at the step's start and when the impulse was applied.
    r0: Vec3,
    r: Vec3,
    /// Particle less anchor at the step's start [m].
    gap: Vec3,
    drift: Vec3,
    w: f32,
    /// On the particle in a substep [N s].
    pub(crate) impulse: Vec3,
    /// Its sum over substeps, beside a classic method.
    pub(crate) total: Vec3,
}

impl HoldRow {
    pub(crate) fn new(
        (line, number): (u32, u32),
        partner: Partner,
        [r, gap, drift, impulse]: [Vec3; 4],
        ground: &Ground<'_>,
    ) -> Self {
        let w = ground.particles.read(line as usize).inverse_mass();
        let row =
            Self { line, number, partner, r0: r, r, gap, drift, w, impulse, total: Vec3::ZERO };
        row.apply(ground, impulse, r.cross(impulse));
        row
    }

    fn apply(&self, ground: &Ground<'_>, p: Vec3, torque: Vec3) {
        ground.kick(self.line, p * self.w);
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
        let (_, way) = ground.state(self.line);
        let (x, t) = ground.ahead(&self.partner);
        let once = t.cross(self.r0);
        let r = self.r0 + once + t.cross(once) * 0.5;
        let time = if soft { ground.elapsed } else { ground.elapsed + pace.h };
        let gap = self.gap + way - x - (r - self.r0) - self.drift * time;
        if !is_relax {
            // The body carries the impulse at the arm that it had: see the joint kernels.
            self.partner.push(&ground.bodies, Vec3::ZERO, -(r - self.r).cross(self.impulse));
            self.r = r;
        }
        let (v, _) = ground.state(self.line);
        let u = v - self.partner.velocity(&ground.bodies, r) - self.drift;
        let wanted = if !soft {
            gap * pace.inv_h
        } else if is_relax {
            u
        } else {
            u + gap * (CLOSE * pace.inv_h)
        };
        let d = -self.matrix(r).map_or(Vec3::ZERO, |m| m.mul(wanted));
        self.apply(ground, d, r.cross(d));
        self.impulse += d;
    }

    /// What the particle answers less to an impulse than it would without the body: B = w² A, with the inverse A of
    /// what an impulse does to the velocity of the two against each other.
    pub(crate) fn less(&self) -> Sym3 {
        let Some(a) = self.matrix(self.r) else { return Sym3::ZERO };
        a.scaled(self.w * self.w)
    }

    /// Hands on to the body what it gets of an impulse on the particle, which has got its own part.
    pub(crate) fn hand_on(&mut self, lines: &Rows<'_, Line>, p: Vec3) {
        let d = -self.matrix(self.r).map_or(Vec3::ZERO, |a| a.mul(p * self.w));
        self.partner.push(lines, -d, -self.r.cross(d));
        self.impulse += d;
    }

    /// Inverse of what an impulse does to the velocity of the two against each other.
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
