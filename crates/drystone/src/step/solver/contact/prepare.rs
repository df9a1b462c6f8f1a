//! Builds contact blocks: loads manifolds into lanes, builds the rows in wide arithmetic, and
//! applies the warm start in the same pass.

use fearless_simd::{Simd, SimdBase, SimdMask, mask32x8};

use super::block::{ContactBlock, Extra, K};
use super::parting;
use super::raw::{Raw, Source};
use super::surface::{corotation, may_impact, pack_extra};
use crate::base::simd::wide::{
    LANES, Sym3w, Vec3w, Wide, above, bits, inverse_or_zero, load, max, min, select, splat, sqrt,
};
use crate::base::threads::disjoint::Rows;
use crate::step::solver_body::{SolverBody, Whitening, load_velocity, read_lanes, store_velocity};

/// Fills a block from up to eight contacts and applies their impulses to the solver bodies.
/// `FIXED`: only one body of each contact can be pushed.
#[inline(always)]
pub(crate) fn pack<S: Simd, const FIXED: bool>(
    simd: S,
    source: &Source<'_>,
    owners: &[u32; LANES],
    block: &mut ContactBlock,
    extra: Option<&mut Extra>,
    solver_bodies: &Rows<'_, SolverBody>,
) {
    let Some(warm) = build::<S, FIXED>(simd, source, owners, block, extra) else { return };
    // v̂ += M^-½ Jᵀ λ for the impulses of the last step.
    let mut vb = load_velocity(simd, solver_bodies, &block.row_b);
    vb.v = vb.v + warm.push * load(simd, &block.beta);
    vb.w = vb.w + warm.turn_b;
    store_velocity(simd, solver_bodies, &block.row_b, vb);
    if !FIXED {
        let mut va = load_velocity(simd, solver_bodies, &block.row_a);
        va.v = va.v - warm.push * load(simd, &block.alpha);
        va.w = va.w - warm.turn_a;
        store_velocity(simd, solver_bodies, &block.row_a, va);
    }
}

/// Fills a block from up to eight contacts; `None` if there is none.
#[inline(always)]
pub(crate) fn build<S: Simd, const FIXED: bool>(
    simd: S,
    source: &Source<'_>,
    owners: &[u32; LANES],
    block: &mut ContactBlock,
    extra: Option<&mut Extra>,
) -> Option<Warm<S>> {
    let Some(raw) = Raw::load::<FIXED>(source, owners) else {
        // The buffer may contain rows of other groups, which must not push anything.
        (block.row_a, block.row_b, block.parting) = ([0; LANES], [0; LANES], 0);
        (block.arrives, block.hit) = (0, 0);
        return None;
    };
    (block.row_a, block.row_b) = (raw.row_a, raw.row_b);
    (block.count, block.pressed, block.parting) = (0, 0, 0);
    (block.arrives, block.hit, block.is_renewed) = (0, 0, source.is_renewed);
    for c in raw.contacts {
        block.count = block.count.max(c.count);
    }
    block.landing = raw.landing;
    let room = if block.count < 3 { block.count } else { 4 };
    block.is_mixed = false;
    for c in raw.contacts {
        block.is_mixed |= c.count != room;
    }
    let mut warm = match block.count {
        1 => build_rows::<S, FIXED, 1>(simd, source, &raw, block),
        2 => build_rows::<S, FIXED, 2>(simd, source, &raw, block),
        _ => build_rows::<S, FIXED, 4>(simd, source, &raw, block),
    };
    if source.may_impact {
        block.arrives = may_impact(source, &raw, owners);
    }
    if let Some(extra) = extra {
        *extra = Extra { kinetic: [1.0; LANES], ..Extra::default() };
        for lane in 0..LANES {
            if owners[lane] != u32::MAX {
                let arrives = pack_extra::<FIXED>(source, &raw, (lane, owners[lane]), extra);
                block.arrives |= u8::from(arrives) << lane;
            }
        }
        if let Some(rate) = &warm.grows {
            extra.corotate(simd, rate, source.ctx);
        }
        if extra.drifts {
            let spin = load(simd, &extra.drift_t[2]) * warm.reach;
            spin.store_array(&mut extra.drift_t[2]);
        }
        if extra.rolls {
            let impulse = Vec3w::load(simd, &extra.rolling_impulse);
            warm.turn_a = warm.turn_a + Sym3w::load(simd, &extra.s_a).mul(impulse);
            warm.turn_b = warm.turn_b + Sym3w::load(simd, &extra.s_b).mul(impulse);
        }
    }
    Some(warm)
}

/// The warm start: a linear impulse, and the angular changes of A and B.
pub(crate) struct Warm<S: Simd> {
    push: Vec3w<S>,
    turn_a: Vec3w<S>,
    turn_b: Vec3w<S>,
    /// Lever arm at which twist is measured [m].
    reach: Wide<S>,
    /// Rate of change of the tangential velocity between bodies that rotate together [m/s²].
    grows: Option<[Wide<S>; 2]>,
}

#[inline(always)]
fn build_rows<S: Simd, const FIXED: bool, const N: usize>(
    simd: S,
    source: &Source<'_>,
    raw: &Raw<'_>,
    block: &mut ContactBlock,
) -> Warm<S> {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let (beta, sb) = Whitening::gather(simd, read_lanes(source.whitening, &raw.row_b));
    let (beta, sb) = if FIXED {
        let sign = load(simd, &raw.sign);
        (beta * sign, sb.scaled(sign))
    } else {
        (beta, sb)
    };
    beta.store_array(&mut block.beta);
    let mut linear = beta * beta;
    let mut sa = sb;
    if !FIXED {
        let (alpha, s) = Whitening::gather(simd, read_lanes(source.whitening, &raw.row_a));
        alpha.store_array(&mut block.alpha);
        linear = alpha * alpha + linear;
        sa = s;
    }
    let [[x, y, z, mu], tangent] = raw.common(simd);
    let n = Vec3w { x, y, z };
    let t1 = n.any_perpendicular(simd);
    let t2 = t1.cross(n);
    n.store(&mut block.n);
    t1.store(&mut block.t1);
    t2.store(&mut block.t2);
    mu.store_array(&mut block.mu);

    let offset = raw.offset(simd);
    let count = load(simd, &raw.count);
    let mut scale = splat(simd, source.ctx.impulse_scale);
    let inv_margin = splat(simd, 1.0 / source.ctx.margin);
    let rest_offset = splat(simd, source.ctx.rest_offset);
    let settled = load(simd, &raw.settled);
    let zeros = Vec3w::zero(simd);
    let turned = above(zero, load(simd, &raw.sign));
    let (mut a, mut b, mut rb, mut there) = ([zeros; N], [zeros; N], [zeros; N], [zero; N]);
    let (mut ca, mut cb, mut weight, mut gap) = (zeros, zeros, zero, zero);
    let mut weights = [zero; N];
    let (mut total, mut maximum, mut lowest) = (zero, zero, zero);
    let (mut turn_a, mut turn_b) = (zeros, zeros);
    for j in 0..N {
        #[expect(clippy::cast_precision_loss, reason = "below 4")]
        let is_there = above(count, splat(simd, j as f32 + 0.5));
        there[j] = select(is_there, one, zero);
        let ([x, y, z, s], impulse) = raw.point(simd, j);
        let arm = Vec3w { x, y, z };
        let arm_a = Vec3w::select(is_there, arm, zeros);
        let arm_b = Vec3w::select(is_there, arm - offset, zeros);
        let s0 = select(is_there, s - rest_offset - settled, zero);
        let impulse = select(is_there, impulse, zero);
        lowest = min(lowest, s0);
        maximum = max(maximum, impulse);
        let impulse = impulse * scale;
        let point = &mut block.points[j];
        // Friction acts at the middle of the close points.
        let w = min(max(one - s0 * inv_margin, splat(simd, 0.01)), one) * there[j];
        weights[j] = w;
        gap += max(s0, zero) * w;
        s0.store_array(&mut point.s0);
        impulse.store_array(&mut point.impulse);
        rb[j] = arm_b;
        if FIXED {
            let arm = Vec3w::select(turned, arm_a, arm_b);
            rb[j] = arm;
            b[j] = sb.mul(arm.cross(n));
            cb = cb + arm * w;
        } else {
            a[j] = sa.mul(arm_a.cross(n));
            b[j] = sb.mul(arm_b.cross(n));
            a[j].store(&mut point.a);
            cb = cb + arm_b * w;
            turn_a = turn_a + a[j] * impulse;
        }
        ca = ca + arm_a * w;
        b[j].store(&mut point.b);
        turn_b = turn_b + b[j] * impulse;
        total += impulse;
        weight += w;
    }
    if let Some(part) = kept(simd, block, maximum * scale * linear, source.ctx.warm_max) {
        (turn_a, turn_b, total) = (turn_a * part, turn_b * part, total * part);
        scale *= part;
    }
    put_masses::<S, FIXED, N>(simd, linear, [&a, &b], &there, block);
    let is_deep = || bits(above(splat(simd, -source.ctx.deep), lowest)) != 0;
    if source.parts && (raw.parts || !source.is_renewed && is_deep()) {
        block.parting = parting::mark::<FIXED>(source, raw, block);
    }
    let share = inverse_or_zero(simd, weight);
    (ca, cb) = (ca * share, cb * share);
    let mut grows = None;
    if !FIXED && let Some(turns) = &raw.turns {
        let ([a, b], rate) = corotation(simd, turns, [ca, cb], 0.5 * source.ctx.dt);
        (ca, cb) = (a, b);
        grows = Some([t1.dot(rate), t2.dot(rate)]);
    }
    let reach = reach_of(simd, raw, cb, &rb, &weights, [share, mu]);
    // Friction acts on the surfaces; a lever arm to the middle of a gap does not reach them yet.
    let gap = n * (gap * share * splat(simd, 0.5));
    if FIXED {
        cb = cb + gap * load(simd, &raw.sign);
    } else {
        cb = cb + gap;
        ca = ca - gap;
    }

    let settling = above(select(above(maximum, zero), zero, count), splat(simd, 2.5));
    let arms = Arms { sa, sb, ca, cb, linear, reach, settling };
    let f = build_friction::<S, FIXED>(simd, &arms, [n, t1, t2], block);
    let [tx, ty, tz, twist] = tangent;
    let tangent = Vec3w { x: tx, y: ty, z: tz };
    let busy = above(count, zero);
    let impulse = [
        select(busy, t1.dot(tangent) * scale, zero),
        select(busy, t2.dot(tangent) * scale, zero),
        select(above(reach, zero), twist * scale, zero),
    ];
    for i in 0..3 {
        impulse[i].store_array(&mut block.friction[i]);
        turn_a = turn_a + f[0][i] * impulse[i];
        turn_b = turn_b + f[1][i] * impulse[i];
    }

    mark_fresh(simd, block, count, maximum);
    let push = n * total + t1 * impulse[0] + t2 * impulse[1];
    Warm { push, turn_a, turn_b, reach, grows }
}

/// Computes K of each pair of points, and the effective mass of each point: 1/K_jj, 0 for missing
/// points.
#[inline(always)]
fn put_masses<S: Simd, const FIXED: bool, const N: usize>(
    simd: S,
    linear: Wide<S>,
    [a, b]: [&[Vec3w<S>; N]; 2],
    there: &[Wide<S>; N],
    block: &mut ContactBlock,
) {
    for j in 0..N {
        for i in 0..=j {
            let mut k = linear;
            if !FIXED {
                k += a[i].dot(a[j]);
            }
            k += b[i].dot(b[j]);
            k.store_array(&mut block.k[K[i][j]]);
            if i == j {
                (inverse_or_zero(simd, k) * there[j]).store_array(&mut block.points[j].mass);
            }
        }
    }
}

/// Limits the warm start of contacts to impulses that give their bodies a speed of `maximum`, and
/// returns the factor; `None`: no change. `speeds`: the speeds that their maximum impulses would
/// give.
///
/// A body caught between two immovable ones builds up impulses without bound, far beyond any
/// weight. When one of the two disappears, the sweep that removes the other's impulse leaves a part
/// of it, which threw a crate out at 31 m/s.
#[inline(always)]
fn kept<S: Simd>(
    simd: S,
    block: &mut ContactBlock,
    speeds: Wide<S>,
    maximum: f32,
) -> Option<Wide<S>> {
    let maximum = splat(simd, maximum);
    if bits(above(speeds, maximum)) == 0 {
        return None;
    }
    let part = min(splat(simd, 1.0), maximum / max(speeds, maximum));
    for point in &mut block.points {
        (load(simd, &point.impulse) * part).store_array(&mut point.impulse);
    }
    Some(part)
}

/// Marks the contacts without a warm start, which get more rounds. Impulses are never negative, so
/// the maximum is zero where all are. A lone point needs no rounds and gets none, whatever contacts
/// share its block.
#[inline(always)]
fn mark_fresh<S: Simd>(simd: S, block: &mut ContactBlock, count: Wide<S>, maximum: Wide<S>) {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let several = select(above(count, splat(simd, 1.5)), one, zero);
    select(above(maximum, zero), zero, several).store_array(&mut block.fresh);
    block.any_fresh = false;
    for fresh in &block.fresh {
        block.any_fresh |= *fresh > 0.0;
    }
}

/// Reach at which twist is measured. It is the mean distance of the points from the middle, times a
/// correction for the area that they enclose: the ratio of the area's mean distance to theirs.
/// Spinning resistance increases it.
#[inline(always)]
fn reach_of<S: Simd, const N: usize>(
    simd: S,
    raw: &Raw<'_>,
    middle: Vec3w<S>,
    arms: &[Vec3w<S>; N],
    weights: &[Wide<S>; N],
    [share, mu]: [Wide<S>; 2],
) -> Wide<S> {
    let mut sum = splat(simd, 0.0);
    if N > 1 {
        for j in 0..N {
            let arm = arms[j] - middle;
            sum += sqrt(arm.dot(arm)) * weights[j];
        }
    }
    let count = load(simd, &raw.count);
    let is_face = above(count, splat(simd, 2.5));
    let mut reach = sum * share * select(is_face, load(simd, &raw.patch), splat(simd, 0.5));
    // A lone point beside contacts with more points has zero reach, free of rounding.
    reach = select(above(count, splat(simd, 1.5)), reach, splat(simd, 0.0));
    if raw.spins {
        reach += load(simd, &raw.spinning) * inverse_or_zero(simd, mu);
    }
    reach
}

/// Lever arms at which friction acts.
struct Arms<S: Simd> {
    sa: Sym3w<S>,
    sb: Sym3w<S>,
    ca: Vec3w<S>,
    cb: Vec3w<S>,
    /// α² + β²
    linear: Wide<S>,
    /// Lever arm at which twist is measured [m].
    reach: Wide<S>,
    /// Fresh contacts of three points or more.
    settling: mask32x8<S>,
}

/// Rows of each element of their matrix, in the order of [`ContactBlock::mass_t`].
const PAIRS: [[usize; 2]; 6] = [[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2]];

/// Builds the rows of friction along t1 and t2, and of twist about n. Returns the rows of A and of
/// B.
#[inline(always)]
fn build_friction<S: Simd, const FIXED: bool>(
    simd: S,
    arms: &Arms<S>,
    [n, t1, t2]: [Vec3w<S>; 3],
    block: &mut ContactBlock,
) -> [[Vec3w<S>; 3]; 2] {
    let Arms { sa, sb, ca, cb, linear, reach, settling } = *arms;
    let zero = splat(simd, 0.0);
    let mut at = [Vec3w::zero(simd); 3];
    let turn = n * reach;
    let bt = [sb.mul(cb.cross(t1)), sb.mul(cb.cross(t2)), sb.mul(turn)];
    let mut k = [linear, zero, linear, zero, zero, zero];
    if !FIXED {
        at = [sa.mul(ca.cross(t1)), sa.mul(ca.cross(t2)), sa.mul(turn)];
        for i in 0..6 {
            k[i] += at[PAIRS[i][0]].dot(at[PAIRS[i][1]]);
        }
        for i in 0..3 {
            at[i].store(&mut block.a_t[i]);
        }
    }
    for i in 0..6 {
        k[i] += bt[PAIRS[i][0]].dot(bt[PAIRS[i][1]]);
    }
    for i in 0..3 {
        bt[i].store(&mut block.b_t[i]);
    }
    // First the tangents, then twist by Schur's complement. Without a reach there is no twist, and
    // zeros are left.
    //
    // In a contact on a face, the normal points take back the rotation that friction's impulse
    // gives the body. Rows that count on that rotation take several substeps to stop a body, until
    // their impulses are known. So for a fresh contact the rows ignore rotation as far as that
    // keeps the step below 1.6 times that of a free body. At 2 a step would no longer remove
    // energy. (In every step, four cubes on a slope never came to rest.)
    if settling.any_true() {
        let turn = max(k[0], k[2]) - linear;
        let minimum =
            splat(simd, 0.625) - splat(simd, 0.375) * linear * inverse_or_zero(simd, turn);
        let part = max(minimum, zero);
        for i in 0..5 {
            let own = [linear, zero, linear, zero, zero][i];
            k[i] = select(settling, own + part * (k[i] - own), k[i]);
        }
    }
    let [k11, k12, k22, k13, k23, k33] = k;
    let inv = inverse_or_zero(simd, k11 * k22 - k12 * k12);
    let (m11, m12, m22) = (k22 * inv, -(k12 * inv), k11 * inv);
    let (e1, e2) = (m11 * k13 + m12 * k23, m12 * k13 + m22 * k23);
    let left = k33 - (k13 * e1 + k23 * e2);
    // There is no twist at a reach of rounding size either: its inverse would overflow.
    let minimum = max(k33 * splat(simd, 1.0e-5), k11 * splat(simd, 1.0e-12));
    let m33 = select(above(left, minimum), inverse_or_zero(simd, left), zero);
    let m = [
        m11 + e1 * e1 * m33,
        m12 + e1 * e2 * m33,
        m22 + e2 * e2 * m33,
        -(e1 * m33),
        -(e2 * m33),
        m33,
    ];
    for i in 0..6 {
        m[i].store_array(&mut block.mass_t[i]);
    }
    // The root of the sum of squares bounds every eigenvalue, so a step by its inverse never
    // overshoots.
    let off = k12 * k12 + k13 * k13 + k23 * k23;
    let norm = sqrt(k11 * k11 + k22 * k22 + k33 * k33 + (off + off));
    inverse_or_zero(simd, norm).store_array(&mut block.mass_slide);
    [at, bt]
}
