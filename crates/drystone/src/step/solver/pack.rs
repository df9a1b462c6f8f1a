//! Contacts to blocks and back: gathers manifolds into lanes, builds the rows in wide arithmetic with
//! the warm start fused in, and stores the impulses after the last sweep.

use fearless_simd::{Simd, SimdBase};

use super::contact::K;
use super::rows::{ContactBlock, Extra, Line, Whitening, load_velocity, store_velocity};
use crate::base::disjoint::Rows;
use crate::base::math::Vec3;
use crate::base::wide::{LANES, Lanes, Sym3w, Vec3w, inverse_or_zero, load, max, min, splat, sqrt};
use crate::state::bodies::{Bodies, Body};
use crate::state::contacts::Contact;
use crate::step::context::StepContext;

/// What packing reads.
pub(super) struct Source<'a> {
    pub(super) ctx: &'a StepContext,
    pub(super) bodies: &'a Bodies,
    /// Line of each body row; 0 for what cannot be pushed.
    pub(super) line_of: &'a [u32],
    pub(super) whitening: &'a [Whitening],
    /// Acceleration of each line [m/s²].
    pub(super) acceleration: &'a [Vec3],
    /// Impulses are for substeps of another length: their factor.
    pub(super) impulse_scale: f32,
}

/// A block's numbers before rows are built.
#[derive(Default)]
struct Raw {
    r_a: [[Lanes; 3]; 4],
    r_b: [[Lanes; 3]; 4],
    s_a: [Lanes; 6],
    s_b: [Lanes; 6],
    /// 1 where the point exists.
    there: [Lanes; 4],
}

#[inline(always)]
fn put(lanes: &mut [Lanes; 3], lane: usize, v: Vec3) {
    lanes[0][lane] = v.x;
    lanes[1][lane] = v.y;
    lanes[2][lane] = v.z;
}

/// Fills a block from up to eight contacts and applies their impulses to the lines.
#[inline(always)]
pub(super) fn pack<S: Simd>(
    simd: S,
    source: &Source<'_>,
    members: &[u32],
    contacts: &Rows<'_, Option<Contact>>,
    block: &mut ContactBlock,
    mut extra: Option<&mut Extra>,
    lines: &Rows<'_, Line>,
) {
    *block = ContactBlock::default();
    if let Some(extra) = extra.as_deref_mut() {
        *extra = Extra::default();
    }
    let mut raw = Raw::default();
    for (lane, member) in members.iter().enumerate() {
        let Some(c) = contacts.read(*member as usize) else { continue };
        block.contact[lane] = *member;
        pack_contact(source, c, block, lane, &mut raw);
        if let Some(extra) = extra.as_deref_mut() {
            pack_extra(source, c, block, lane, &raw, extra);
        }
    }
    build_rows(simd, source, block, &raw);
    if let Some(extra) = extra.as_deref_mut() {
        finish_drift(block, extra);
    }
    warm_start(simd, block, extra.as_deref(), lines);
}

#[inline(always)]
fn pack_contact(
    source: &Source<'_>,
    c: &Contact,
    block: &mut ContactBlock,
    lane: usize,
    raw: &mut Raw,
) {
    let (la, lb) = (source.line_of[c.body_a as usize], source.line_of[c.body_b as usize]);
    (block.row_a[lane], block.row_b[lane]) = (la, lb);
    let (wa, wb) = (&source.whitening[la as usize], &source.whitening[lb as usize]);
    (block.alpha[lane], block.beta[lane]) = (wa.alpha, wb.alpha);
    for i in 0..6 {
        raw.s_a[i][lane] = wa.s[i];
        raw.s_b[i][lane] = wb.s[i];
    }
    let t1 = c.normal.any_perpendicular();
    let t2 = t1.cross(c.normal);
    put(&mut block.n, lane, c.normal);
    put(&mut block.t1, lane, t1);
    put(&mut block.t2, lane, t2);
    block.mu[lane] = c.friction;
    block.friction[0][lane] = t1.dot(c.tangent_impulse) * source.impulse_scale;
    block.friction[1][lane] = t2.dot(c.tangent_impulse) * source.impulse_scale;
    block.friction[2][lane] = c.twist_impulse * source.impulse_scale;
    block.points = block.points.max(u32::from(c.count));
    if c.points().iter().all(|p| p.impulse == 0.0) {
        block.fresh[lane] = 1.0;
        block.any_fresh = true;
    }
    for (j, p) in c.points().iter().enumerate() {
        put(&mut raw.r_a[j], lane, p.r_a);
        put(&mut raw.r_b[j], lane, p.r_b);
        raw.there[j][lane] = 1.0;
        block.s0[j][lane] = p.separation - source.ctx.rest_offset;
        block.impulse[j][lane] = p.impulse * source.impulse_scale;
    }
}

/// Bounce, rolling and drift of one contact.
fn pack_extra(
    source: &Source<'_>,
    c: &Contact,
    block: &ContactBlock,
    lane: usize,
    raw: &Raw,
    extra: &mut Extra,
) {
    let (a, b) = (source.bodies.at(c.body_a), source.bodies.at(c.body_b));
    if c.restitution > 0.0 {
        let acc = |row: u32| source.acceleration[row as usize];
        let fall = c.normal.dot(acc(block.row_b[lane]) - acc(block.row_a[lane]));
        extra.fall[lane] = 2.0 * fall;
        for (j, p) in c.points().iter().enumerate() {
            // Speed at the impact, from the speed and the height now [solver notes F.7].
            let now = c.normal.dot(b.velocity_at(p.r_b) - a.velocity_at(p.r_a));
            let square = now * now - 2.0 * fall * p.separation.max(0.0);
            let limit = source.ctx.restitution_speed;
            if now + fall * source.ctx.dt < 0.0 && square > limit * limit {
                extra.bounces = true;
                extra.bounce[j][lane] = c.restitution * c.restitution * square;
            }
        }
    }
    if c.rolling > 0.0 {
        extra.rolls = true;
        extra.rolling[lane] = c.rolling;
        for i in 0..6 {
            extra.s_a[i][lane] = raw.s_a[i][lane];
            extra.s_b[i][lane] = raw.s_b[i][lane];
        }
        put(&mut extra.rolling_impulse, lane, c.rolling_impulse * source.impulse_scale);
    }
    let moves = |b: &Body| !b.is_dynamic() && b.active();
    if moves(a) || moves(b) {
        extra.drifts = true;
        let mut center = Vec3::ZERO;
        for (j, p) in c.points().iter().enumerate() {
            let v = drift_velocity(b, p.r_b) - drift_velocity(a, p.r_a);
            extra.drift[j][lane] = c.normal.dot(v);
            center += v;
        }
        let mean = center * (1.0 / f32::from(c.count.max(1)));
        let spin = |b: &Body| if moves(b) { b.w } else { Vec3::ZERO };
        // Directions are those of friction's rows; see `finish_drift`.
        put(&mut extra.drift_t, lane, mean);
        extra.drift_t[2][lane] = c.normal.dot(spin(b) - spin(a));
        let t1 = c.normal.any_perpendicular();
        extra.drift_t[0][lane] = t1.dot(mean);
        extra.drift_t[1][lane] = t1.cross(c.normal).dot(mean);
    }
}

/// Velocity of a point of a moving kinematic body; zero of any other.
fn drift_velocity(body: &Body, r: Vec3) -> Vec3 {
    if !body.is_dynamic() && body.active() { body.velocity_at(r) } else { Vec3::ZERO }
}

/// Points that are not there must not read the drift of a point that is.
fn finish_drift(block: &ContactBlock, extra: &mut Extra) {
    for j in 0..4 {
        for lane in 0..LANES {
            if block.mass[j][lane] == 0.0 {
                extra.drift[j][lane] = 0.0;
            }
        }
    }
}

#[inline(always)]
fn build_rows<S: Simd>(simd: S, source: &Source<'_>, block: &mut ContactBlock, raw: &Raw) {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let (alpha, beta) = (load(simd, &block.alpha), load(simd, &block.beta));
    let linear = alpha * alpha + beta * beta;
    let n = Vec3w::load(simd, &block.n);
    let (sa, sb) = (Sym3w::load(simd, &raw.s_a), Sym3w::load(simd, &raw.s_b));

    let (mut a, mut b) = ([Vec3w::zero(simd); 4], [Vec3w::zero(simd); 4]);
    let (mut ca, mut cb, mut weight) = (Vec3w::zero(simd), Vec3w::zero(simd), zero);
    let inv_margin = splat(simd, 1.0 / source.ctx.margin);
    let least = splat(simd, 0.01);
    for j in 0..4 {
        let (ra, rb) = (Vec3w::load(simd, &raw.r_a[j]), Vec3w::load(simd, &raw.r_b[j]));
        a[j] = sa.mul(ra.cross(n));
        b[j] = sb.mul(rb.cross(n));
        a[j].store(&mut block.a[j]);
        b[j].store(&mut block.b[j]);
        // Friction acts at the middle of what is close.
        let near = min(max(one - load(simd, &block.s0[j]) * inv_margin, least), one);
        let w = near * load(simd, &raw.there[j]);
        ca = ca + ra * w;
        cb = cb + rb * w;
        weight += w;
    }
    for i in 0..4 {
        for j in i..4 {
            let k = linear + a[i].dot(a[j]) + b[i].dot(b[j]);
            k.store_array(&mut block.k[K[i][j]]);
            if i == j {
                (inverse_or_zero(simd, k) * load(simd, &raw.there[j]))
                    .store_array(&mut block.mass[j]);
            }
        }
    }
    let share = inverse_or_zero(simd, weight);
    (ca, cb) = (ca * share, cb * share);
    for j in 0..4 {
        let arm = Vec3w::load(simd, &raw.r_a[j]) - ca;
        (sqrt(arm.dot(arm)) * load(simd, &raw.there[j])).store_array(&mut block.lever[j]);
    }
    let (t1, t2) = (Vec3w::load(simd, &block.t1), Vec3w::load(simd, &block.t2));
    let at = [sa.mul(ca.cross(t1)), sa.mul(ca.cross(t2)), sa.mul(n)];
    let bt = [sb.mul(cb.cross(t1)), sb.mul(cb.cross(t2)), sb.mul(n)];
    for i in 0..3 {
        at[i].store(&mut block.a_t[i]);
        bt[i].store(&mut block.b_t[i]);
    }
    let k11 = linear + at[0].dot(at[0]) + bt[0].dot(bt[0]);
    let k12 = at[0].dot(at[1]) + bt[0].dot(bt[1]);
    let k22 = linear + at[1].dot(at[1]) + bt[1].dot(bt[1]);
    let inv = inverse_or_zero(simd, k11 * k22 - k12 * k12);
    (k22 * inv).store_array(&mut block.mass_t[0]);
    (-(k12 * inv)).store_array(&mut block.mass_t[1]);
    (k11 * inv).store_array(&mut block.mass_t[2]);
    inverse_or_zero(simd, at[2].dot(at[2]) + bt[2].dot(bt[2])).store_array(&mut block.mass_t[3]);
}

/// v̂ += M^-½ Jᵀ λ for the impulses of the last step.
#[inline(always)]
fn warm_start<S: Simd>(
    simd: S,
    block: &ContactBlock,
    extra: Option<&Extra>,
    lines: &Rows<'_, Line>,
) {
    let (alpha, beta) = (load(simd, &block.alpha), load(simd, &block.beta));
    let mut va = load_velocity(simd, lines, &block.row_a);
    let mut vb = load_velocity(simd, lines, &block.row_b);
    let f1 = load(simd, &block.friction[0]);
    let f2 = load(simd, &block.friction[1]);
    let f3 = load(simd, &block.friction[2]);
    let (t1, t2) = (Vec3w::load(simd, &block.t1), Vec3w::load(simd, &block.t2));
    let mut total = splat(simd, 0.0);
    let (mut turn_a, mut turn_b) = (Vec3w::zero(simd), Vec3w::zero(simd));
    for j in 0..4 {
        let lambda = load(simd, &block.impulse[j]);
        total += lambda;
        turn_a = turn_a + Vec3w::load(simd, &block.a[j]) * lambda;
        turn_b = turn_b + Vec3w::load(simd, &block.b[j]) * lambda;
    }
    let f = [f1, f2, f3];
    for i in 0..3 {
        turn_a = turn_a + Vec3w::load(simd, &block.a_t[i]) * f[i];
        turn_b = turn_b + Vec3w::load(simd, &block.b_t[i]) * f[i];
    }
    if let Some(extra) = extra
        && extra.rolls
    {
        let impulse = Vec3w::load(simd, &extra.rolling_impulse);
        turn_a = turn_a + Sym3w::load(simd, &extra.s_a).mul(impulse);
        turn_b = turn_b + Sym3w::load(simd, &extra.s_b).mul(impulse);
    }
    let p = Vec3w::load(simd, &block.n) * total + t1 * f1 + t2 * f2;
    va.v = va.v - p * alpha;
    vb.v = vb.v + p * beta;
    va.w = va.w - turn_a;
    vb.w = vb.w + turn_b;
    store_velocity(simd, lines, &block.row_a, va);
    store_velocity(simd, lines, &block.row_b, vb);
}

/// Writes a block's impulses back; rows whose touch is new go to `begun`.
pub(super) fn store(
    block: &ContactBlock,
    extra: Option<&Extra>,
    contacts: &Rows<'_, Option<Contact>>,
    begun: &mut Vec<u32>,
) {
    for lane in 0..LANES {
        let row = block.contact[lane];
        if row == u32::MAX {
            continue;
        }
        let Some(c) = contacts.row(row as usize) else { continue };
        let at = |v: &[Lanes; 3]| Vec3 { x: v[0][lane], y: v[1][lane], z: v[2][lane] };
        let mut pressed = false;
        for j in 0..usize::from(c.count) {
            c.points[j].impulse = block.impulse[j][lane];
            pressed |= c.points[j].impulse > 0.0 || c.points[j].separation <= 0.0;
            pressed |= extra.is_some_and(|e| e.bounces && e.pressed[j][lane] > 0.0);
        }
        c.tangent_impulse =
            at(&block.t1) * block.friction[0][lane] + at(&block.t2) * block.friction[1][lane];
        c.twist_impulse = block.friction[2][lane];
        if let Some(extra) = extra
            && extra.rolls
        {
            c.rolling_impulse = at(&extra.rolling_impulse);
        }
        if pressed && !c.touching {
            begun.push(row);
        }
    }
}
