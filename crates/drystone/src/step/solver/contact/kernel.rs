//! The contact kernel: solves eight contacts at a time.
//!
//! Symbols: n normal, t1 t2 tangents, a b rows of bodies A and B, α β their 1/√m, s separation, u
//! relative normal speed, λ impulse, K_ij = response of row i to an impulse on row j. See
//! docs/derivations/soft-step.md.

use fearless_simd::{Simd, SimdBase, SimdMask, mask32x8};

use super::block::{ContactBlock, Extra, K};
use super::parting;
use super::sweep::{ContactSweep, DEEP_RATE};
use crate::base::simd::wide::{
    LANES, Sym3w, Vec3w, Wide, above, bits, bits_up_to_zero, load, max, min, select, splat, sqrt,
};
use crate::base::threads::disjoint::{Next, Rows};
use crate::step::solver_body::{SolverBody, Velocity, load_motion, load_velocity, store_velocity};

/// Additional rounds for a contact without a warm start, and for one that is hit. A contact is hit
/// if its points approach faster than the sweep's `hit` [m/s], ten times the speed that gravity
/// adds in a substep.
const EAGER_ROUNDS: u32 = 6;

/// Solves one block once. `FIXED`: only B can be pushed.
#[inline(always)]
pub(crate) fn solve<S: Simd, const FIXED: bool>(
    simd: S,
    block: &mut ContactBlock,
    extra: Option<&mut Extra>,
    next: Next<'_, ContactBlock>,
    solver_bodies: &Rows<'_, SolverBody>,
    sweep: &ContactSweep,
) {
    match block.count {
        1 => solve_points::<S, FIXED, 1>(simd, block, extra, next, solver_bodies, sweep),
        2 => solve_points::<S, FIXED, 2>(simd, block, extra, next, solver_bodies, sweep),
        _ => solve_points::<S, FIXED, 4>(simd, block, extra, next, solver_bodies, sweep),
    }
}

/// Target of each point, as impulses: bias, softness on the accumulated impulse, and limit of the
/// push-out.
struct Bias<S: Simd, const N: usize> {
    target: [Wide<S>; N],
    leak: [Wide<S>; N],
    floor: [Wide<S>; N],
}

/// Runs one Gauss-Seidel round over the points of a manifold, always in the same order. With z_i =
/// gain_i vn_i the increment of λ is -min(q + z, λ). The dependency chain from one point to the
/// next is four operations: add, min, multiply, subtract.
#[inline(always)]
fn solve_normals<S: Simd, const N: usize>(
    bias: &Bias<S, N>,
    response: &[[Wide<S>; N]; N],
    only: Option<(mask32x8<S>, Wide<S>)>,
    lambda: &mut [Wide<S>; N],
    z: &mut [Wide<S>; N],
) {
    for j in 0..N {
        // The cap applies to bias and softness together: it limits the net push-out, not the load.
        let q = max(bias.target[j] + bias.leak[j] * lambda[j], bias.floor[j]);
        let mut d = min(q + z[j], lambda[j]);
        if let Some((lanes, zero)) = only {
            d = select(lanes, d, zero);
        }
        lambda[j] -= d;
        for i in 0..N {
            z[i] -= response[i][j] * d;
        }
    }
}

/// Runs additional rounds for contacts that are fresh or hit, whose distribution of the impact over
/// the points is still unknown. Without them the first point would take too much of it, and the
/// body would turn. They run lane by lane, so the result does not depend on which contacts share a
/// block.
///
/// A missing point, of a contact beside contacts with more points, has zero gain and does not
/// count. A lone point gets no additional rounds. A contact without an impulse at `entry` and after
/// one round gets none in the next: so most contacts between bodies side by side are skipped.
#[inline(always)]
fn solve_eagerly<S: Simd, const N: usize>(
    simd: S,
    block: &ContactBlock,
    bias: &Bias<S, N>,
    response: &[[Wide<S>; N]; N],
    ([vn, gain, entry], hit): ([&[Wide<S>; N]; 3], f32),
    lambda: &mut [Wide<S>; N],
    z: &mut [Wide<S>; N],
) {
    let zero = splat(simd, 0.0);
    let mut fastest = vn[0];
    if block.is_mixed {
        for j in 1..N {
            fastest = min(fastest, select(above(gain[j], zero), vn[j], zero));
        }
        fastest = select(above(gain[1], zero), fastest, zero);
    } else {
        for speed in &vn[1..] {
            fastest = min(fastest, *speed);
        }
    }
    let mut eager = min(fastest + splat(simd, hit), zero);
    if block.any_fresh {
        eager -= load(simd, &block.fresh);
    }
    let mut lanes = [0.0; LANES];
    (zero - eager).store_array(&mut lanes);
    if bits_up_to_zero(&lanes) == 0xff {
        return;
    }
    let mut loaded = max(entry[0], lambda[0]);
    for j in 1..N {
        loaded = max(loaded, max(entry[j], lambda[j]));
    }
    let eager = above(min(loaded, -eager), zero);
    if eager.any_true() {
        for _ in 0..EAGER_ROUNDS {
            solve_normals(bias, response, Some((eager, zero)), lambda, z);
        }
    }
}

#[inline(always)]
fn solve_points<S: Simd, const FIXED: bool, const N: usize>(
    simd: S,
    block: &mut ContactBlock,
    mut extra: Option<&mut Extra>,
    next: Next<'_, ContactBlock>,
    solver_bodies: &Rows<'_, SolverBody>,
    sweep: &ContactSweep,
) {
    // The next block is prefetched in pieces of two to eight cache lines, in the order of use. Each
    // piece is as large as can arrive during the work between two pieces.
    let (asked, last) = (5 + 6 * N, ContactBlock::cache_lines(N));
    let half = asked + (last - asked) / 2;
    next.prefetch(0..5);
    let zero = splat(simd, 0.0);
    let n = Vec3w::load(simd, &block.n);
    let (beta, mut vb) =
        (load(simd, &block.beta), load_velocity(simd, solver_bodies, &block.row_b));
    let xb = load_motion(simd, solver_bodies, &block.row_b);
    let (mut u, mut moved) = (n.dot(vb.v) * beta, n.dot(xb.v) * beta);
    let mut va = Velocity::zero(simd);
    let mut xa = va;
    if !FIXED {
        let alpha = load(simd, &block.alpha);
        va = load_velocity(simd, solver_bodies, &block.row_a);
        xa = load_motion(simd, solver_bodies, &block.row_a);
        u -= n.dot(va.v) * alpha;
        moved -= n.dot(xa.v) * alpha;
    }

    // Speed and separation of every point.
    let inv_h = splat(simd, sweep.inv_h);
    let soft_mass = splat(simd, sweep.softness.mass);
    let soft_rate = splat(simd, sweep.softness.rate);
    let soft_impulse = splat(simd, sweep.softness.impulse);
    let cap = splat(simd, -sweep.cap);
    let deep = splat(simd, DEEP_RATE);
    let elapsed = splat(simd, sweep.elapsed);
    let mut vn = [zero; N];
    let mut gain = [zero; N];
    let mut bias = Bias { target: [zero; N], leak: [zero; N], floor: [zero; N] };
    let mut lambda = [zero; N];
    for j in 0..N {
        next.prefetch(5 + 4 * j..9 + 4 * j);
        let point = &block.points[j];
        let b = Vec3w::load(simd, &point.b);
        vn[j] = u + b.dot(vb.w);
        let mut s = load(simd, &point.s0) + moved + b.dot(xb.w);
        if !FIXED {
            let a = Vec3w::load(simd, &point.a);
            vn[j] -= a.dot(va.w);
            s -= a.dot(xa.w);
        }
        if let Some(extra) = extra.as_deref()
            && extra.drifts
        {
            let drift = load(simd, &extra.drift[j]);
            vn[j] += drift;
            s += drift * elapsed;
        }
        let mass = load(simd, &point.mass);
        let apart = above(s, zero);
        // Apart: the whole gap may close in this substep, no faster [Catto24]. Overlapping: soft.
        bias.target[j] = select(apart, mass * s * inv_h, mass * soft_rate * s);
        gain[j] = select(apart, mass, mass * soft_mass);
        bias.leak[j] = select(apart, zero, soft_impulse);
        bias.floor[j] = mass * min(cap, s * deep);
        lambda[j] = load(simd, &point.impulse);
        if let Some(extra) = extra.as_deref()
            && extra.softens
        {
            let of = ([s, vn[j], mass], j);
            soften(simd, extra, of, sweep, &mut bias, &mut gain);
        }
    }

    hold_parting(simd, block.parting, &mut bias.floor);
    let entry = lambda;
    let mut z = [zero; N];
    let mut response = [[zero; N]; N];
    for j in 0..N {
        next.prefetch(5 + 4 * N + 2 * j..7 + 4 * N + 2 * j);
        z[j] = gain[j] * vn[j];
        for i in 0..N {
            response[i][j] = gain[i] * load(simd, &block.k[K[i][j]]);
        }
    }
    for _ in 0..sweep.inner {
        solve_normals(&bias, &response, None, &mut lambda, &mut z);
    }
    if N > 1 {
        solve_eagerly(
            simd,
            block,
            &bias,
            &response,
            ([&vn, &gain, &entry], sweep.hit),
            &mut lambda,
            &mut z,
        );
    }
    next.prefetch(asked..half);
    let mut total = zero;
    let mut pushed = zero;
    let (mut turn_a, mut turn_b) = ([Vec3w::zero(simd); N], [Vec3w::zero(simd); N]);
    for j in 0..N {
        let point = &mut block.points[j];
        let d = lambda[j] - entry[j];
        pushed += d;
        total += lambda[j];
        turn_b[j] = Vec3w::load(simd, &point.b) * d;
        if !FIXED {
            turn_a[j] = Vec3w::load(simd, &point.a) * d;
        }
        lambda[j].store_array(&mut point.impulse);
    }
    vb.w = vb.w + sum(turn_b);
    if !FIXED {
        va.w = va.w - sum(turn_a);
    }
    if let Some(extra) = extra.as_deref_mut()
        && extra.rolls
    {
        resist_rolling(simd, extra, &mut va, &mut vb, total);
    }

    next.prefetch(half..last);
    note_pressed(block, above(total, zero));
    let limit = load(simd, &block.mu) * total;
    let of = extra.as_deref().map(|extra| (extra, elapsed));
    rub::<S, FIXED>(simd, block, of, &mut va, &mut vb, (n, pushed), limit);
    store_velocity(simd, solver_bodies, &block.row_b, vb);
    if !FIXED {
        store_velocity(simd, solver_bodies, &block.row_a, va);
    }
}

/// Sets the push-out limit of lanes under overlap correction to 0. Their approach is stopped, and
/// displacement at the step's end parts them: see `contact/part.rs`.
#[inline(always)]
fn hold_parting<S: Simd>(simd: S, lanes: u8, floors: &mut [Wide<S>]) {
    if lanes != 0 {
        let zero = splat(simd, 0.0);
        let parts = above(load(simd, &parting::lanes(lanes)), zero);
        for floor in floors {
            *floor = select(parts, zero, *floor);
        }
    }
}

/// Records the lanes that are pressed. Usually nothing changes, and skipping the write keeps the
/// cache line clean.
#[inline(always)]
fn note_pressed<S: Simd>(block: &mut ContactBlock, lanes: mask32x8<S>) {
    let pressed = block.pressed | lanes_of(lanes);
    if pressed != block.pressed {
        block.pressed = pressed;
    }
}

/// Sets the bias of point `j` for contacts with their own spring softness, at the separation `s`.
/// Before the surfaces meet there is no force, so a landing body keeps its speed until the spring
/// stops it. A relax sweep changes nothing, because it would remove the velocity that the spring
/// returns.
#[inline(always)]
fn soften<S: Simd, const N: usize>(
    simd: S,
    extra: &Extra,
    ([s, vn, mass], j): ([Wide<S>; 3], usize),
    sweep: &ContactSweep,
    bias: &mut Bias<S, N>,
    gain: &mut [Wide<S>; N],
) {
    let zero = splat(simd, 0.0);
    let soft_mass = load(simd, &extra.soft_mass);
    let is_soft = above(soft_mass, zero);
    if sweep.relaxes {
        for of in [&mut bias.target[j], &mut bias.leak[j], &mut gain[j]] {
            *of = select(is_soft, zero, *of);
        }
        return;
    }
    let reaches = s * splat(simd, sweep.inv_h) + vn;
    let apart = above(reaches, zero);
    let target =
        mass * select(apart, s * splat(simd, sweep.inv_h), load(simd, &extra.soft_rate) * s);
    let leak = select(apart, zero, load(simd, &extra.soft_impulse));
    let answer = select(apart, mass, mass * soft_mass);
    // A spring's push is not limited.
    bias.floor[j] = select(is_soft, splat(simd, f32::MIN), bias.floor[j]);
    bias.target[j] = select(is_soft, target, bias.target[j]);
    bias.leak[j] = select(is_soft, leak, bias.leak[j]);
    gain[j] = select(is_soft, answer, gain[j]);
}

/// Converts a mask to one bit for each lane.
#[inline(always)]
fn lanes_of<S: Simd>(mask: mask32x8<S>) -> u8 {
    #[expect(clippy::cast_possible_truncation, reason = "eight bits")]
    let lanes = bits(mask) as u8;
    lanes
}

/// Sums one, two or four vectors in pairs, for a short dependency chain.
#[inline(always)]
fn sum<S: Simd, const N: usize>(v: [Vec3w<S>; N]) -> Vec3w<S> {
    match N {
        1 => v[0],
        2 => v[0] + v[1],
        _ => (v[0] + v[1]) + (v[2] + v[3]),
    }
}

/// Solves friction along both tangents and twist about the normal, at the middle of the manifold.
/// Also applies the linear part of the normal impulses, `pushed`, which does not affect these rows.
///
/// The twist row is measured at the contact's reach, so its impulse has friction's limit, and the
/// three impulses together lie in a ball: the ellipsoidal limit surface
/// (docs/derivations/friction.md).
#[inline(always)]
fn rub<S: Simd, const FIXED: bool>(
    simd: S,
    block: &mut ContactBlock,
    extra: Option<(&Extra, Wide<S>)>,
    va: &mut Velocity<S>,
    vb: &mut Velocity<S>,
    (n, pushed): (Vec3w<S>, Wide<S>),
    limit: Wide<S>,
) {
    let beta = load(simd, &block.beta);
    let b = Vec3w::load3(simd, &block.b_t);
    let mut a = b;
    let (t1, t2) = (Vec3w::load(simd, &block.t1), Vec3w::load(simd, &block.t2));
    let mut dv = vb.v * beta;
    if !FIXED {
        a = Vec3w::load3(simd, &block.a_t);
        dv = dv - va.v * load(simd, &block.alpha);
    }
    let mut s1 = t1.dot(dv) + b[0].dot(vb.w);
    let mut s2 = t2.dot(dv) + b[1].dot(vb.w);
    let mut s3 = b[2].dot(vb.w);
    if !FIXED {
        s1 -= a[0].dot(va.w);
        s2 -= a[1].dot(va.w);
        s3 -= a[2].dot(va.w);
    }
    let mut kinetic = limit;
    if let Some((extra, elapsed)) = extra {
        if extra.drifts {
            s1 += load(simd, &extra.drift_t[0]) + load(simd, &extra.drift_rate[0]) * elapsed;
            s2 += load(simd, &extra.drift_t[1]) + load(simd, &extra.drift_rate[1]) * elapsed;
            s3 += load(simd, &extra.drift_t[2]);
        }
        if extra.slips {
            kinetic = limit * load(simd, &extra.kinetic);
        }
    }
    let [m11, m12, m22] =
        [load(simd, &block.mass_t[0]), load(simd, &block.mass_t[1]), load(simd, &block.mass_t[2])];
    let [m13, m23, m33] =
        [load(simd, &block.mass_t[3]), load(simd, &block.mass_t[4]), load(simd, &block.mass_t[5])];
    let f1 = load(simd, &block.friction[0]);
    let f2 = load(simd, &block.friction[1]);
    let f3 = load(simd, &block.friction[2]);
    // Impulses that stop all three rows at once.
    let mut g1 = f1 - (m11 * s1 + m12 * s2 + m13 * s3);
    let mut g2 = f2 - (m12 * s1 + m22 * s2 + m23 * s3);
    let mut g3 = f3 - (m13 * s1 + m23 * s2 + m33 * s3);
    let slides = above(g1 * g1 + g2 * g2 + g3 * g3, limit * limit);
    // Beyond the limit: step against the motion by the same step size for all rows, then project
    // onto the ball. This converges where the impulse opposes the motion, which a step by the
    // inverse matrix does not.
    if slides.any_true() {
        let step = load(simd, &block.mass_slide);
        let (z1, z2, z3) = (f1 - step * s1, f2 - step * s2, f3 - step * s3);
        let square = z1 * z1 + z2 * z2 + z3 * z3;
        let one = splat(simd, 1.0);
        let back = select(above(square, kinetic * kinetic), kinetic / sqrt(square), one);
        g1 = select(slides, z1 * back, g1);
        g2 = select(slides, z2 * back, g2);
        g3 = select(slides, z3 * back, g3);
    }
    let (d1, d2, d3) = (g1 - f1, g2 - f2, g3 - f3);
    g1.store_array(&mut block.friction[0]);
    g2.store_array(&mut block.friction[1]);
    g3.store_array(&mut block.friction[2]);
    let p = n * pushed + t1 * d1 + t2 * d2;
    vb.v = vb.v + p * beta;
    vb.w = vb.w + b[0] * d1 + b[1] * d2 + b[2] * d3;
    if !FIXED {
        va.v = va.v - p * load(simd, &block.alpha);
        va.w = va.w - a[0] * d1 - a[1] * d2 - a[2] * d3;
    }
}

/// Applies rolling resistance: an angular impulse against the relative angular velocity, at most
/// the rolling length times the normal impulse.
#[inline(always)]
fn resist_rolling<S: Simd>(
    simd: S,
    extra: &mut Extra,
    va: &mut Velocity<S>,
    vb: &mut Velocity<S>,
    normal: Wide<S>,
) {
    let (sa, sb) = (Sym3w::load(simd, &extra.s_a), Sym3w::load(simd, &extra.s_b));
    let relative = sb.mul(vb.w) - sa.mul(va.w);
    let k = square_sum(sa, sb);
    let old = Vec3w::load(simd, &extra.rolling_impulse);
    let new = old - k.solve(simd, relative);
    let limit = load(simd, &extra.rolling) * normal;
    let length = sqrt(max(new.dot(new), splat(simd, 1.0e-30)));
    let new = new * min(limit / length, splat(simd, 1.0));
    let d = new - old;
    new.store(&mut extra.rolling_impulse);
    va.w = va.w - sa.mul(d);
    vb.w = vb.w + sb.mul(d);
}

/// S²
#[inline(always)]
fn square<S: Simd>(m: Sym3w<S>) -> Sym3w<S> {
    Sym3w {
        xx: m.xx * m.xx + m.xy * m.xy + m.xz * m.xz,
        yy: m.xy * m.xy + m.yy * m.yy + m.yz * m.yz,
        zz: m.xz * m.xz + m.yz * m.yz + m.zz * m.zz,
        xy: m.xx * m.xy + m.xy * m.yy + m.xz * m.yz,
        xz: m.xx * m.xz + m.xy * m.yz + m.xz * m.zz,
        yz: m.xy * m.xz + m.yy * m.yz + m.yz * m.zz,
    }
}

/// S_A² + S_B²: the sum of the inverse inertias.
#[inline(always)]
fn square_sum<S: Simd>(a: Sym3w<S>, b: Sym3w<S>) -> Sym3w<S> {
    let (a, b) = (square(a), square(b));
    Sym3w {
        xx: a.xx + b.xx,
        yy: a.yy + b.yy,
        zz: a.zz + b.zz,
        xy: a.xy + b.xy,
        xz: a.xz + b.xz,
        yz: a.yz + b.yz,
    }
}
