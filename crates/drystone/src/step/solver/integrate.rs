//! Bodies in the solver: whitening at the step's start, forces and the carried warm start before each
//! sweep, positions after it, and free rotation.

use fearless_simd::Simd;

use super::inertia::Squeeze;
use super::rounds::BodyState;
use super::rows::{Line, Velocity, Whitening};
use super::softness::decay;
use super::spin::{Spin, turned_eight};
use crate::base::disjoint::Rows;
use crate::base::double::DVec3;
use crate::base::math::{Vec3, vec3};
use crate::base::quat::Quat;
use crate::base::sym3::Sym3;
use crate::base::wide::{LANES, Vec3w};
use crate::state::bodies::{Body, Fineness};
use crate::step::context::StepContext;

/// What a line needs between sweeps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Aux {
    /// Whitened velocity after forces and before any impulse of this substep.
    before_v: [f32; 4],
    before_w: [f32; 4],
    /// Whitened velocity that forces and free rotation add in a substep.
    add_v: [f32; 4],
    add_w: [f32; 4],
    decay_v: f32,
    decay_w: f32,
    locked: [bool; 3],
    /// An impact may change its velocity in this step, so what free rotation would do to that from its
    /// start is not known: nothing of it is left in `add_w`.
    calm: bool,
    /// The line holds the body at the step's end: velocity, angular velocity (`before_w` what rounding took
    /// from it), center, rotation.
    ended: bool,
    /// How fast overlaps that are parted move the body in this step [m/s].
    parting: f32,
}

/// A line's velocity with the carried impulses, and before them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Carried {
    v: [[f32; 4]; 2],
    w: [[f32; 4]; 2],
}

impl Aux {
    /// Takes the impulses that are carried from the last substep out of a line's velocity.
    pub(crate) fn lift(&self, line: &mut Line) -> Carried {
        let carried = Carried { v: [line.v, self.before_v], w: [line.w, self.before_w] };
        (line.v, line.w) = (self.before_v, self.before_w);
        carried
    }

    /// Puts them back: exactly what was there if nothing struck the line.
    pub(crate) fn put_back(&self, line: &mut Line, carried: &Carried) {
        let Carried { v: [v, before_v], w: [w, before_w] } = carried;
        for i in 0..4 {
            line.v[i] = v[i] + (self.before_v[i] - before_v[i]);
            line.w[i] = w[i] + (self.before_w[i] - before_w[i]);
        }
    }

    /// Leaves free rotation out of the rest of the step, of a body that turns far in it.
    pub(crate) fn calm(&mut self, whitening: &Whitening, body: &Body, dt: f32, h: f32) {
        self.calm = true;
        if body.w.length_squared() * (dt * dt) > FAR_TURN * FAR_TURN {
            self.add_w = four(whitening.s().mul(body.torque + body.step_torque) * h);
        }
    }

    /// What turns on its own has no part of free rotation in its velocity: a torque [N m, world] alone changes that.
    pub(super) fn turn_by_torque(&mut self, whitening: &Whitening, body: &Body, h: f32) {
        self.add_w = four(whitening.s().mul(body.torque + body.step_torque) * h);
    }

    /// The line carries no impulses to the next substep.
    pub(super) fn start_anew(&mut self, line: &Line) {
        (self.before_v, self.before_w) = (line.v, line.w);
    }

    /// Takes impulses, times their scales, out of what is carried to the next substep.
    #[inline]
    pub(super) fn begin_later(&mut self, v: &[f32; 4], scale_v: f32, w: &[f32; 4], scale_w: f32) {
        for i in 0..4 {
            self.before_v[i] += v[i] * scale_v;
            self.before_w[i] += w[i] * scale_w;
        }
    }

    /// Puts the end of the step of a body in its line, and what rounding took from its angular velocity.
    pub(super) fn put_end(&mut self, line: &mut Line, end: &BodyState, w_rest: Vec3) {
        (line.v, line.w) = (four(end.v), four(end.w));
        (line.x, line.t) = (four(end.center), end.rotation.to_array());
        (self.before_w, self.ended) = (four(w_rest), true);
    }

    /// Whitened velocity and angular velocity before any impulse of this substep.
    pub(super) const fn before(&self) -> [[f32; 4]; 2] {
        [self.before_v, self.before_w]
    }

    /// Whitened velocity and angular velocity when the substep began, before forces.
    #[inline(always)]
    pub(super) fn start(&self) -> [[f32; 4]; 2] {
        let back = |before: f32, decay: f32, add: f32| {
            if decay > 0.0 { before / decay - add } else { 0.0 }
        };
        let mut start = [[0.0; 4]; 2];
        for i in 0..3 {
            start[0][i] = back(self.before_v[i], self.decay_v, self.add_v[i]);
            start[1][i] = back(self.before_w[i], self.decay_w, self.add_w[i]);
        }
        start
    }

    /// Notes how fast overlaps that are parted move the body [m/s].
    pub(super) const fn parts_at(&mut self, speed: f32) {
        self.parting = speed;
    }

    /// See [`Self::parts_at`].
    pub(super) const fn parting(&self) -> f32 {
        self.parting
    }

    /// The square of what forces add to the whitened velocity in a substep.
    pub(super) const fn kick(&self) -> f32 {
        let [x, y, z, _] = self.add_v;
        x * x + y * y + z * z
    }

    /// True if a translation is locked.
    pub(crate) fn is_locked(&self) -> bool {
        self.locked != [false; 3]
    }

    /// An impact on the line; no impulse that the next substep repeats.
    #[inline]
    pub(crate) fn strike(&mut self, line: &mut Line, dv: Vec3, dw: Vec3) {
        let (dv, dw) = (four(dv), four(dw));
        for i in 0..4 {
            line.v[i] += dv[i];
            line.w[i] += dw[i];
            self.before_v[i] += dv[i];
            self.before_w[i] += dw[i];
        }
    }

    /// True if nothing but forces and damping moved the body's center in `substeps` substeps of `h`. (Every
    /// impulse of a row does.)
    pub(crate) fn flew(&self, line: &Line, start: [f32; 4], substeps: u32, h: f32) -> bool {
        let (mut v, mut x) = (start, [0.0; 4]);
        for _ in 0..substeps {
            for i in 0..4 {
                v[i] = (v[i] + self.add_v[i]) * self.decay_v;
                x[i] += h * v[i];
            }
        }
        (0..4).all(|i| same(v[i], line.v[i]) && same(x[i], line.x[i]))
    }

    /// Takes locked translations out.
    pub(crate) fn hold_locked(&self, line: &mut Line) {
        for i in 0..3 {
            if self.locked[i] {
                line.v[i] = 0.0;
            }
        }
    }
}

/// The same number: what two equal computations give.
#[expect(clippy::float_cmp, reason = "whether anything at all was added")]
fn same(a: f32, b: f32) -> bool {
    a == b
}

pub(super) const fn four(v: Vec3) -> [f32; 4] {
    [v.x, v.y, v.z, 0.0]
}

pub(crate) const fn three(v: [f32; 4]) -> Vec3 {
    vec3(v[0], v[1], v[2])
}

/// S = R diag(1/√I) Rᵀ and S⁻¹ = R diag(√I) Rᵀ, restricted to the axes that are not locked [world]. A
/// moment of 0 is an axis that cannot turn: 0 in both.
pub(super) fn roots_of_inertia(body: &Body, rotation: Quat) -> (Sym3, Sym3) {
    if body.locks.angular != [false; 3] {
        let rotation = rotation * body.principal;
        return (locked_root(body, rotation, true), locked_root(body, rotation, false));
    }
    let m = body.moments;
    let each = |r: f32| if r > 0.0 { 1.0 / r } else { 0.0 };
    if m.min_element() >= m.max_element() {
        // A ball's inertia, and a cube's, is the same about every axis.
        let round = |r: f32| Sym3::diagonal(vec3(r, r, r));
        let root = m.x.sqrt();
        return (round(each(root)), round(root));
    }
    let root = vec3(m.x.sqrt(), m.y.sqrt(), m.z.sqrt());
    let inverse = vec3(each(root.x), each(root.y), each(root.z));
    let rotation = rotation * body.principal;
    (Sym3::rotated_diagonal(rotation, inverse), Sym3::rotated_diagonal(rotation, root))
}

/// As [`roots_of_inertia`], of the inertia restricted to the free world axes: its root by eigenvectors.
fn locked_root(body: &Body, rotation: Quat, inverse: bool) -> Sym3 {
    let mut inertia = Sym3::rotated_diagonal(rotation, body.moments);
    let [x, y, z] = body.locks.angular;
    if x {
        (inertia.xx, inertia.xy, inertia.xz) = (0.0, 0.0, 0.0);
    }
    if y {
        (inertia.yy, inertia.xy, inertia.yz) = (0.0, 0.0, 0.0);
    }
    if z {
        (inertia.zz, inertia.xz, inertia.yz) = (0.0, 0.0, 0.0);
    }
    let (d, axes) = inertia.eigen();
    let least = 1.0e-6 * d.max_element();
    let each = |i: f32| {
        if i > least {
            let r = i.sqrt();
            if inverse { 1.0 / r } else { r }
        } else {
            0.0
        }
    };
    Sym3::rotated_diagonal(axes, vec3(each(d.x), each(d.y), each(d.z)))
}

/// [`roots_of_inertia`] of a body with `factor` times its inertia.
pub(super) fn scaled_roots(body: &Body, rotation: Quat, factor: f32) -> (Sym3, Sym3) {
    let (s, s_inv) = roots_of_inertia(body, rotation);
    if factor > 1.0 {
        let root = factor.sqrt();
        return (s.scaled(1.0 / root), s_inv.scaled(root));
    }
    (s, s_inv)
}

/// Linear acceleration of a body by gravity and forces [m/s²].
pub(crate) fn acceleration(ctx: &StepContext, body: &Body) -> Vec3 {
    ctx.gravity * body.gravity_scale + (body.force + body.step_force) * (1.0 / body.mass)
}

/// v̂ of a velocity.
pub(crate) fn whitened(v: Vec3, alpha: f32) -> [f32; 4] {
    four(v * (1.0 / alpha))
}

/// The velocity of a line that began with velocity `v`. By how much it has changed where that is little: √m v / √m is not v, and
/// what went on as before lost or won up to 6e-8 of its speed in every step, always the same way.
pub(super) fn unwhitened(v: Vec3, line: &Line, alpha: f32) -> Vec3 {
    let (start, mut end) = (whitened(v, alpha), three(line.v) * alpha);
    for i in 0..3 {
        let change = line.v[i] - start[i];
        if change.abs() < 0.5 * start[i].abs() {
            end[i] = v[i] + change * alpha;
        }
    }
    end
}

/// A dynamic body as a line, from this motion on: with `factor` times its inertia under the same forces, and what
/// free rotation adds to its angular velocity.
#[inline(always)]
pub(super) fn whiten(
    ctx: &StepContext,
    body: &Body,
    factor: f32,
    start: &BodyState,
    gyration: Vec3,
) -> (Line, Whitening, Aux, Vec3) {
    let (v, w) = (start.v, start.w);
    let alpha = 1.0 / (body.mass * factor).sqrt();
    let (s, s_inv) = scaled_roots(body, start.rotation, factor);
    let mut acc = acceleration(ctx, body);
    if factor > 1.0 {
        acc *= 1.0 / factor;
    }
    let line = Line { v: whitened(v, alpha), w: four(s_inv.mul(w)), x: [0.0; 4], t: [0.0; 4] };
    let torque = body.torque + body.step_torque;
    #[expect(clippy::cast_precision_loss, reason = "at most 256 substeps")]
    let spin = s_inv.mul(gyration) * (1.0 / ctx.substeps as f32);
    let aux = Aux {
        before_v: line.v,
        before_w: line.w,
        locked: body.locks.linear,
        calm: false,
        ended: false,
        parting: 0.0,
        add_v: four(acc * (ctx.h / alpha)),
        add_w: four(s.mul(torque) * ctx.h + spin),
        decay_v: decay(body.linear_damping, ctx.h),
        decay_w: decay(body.angular_damping, ctx.h),
    };
    (line, Whitening::new(alpha, &s), aux, acc)
}

/// Change of angular velocity in a whole step by free rotation alone: L stays, the inertia turns [rad/s].
pub(super) fn gyration(ctx: &StepContext, body: &Body, start: &BodyState) -> Vec3 {
    gyrations(ctx, [(body, start)])[0]
}

/// The same of up to eight bodies.
pub(super) fn gyrations<'a>(
    ctx: &StepContext,
    bodies: impl IntoIterator<Item = (&'a Body, &'a BodyState)>,
) -> [Vec3; LANES] {
    let mut spins = [const { None }; LANES];
    for (spin, (body, start)) in spins.iter_mut().zip(bodies) {
        let gyrates = gyrates(ctx, body, start.w);
        *spin = gyrates.then(|| (Spin { rotation: start.rotation, ..Spin::of(body) }, start.w));
    }
    let mut changes = turned_eight(ctx, &spins);
    for (change, spin) in changes.iter_mut().zip(&spins) {
        if let Some((_, w)) = spin {
            *change -= *w;
        }
    }
    changes
}

/// True if free rotation changes the angular velocity `w` in a step.
fn gyrates(ctx: &StepContext, body: &Body, w: Vec3) -> bool {
    let m = body.moments;
    let round = m.max_element() - m.min_element() <= 1.0e-3 * m.max_element();
    let slow = w.length_squared() * ctx.dt * ctx.dt < 1.0e-6;
    !(round || slow || m.min_element() <= 0.0 || body.locks.angular != [false; 3])
}

/// Forces, and in all substeps but the first the warm start: what the body's impulses did to it in the
/// last substep, `v - before`, is done again. (In the first they are there already.)
#[inline(always)]
pub(crate) fn velocities(line: &mut Line, aux: &mut Aux, first: bool) {
    for i in 0..4 {
        let (v, w) = (line.v[i], line.w[i]);
        let (impulse_v, impulse_w) = (v - aux.before_v[i], w - aux.before_w[i]);
        let (from_v, from_w) = if first { (aux.before_v[i], aux.before_w[i]) } else { (v, w) };
        aux.before_v[i] = (from_v + aux.add_v[i]) * aux.decay_v;
        aux.before_w[i] = (from_w + aux.add_w[i]) * aux.decay_w;
        line.v[i] = aux.before_v[i] + impulse_v;
        line.w[i] = aux.before_w[i] + impulse_w;
    }
}

/// The velocities of eight bodies when the substep began.
#[inline(always)]
pub(super) fn load_start<S: Simd>(
    simd: S,
    aux: &Rows<'_, Aux>,
    rows: &[u32; LANES],
) -> Velocity<S> {
    let (mut v, mut w) = ([[0.0; 4]; LANES], [[0.0; 4]; LANES]);
    for lane in 0..LANES {
        [v[lane], w[lane]] = aux.read(rows[lane] as usize).start();
    }
    Velocity { v: Vec3w::of_rows(simd, &v), w: Vec3w::of_rows(simd, &w) }
}

/// Positions follow velocities for one substep.
#[inline(always)]
pub(crate) fn positions(line: &mut Line, h: f32) {
    for i in 0..4 {
        line.x[i] += h * line.v[i];
        line.t[i] += h * line.w[i];
    }
}

/// Writes a line back into its body.
#[inline(always)]
pub(crate) fn unwhiten(
    ctx: &StepContext,
    line: &Line,
    whitening: &Whitening,
    (aux, factor): (&Aux, f32),
    body: &mut Body,
) {
    if aux.ended {
        (body.v, body.w, body.w_rest) = (three(line.v), three(line.w), three(aux.before_w));
        (body.center, body.rotation) = (three(line.x), Quat::from(line.t));
        return;
    }
    let end = BodyState::of(body).after(line, whitening);
    (body.center, body.rotation) = (end.center, end.rotation);
    (body.v, body.w, body.w_rest) = (end.v, end.w, Vec3::ZERO);
    if aux.calm && body.w.length_squared() * (ctx.dt * ctx.dt) > FAR_TURN * FAR_TURN {
        keep_turning_energy(body, factor, three(line.w));
    }
}

/// Turning by more than this in a step is far [rad].
const FAR_TURN: f32 = 0.25;

/// Impacts were right by the inertia of the step's start. What a body that turned since then has of
/// energy beyond what they left it is taken from its angular velocity.
fn keep_turning_energy(body: &mut Body, factor: f32, w: Vec3) {
    let local = (body.rotation * body.principal).unrotate(body.w);
    let energy = local.dot(vec3(
        local.x * body.moments.x,
        local.y * body.moments.y,
        local.z * body.moments.z,
    ));
    // Of a body that is heavier in this step, that of its own inertia.
    let left = w.length_squared() / factor;
    if energy > left {
        body.w *= (left / energy).sqrt();
    }
}

/// A change of velocity in a step that would move a body by more than this part of its size in the next
/// one is a blow: 18 times gravity for a meter of size.
const JOLT: f32 = 0.1;

/// Takes down how a body was squeezed, whose velocity was `before` when the step began.
pub(crate) fn note_load(ctx: &StepContext, squeeze: &Squeeze, before: Vec3, body: &mut Body) {
    // What an impact sends off does not rest: with a mass that is not its own it would hit others with
    // energy that it does not have.
    if (body.v - before).length() * ctx.dt > JOLT * body.extent {
        (body.inertia_factor, body.load) = (1.0, 0.0);
        body.fineness = match squeeze.fineness {
            Fineness::Struck => Fineness::Struck,
            _ => Fineness::Whole,
        };
        return;
    }
    (body.inertia_factor, body.fineness) = (squeeze.factor, squeeze.fineness);
    body.load = squeeze.pressure() * ctx.inv_h;
}

/// A body that nothing touches: its parabola exactly; true if its free rotation is still to be done, by
/// [`super::spin::Spins`].
pub(crate) fn fly(ctx: &StepContext, body: &mut Body) -> bool {
    (body.inertia_factor, body.load, body.fineness) = (1.0, 0.0, Fineness::Whole);
    let acc = acceleration(ctx, body);
    let decay_v = super::softness::exact_decay(body.linear_damping, ctx.dt);
    let next = (body.v + acc * ctx.dt) * decay_v;
    let mut mean = (body.v + next) * 0.5;
    let mut v = next;
    for i in 0..3 {
        if body.locks.linear[i] {
            (mean[i], v[i]) = (0.0, 0.0);
        }
    }
    body.center += mean * ctx.dt;
    body.v = v;

    let torque = body.torque + body.step_torque;
    if torque != Vec3::ZERO {
        let (s, _) = roots_of_inertia(body, body.rotation);
        body.w += s.mul(s.mul(torque)) * ctx.dt;
    }
    body.w *= super::softness::exact_decay(body.angular_damping, ctx.dt);
    let m = body.moments;
    let round = m.max_element() - m.min_element() <= 1.0e-3 * m.max_element();
    if m.min_element() <= 0.0 || body.locks.angular != [false; 3] {
        let (s, s_inv) = roots_of_inertia(body, body.rotation);
        body.w = s.mul(s_inv.mul(body.w));
        body.rotation = body.rotation.turned_by(body.w * ctx.dt);
    } else if round {
        body.rotation = body.rotation.turned_by(body.w * ctx.dt);
    } else if DVec3::from(body.w) + DVec3::from(body.w_rest) == DVec3::ZERO {
        (body.w, body.w_rest) = (Vec3::ZERO, Vec3::ZERO);
    } else {
        return true;
    }
    false
}
