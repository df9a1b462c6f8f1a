//! Bodies in the solver: whitening at the step's start, forces and the carried warm start before each
//! sweep, positions after it, and free rotation.

use super::inertia::Squeeze;
use super::rows::{Line, Whitening};
use super::softness::decay;
use crate::base::double::{DQuat, DVec3};
use crate::base::math::{Vec3, vec3};
use crate::base::quat::Quat;
use crate::base::sym3::Sym3;
use crate::state::bodies::Body;
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
}

impl Aux {
    /// True if a translation is locked.
    pub(crate) fn is_locked(&self) -> bool {
        self.locked != [false; 3]
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

const fn four(v: Vec3) -> [f32; 4] {
    [v.x, v.y, v.z, 0.0]
}

const fn three(v: [f32; 4]) -> Vec3 {
    vec3(v[0], v[1], v[2])
}

/// S = R diag(1/√I) Rᵀ and S⁻¹ = R diag(√I) Rᵀ, restricted to the axes that are not locked [world]. A
/// moment of 0 is an axis that cannot turn: 0 in both.
fn roots_of_inertia(body: &Body) -> (Sym3, Sym3) {
    if body.locks.angular != [false; 3] {
        let rotation = body.rotation * body.principal;
        return (locked_root(body, rotation, true), locked_root(body, rotation, false));
    }
    let m = body.moments;
    let root = vec3(m.x.sqrt(), m.y.sqrt(), m.z.sqrt());
    let each = |r: f32| if r > 0.0 { 1.0 / r } else { 0.0 };
    if m.min_element() >= m.max_element() {
        // A ball's inertia, and a cube's, is the same about every axis.
        let round = |r: f32| Sym3::diagonal(vec3(r, r, r));
        return (round(each(root.x)), round(root.x));
    }
    let inverse = vec3(each(root.x), each(root.y), each(root.z));
    let rotation = body.rotation * body.principal;
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

/// Linear acceleration of a body by gravity and forces [m/s²].
pub(crate) fn acceleration(ctx: &StepContext, body: &Body) -> Vec3 {
    ctx.gravity * body.gravity_scale + (body.force + body.step_force) * (1.0 / body.mass)
}

/// A dynamic body as a line: with this velocity and angular velocity, and `factor` times its inertia under
/// the same forces.
pub(crate) fn whiten(
    ctx: &StepContext,
    body: &Body,
    factor: f32,
    (v, w): (Vec3, Vec3),
) -> (Line, Whitening, Aux, Vec3) {
    let alpha = 1.0 / (body.mass * factor).sqrt();
    let (mut s, mut s_inv) = roots_of_inertia(body);
    let mut acc = acceleration(ctx, body);
    if factor > 1.0 {
        let root = factor.sqrt();
        (s, s_inv) = (s.scaled(1.0 / root), s_inv.scaled(root));
        acc *= 1.0 / factor;
    }
    let line = Line { v: four(v * (1.0 / alpha)), w: four(s_inv.mul(w)), x: [0.0; 4], t: [0.0; 4] };
    let torque = body.torque + body.step_torque;
    #[expect(clippy::cast_precision_loss, reason = "at most 256 substeps")]
    let spin = s_inv.mul(gyration(ctx, body)) * (1.0 / ctx.substeps as f32);
    let aux = Aux {
        before_v: line.v,
        before_w: line.w,
        locked: body.locks.linear,
        add_v: four(acc * (ctx.h / alpha)),
        add_w: four(s.mul(torque) * ctx.h + spin),
        decay_v: decay(body.linear_damping, ctx.h),
        decay_w: decay(body.angular_damping, ctx.h),
    };
    (line, Whitening::new(alpha, &s), aux, acc)
}

/// Change of angular velocity in a whole step by free rotation alone: L stays, the inertia turns.
fn gyration(ctx: &StepContext, body: &Body) -> Vec3 {
    let m = body.moments;
    let round = m.max_element() - m.min_element() <= 1.0e-3 * m.max_element();
    if round || m.min_element() <= 0.0 || body.locks.angular != [false; 3] {
        return Vec3::ZERO;
    }
    if body.w.length_squared() * ctx.dt * ctx.dt < 1.0e-6 {
        return Vec3::ZERO;
    }
    let (_, w) = rotate_freely(body, body.w, ctx);
    w - body.w
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

/// Positions follow velocities for one substep.
#[inline(always)]
pub(crate) fn positions(line: &mut Line, h: f32) {
    for i in 0..4 {
        line.x[i] += h * line.v[i];
        line.t[i] += h * line.w[i];
    }
}

/// Writes a line back into its body.
pub(crate) fn unwhiten(line: &Line, whitening: &Whitening, body: &mut Body) {
    let (alpha, s) = (whitening.alpha(), whitening.s());
    body.v = three(line.v) * alpha;
    body.w = s.mul(three(line.w));
    body.center += three(line.x) * alpha;
    body.rotation = body.rotation.turned_by(s.mul(three(line.t)));
}

/// Takes down how a body was squeezed.
pub(crate) fn note_load(ctx: &StepContext, squeeze: &Squeeze, body: &mut Body) {
    body.inertia_factor = squeeze.factor;
    body.load = squeeze.pressure() * ctx.inv_h;
}

/// A body that nothing touches: its parabola exactly, its free rotation by symplectic splitting.
pub(crate) fn fly(ctx: &StepContext, body: &mut Body) {
    (body.inertia_factor, body.load) = (1.0, 0.0);
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
        let (s, _) = roots_of_inertia(body);
        body.w += s.mul(s.mul(torque)) * ctx.dt;
    }
    body.w *= super::softness::exact_decay(body.angular_damping, ctx.dt);
    let m = body.moments;
    let round = m.max_element() - m.min_element() <= 1.0e-3 * m.max_element();
    if m.min_element() <= 0.0 || body.locks.angular != [false; 3] {
        let (s, s_inv) = roots_of_inertia(body);
        body.w = s.mul(s_inv.mul(body.w));
        body.rotation = body.rotation.turned_by(body.w * ctx.dt);
    } else if round {
        body.rotation = body.rotation.turned_by(body.w * ctx.dt);
    } else {
        (body.rotation, body.w) = rotate_freely(body, body.w, ctx);
    }
}

/// The largest turn of one symplectic rotation step [rad]. The error of Strang splitting in a step is
/// at most about a twelfth of its cube, 7e-7 rad here, and its period is off by the square.
const LARGEST_TURN: f32 = 0.02;

/// How many parts of a step a free rotation takes: as many as the substeps for a fast one.
fn turning_parts(ctx: &StepContext, w: Vec3) -> u32 {
    let turn = w.length() * ctx.dt;
    let mut parts = 1;
    let mut reach = LARGEST_TURN;
    while parts < ctx.substeps && reach < turn {
        parts += 1;
        reach += LARGEST_TURN;
    }
    parts
}

/// Free rotation of a rigid body: angular momentum is kept, orientation and body-frame momentum are
/// turned about the principal axes x(h/2) y(h/2) z(h) y(h/2) x(h/2) [Dullweber97], each turn by the
/// Cayley map: no trigonometry, exactly orthogonal. The two turns about x where parts meet are one.
/// Returns orientation and angular velocity.
///
/// In double precision: rounding of `f32` at every step would let the momentum wander by 1e-5 in
/// seconds, and this is done once a step for bodies in flight only.
fn rotate_freely(body: &Body, w: Vec3, ctx: &StepContext) -> (Quat, Vec3) {
    if w == Vec3::ZERO {
        return (body.rotation, w);
    }
    let q = DQuat::from(body.rotation).times(DQuat::from(body.principal));
    let m = DVec3::from(body.moments);
    let local = q.unrotate(DVec3::from(w));
    let world_momentum = q.rotate(DVec3 { x: local.x * m.x, y: local.y * m.y, z: local.z * m.z });
    let l = q.unrotate(world_momentum);
    let parts = turning_parts(ctx, w);
    let half = 0.5 * f64::from(ctx.dt) / f64::from(parts);
    // Half an angle in a part for each unit of momentum.
    let rate = [half / m.x, half / m.y, half / m.z];
    let mut top = Top { q: [q.v.x, q.v.y, q.v.z, q.w], l: [l.x, l.y, l.z] };
    top.turn([0, 1, 2], 0.5 * rate[0]);
    for part in 1..=parts {
        top.turn([1, 2, 0], 0.5 * rate[1]);
        top.turn([2, 0, 1], rate[2]);
        top.turn([1, 2, 0], 0.5 * rate[1]);
        top.turn([0, 1, 2], if part < parts { rate[0] } else { 0.5 * rate[0] });
    }
    let [x, y, z, scalar] = top.q;
    let q = DQuat { v: DVec3 { x, y, z }, w: scalar }.normalized();
    // The world's momentum is that of the step's start: rounding cannot spin a body up or down.
    let local = q.unrotate(world_momentum);
    let w = q.rotate(DVec3 { x: local.x / m.x, y: local.y / m.y, z: local.z / m.z });
    let rotation = q.times(DQuat::from(body.principal.conjugate())).normalized();
    (rotation.single(), w.single())
}

/// A spinning body: orientation (a quaternion of any length) and momentum in its own frame.
struct Top {
    q: [f64; 4],
    l: [f64; 3],
}

impl Top {
    /// A turn about axis `i` by twice the angle whose tangent is t = `rate` · momentum: the quaternion
    /// (t axis, 1), its length left for later, and its matrix with cos = (1 - t²)/(1 + t²) and
    /// sin = 2 t/(1 + t²). `[i, j, k]` are the axes in cyclic order.
    #[inline(always)]
    fn turn(&mut self, [i, j, k]: [usize; 3], rate: f64) {
        let (q, l) = (&mut self.q, &mut self.l);
        let t = rate * l[i];
        let scale = 1.0 / (1.0 + t * t);
        let (cos, sin) = ((1.0 - t * t) * scale, 2.0 * t * scale);
        (l[j], l[k]) = (cos * l[j] + sin * l[k], cos * l[k] - sin * l[j]);
        (q[i], q[j], q[k], q[3]) =
            (q[i] + t * q[3], q[j] + t * q[k], q[k] - t * q[j], q[3] - t * q[i]);
        // Hundreds of wild turns would leave the range of f64.
        if t.abs() > 0.5 {
            for x in q {
                *x *= scale.sqrt();
            }
        }
    }
}
