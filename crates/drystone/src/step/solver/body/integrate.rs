//! Integrates bodies in the solver: whitening at the step's start, forces and the carried warm
//! start before each sweep, positions after it, and free rotation.

use fearless_simd::Simd;

use super::row::{Aux, SPLIT_ROTATION};
use super::squeeze::Squeeze;
use super::state::BodyState;
use crate::base::math::{Vec3, vec3};
use crate::base::quat::Quat;
use crate::base::simd::wide::{LANES, Vec3w};
use crate::base::sym3::Sym3;
use crate::base::threads::disjoint::ReadRows;
use crate::state::bodies::body::{Body, Subdivision};
use crate::step::context::StepContext;
use crate::step::context::softness::decay;
use crate::step::gyration::Spin;
use crate::step::gyration::lanes::turned_eight;
use crate::step::solver_body::{SolverBody, Velocity, Whitening, four, three, whitened};

/// S = R diag(1/√I) Rᵀ and S⁻¹ = R diag(√I) Rᵀ, restricted to the axes that are not locked [world].
/// A moment of 0 is an axis that cannot turn: 0 in both.
pub(crate) fn roots_of_inertia(body: &Body, rotation: Quat) -> (Sym3, Sym3) {
    if body.inertia.locks.angular != [false; 3] {
        let rotation = rotation * body.inertia.principal;
        return (locked_root(body, rotation, true), locked_root(body, rotation, false));
    }
    let m = body.inertia.moments;
    let each = |r: f32| if r > 0.0 { 1.0 / r } else { 0.0 };
    if m.min_element() >= m.max_element() {
        // The inertia of a ball or a cube is the same about every axis.
        let round = |r: f32| Sym3::diagonal(vec3(r, r, r));
        let root = m.x.sqrt();
        return (round(each(root)), round(root));
    }
    let root = vec3(m.x.sqrt(), m.y.sqrt(), m.z.sqrt());
    let inverse = vec3(each(root.x), each(root.y), each(root.z));
    let rotation = rotation * body.inertia.principal;
    (Sym3::rotated_diagonal(rotation, inverse), Sym3::rotated_diagonal(rotation, root))
}

/// One root of [`roots_of_inertia`] with locked world axes, from the eigenvectors of the restricted
/// inertia.
fn locked_root(body: &Body, rotation: Quat, inverse: bool) -> Sym3 {
    let mut inertia = Sym3::rotated_diagonal(rotation, body.inertia.moments);
    let [x, y, z] = body.inertia.locks.angular;
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
    let minimum = 1.0e-6 * d.max_element();
    let each = |i: f32| {
        if i > minimum {
            let r = i.sqrt();
            if inverse { 1.0 / r } else { r }
        } else {
            0.0
        }
    };
    Sym3::rotated_diagonal(axes, vec3(each(d.x), each(d.y), each(d.z)))
}

/// [`roots_of_inertia`] of a body with `factor` times its inertia.
pub(crate) fn scaled_roots(body: &Body, rotation: Quat, factor: f32) -> (Sym3, Sym3) {
    let (s, s_inv) = roots_of_inertia(body, rotation);
    if factor > 1.0 {
        let root = factor.sqrt();
        return (s.scaled(1.0 / root), s_inv.scaled(root));
    }
    (s, s_inv)
}

/// Linear acceleration of a body by gravity and forces [m/s²].
pub(crate) fn acceleration(ctx: &StepContext, body: &Body) -> Vec3 {
    ctx.gravity * body.forces.gravity_scale
        + (body.forces.force + body.forces.step_force) * (1.0 / body.inertia.mass)
}

/// Makes the solver body of a dynamic body from the motion `start`. It has `factor` times the
/// inertia under the same forces; `gyration` is the change of its angular velocity by free
/// rotation.
#[inline(always)]
pub(crate) fn whiten(
    ctx: &StepContext,
    body: &Body,
    factor: f32,
    start: &BodyState,
    gyration: Vec3,
) -> (SolverBody, Whitening, Aux, Vec3) {
    let (v, w) = (start.v, start.w);
    let alpha = 1.0 / (body.inertia.mass * factor).sqrt();
    let (s, s_inv) = scaled_roots(body, start.rotation, factor);
    let mut acc = acceleration(ctx, body);
    if factor > 1.0 {
        acc *= 1.0 / factor;
    }
    let solver_body =
        SolverBody { v: whitened(v, alpha), w: four(s_inv.mul(w)), x: [0.0; 4], t: [0.0; 4] };
    let torque = body.forces.torque + body.forces.step_torque;
    #[expect(clippy::cast_precision_loss, reason = "at most 256 substeps")]
    let spin = s_inv.mul(gyration) * (1.0 / ctx.substeps as f32);
    let aux = Aux {
        before_v: solver_body.v,
        before_w: solver_body.w,
        locked: body.inertia.locks.linear,
        calm: false,
        ended: false,
        parting: 0.0,
        add_v: four(acc * (ctx.h / alpha)),
        add_w: four(s.mul(torque) * ctx.h + spin),
        decay_v: decay(body.forces.linear_damping, ctx.h),
        decay_w: decay(body.forces.angular_damping, ctx.h),
    };
    (solver_body, Whitening::new(alpha, &s), aux, acc)
}

/// Change of angular velocity in a whole step by free rotation alone: L is constant, the inertia
/// turns [rad/s].
pub(crate) fn gyration(ctx: &StepContext, body: &Body, start: &BodyState) -> Vec3 {
    gyrations(ctx, [(body, start)])[0]
}

/// [`gyration`] of up to eight bodies.
pub(crate) fn gyrations<'a>(
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
    let m = body.inertia.moments;
    let round = m.max_element() - m.min_element() <= 1.0e-3 * m.max_element();
    let slow = w.length_squared() * ctx.dt * ctx.dt < 1.0e-6;
    !(round || slow || m.min_element() <= 0.0 || body.inertia.locks.angular != [false; 3])
}

/// Adds forces and, in all substeps but the first, the warm start: the velocity change `v - before`
/// by the body's impulses in the last substep. (In the first substep, preparing the rows has added
/// it.)
#[inline(always)]
pub(crate) fn velocities(solver_body: &mut SolverBody, aux: &mut Aux, first: bool) {
    for i in 0..4 {
        let (v, w) = (solver_body.v[i], solver_body.w[i]);
        let (impulse_v, impulse_w) = (v - aux.before_v[i], w - aux.before_w[i]);
        let (from_v, from_w) = if first { (aux.before_v[i], aux.before_w[i]) } else { (v, w) };
        aux.before_v[i] = (from_v + aux.add_v[i]) * aux.decay_v;
        aux.before_w[i] = (from_w + aux.add_w[i]) * aux.decay_w;
        solver_body.v[i] = aux.before_v[i] + impulse_v;
        solver_body.w[i] = aux.before_w[i] + impulse_w;
    }
}

/// Gathers the velocities of eight bodies at the start of the substep.
#[inline(always)]
pub(crate) fn load_start<S: Simd>(
    simd: S,
    aux: &ReadRows<'_, Aux>,
    rows: &[u32; LANES],
) -> Velocity<S> {
    let (mut v, mut w) = ([[0.0; 4]; LANES], [[0.0; 4]; LANES]);
    for lane in 0..LANES {
        [v[lane], w[lane]] = aux.read(rows[lane] as usize).start();
    }
    Velocity { v: Vec3w::of_rows(simd, &v), w: Vec3w::of_rows(simd, &w) }
}

/// Advances positions by one substep.
#[inline(always)]
pub(crate) fn positions(solver_body: &mut SolverBody, h: f32) {
    for i in 0..4 {
        solver_body.x[i] += h * solver_body.v[i];
        solver_body.t[i] += h * solver_body.w[i];
    }
}

/// Writes the result of a solver body to its body.
#[inline(always)]
pub(crate) fn unwhiten(
    ctx: &StepContext,
    solver_body: &SolverBody,
    whitening: &Whitening,
    (aux, factor): (&Aux, f32),
    end: Option<&BodyState>,
    body: &mut Body,
) {
    if let Some(end) = end {
        (body.v, body.w, body.history.w_low) = (end.v, end.w, end.w_low);
        (body.center, body.rotation) = (end.center, end.rotation);
        return;
    }
    let end = BodyState::of(body).after(solver_body, whitening);
    (body.center, body.rotation) = (end.center, end.rotation);
    (body.v, body.w, body.history.w_low) = (end.v, end.w, Vec3::ZERO);
    if aux.calm && body.w.length_squared() * (ctx.dt * ctx.dt) > SPLIT_ROTATION * SPLIT_ROTATION {
        keep_turning_energy(body, factor, three(solver_body.w));
    }
}

/// Limits the rotational energy of a body that turned after an impact. Impacts use the inertia of
/// the step's start; the angular velocity is scaled so that the energy does not exceed the energy
/// after them.
fn keep_turning_energy(body: &mut Body, factor: f32, w: Vec3) {
    let local = (body.rotation * body.inertia.principal).unrotate(body.w);
    let energy = local.dot(vec3(
        local.x * body.inertia.moments.x,
        local.y * body.inertia.moments.y,
        local.z * body.inertia.moments.z,
    ));
    // A body with a load-adaptive factor has this energy by its true inertia.
    let left = w.length_squared() / factor;
    if energy > left {
        body.w *= (left / energy).sqrt();
    }
}

/// Impact threshold: a change of velocity in a step that would move a body by more than this part
/// of its size in the next one. For a size of one meter it is 18 times gravity.
const JOLT: f32 = 0.1;

/// Records the squeeze of a body; `before` is its velocity at the step's start.
pub(crate) fn note_load(ctx: &StepContext, squeeze: &Squeeze, before: Vec3, body: &mut Body) {
    // A body that an impact sets moving is not at rest. With an increased mass it would hit others
    // with energy that it does not have.
    if (body.v - before).length() * ctx.dt > JOLT * body.extent {
        (body.history.inertia_factor, body.history.load) = (1.0, 0.0);
        body.history.subdivision = match squeeze.subdivision {
            Subdivision::Struck => Subdivision::Struck,
            _ => Subdivision::Whole,
        };
        return;
    }
    (body.history.inertia_factor, body.history.subdivision) = (squeeze.factor, squeeze.subdivision);
    body.history.load = squeeze.pressure() * ctx.inv_h;
}
