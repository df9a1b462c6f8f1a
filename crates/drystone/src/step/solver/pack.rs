//! Contacts to blocks and back: loads manifolds into lanes, builds the rows in wide arithmetic with
//! the warm start fused in, and stores the impulses after the last sweep.

use fearless_simd::{Simd, SimdBase};

use super::contact::K;
use super::inertia::Squeeze;
use super::rows::{
    ContactBlock, Extra, Line, Whitening, load_velocity, read_lanes, store_velocity,
};
use crate::base::disjoint::Rows;
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;
use crate::base::wide::{
    LANES, Lanes, Sym3w, Vec3w, Wide, above, gather4, inverse_or_zero, load, max, min, scatter4,
    select, splat, sqrt,
};
use crate::state::bodies::{Bodies, Body};
use crate::state::contacts::Contact;
use crate::step::context::StepContext;

/// What packing reads.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub(super) ctx: &'a StepContext,
    pub(super) bodies: &'a Bodies,
    /// Line of each body row; 0 for what cannot be pushed.
    pub(super) line_of: &'a [u32],
    pub(super) whitening: &'a Rows<'a, Whitening>,
    /// Acceleration of each line [m/s²].
    pub(super) acceleration: &'a Rows<'a, Vec3>,
    pub(super) contacts: &'a Rows<'a, Option<Contact>>,
}

/// Lanes of a block before its rows are built. Idle lanes repeat the first contact, without a body, a
/// point or an impulse.
struct Raw<'a> {
    contacts: [&'a Contact; LANES],
    row_a: [u32; LANES],
    row_b: [u32; LANES],
    /// -1 where only B can be pushed and it is the contact's A: its rows turn their sign.
    sign: Lanes,
    count: Lanes,
}

impl<'a> Raw<'a> {
    #[inline(always)]
    fn load<const FIXED: bool>(source: &Source<'a>, owners: &[u32; LANES]) -> Option<Self> {
        let first = source.contacts.read(owners[0] as usize).as_ref()?;
        let mut raw = Self {
            contacts: [first; LANES],
            row_a: [0; LANES],
            row_b: [0; LANES],
            sign: [1.0; LANES],
            count: [0.0; LANES],
        };
        for lane in 0..LANES {
            if owners[lane] == u32::MAX {
                continue;
            }
            let Some(c) = source.contacts.read(owners[lane] as usize) else { continue };
            let (a, b) = (source.line_of[c.body_a as usize], source.line_of[c.body_b as usize]);
            raw.contacts[lane] = c;
            raw.count[lane] = f32::from(c.count);
            if FIXED {
                raw.sign[lane] = if b == 0 { -1.0 } else { 1.0 };
                raw.row_b[lane] = a.max(b);
            } else {
                (raw.row_a[lane], raw.row_b[lane]) = (a, b);
            }
        }
        Some(raw)
    }

    /// Normals and friction, friction's impulses and twist.
    #[inline(always)]
    fn common<S: Simd>(&self, simd: S) -> [[Wide<S>; 4]; 2] {
        let (mut normal, mut tangent) = ([[0.0; 4]; LANES], [[0.0; 4]; LANES]);
        for lane in 0..LANES {
            [normal[lane], tangent[lane]] = self.contacts[lane].rows();
        }
        [gather_rows(simd, &normal), gather_rows(simd, &tangent)]
    }

    /// Arms and separation or impulse of point `j`: of A, then of B.
    #[inline(always)]
    fn point<S: Simd>(&self, simd: S, j: usize) -> [[Wide<S>; 4]; 2] {
        let [mut a, mut b] = [[&[0.0; 4]; LANES]; 2];
        for lane in 0..LANES {
            [a[lane], b[lane]] = self.contacts[lane].points[j].rows();
        }
        [gather4(simd, a), gather4(simd, b)]
    }
}

#[inline(always)]
fn gather_rows<S: Simd>(simd: S, r: &[[f32; 4]; LANES]) -> [Wide<S>; 4] {
    let mut rows = [&r[0]; LANES];
    for lane in 1..LANES {
        rows[lane] = &r[lane];
    }
    gather4(simd, rows)
}

/// Fills a block from up to eight contacts and applies their impulses to the lines. `FIXED`: only one
/// body of each can be pushed.
#[inline(always)]
pub(super) fn pack<S: Simd, const FIXED: bool>(
    simd: S,
    source: &Source<'_>,
    owners: &[u32; LANES],
    block: &mut ContactBlock,
    extra: Option<&mut Extra>,
    lines: &Rows<'_, Line>,
) {
    let Some(raw) = Raw::load::<FIXED>(source, owners) else { return };
    (block.row_a, block.row_b) = (raw.row_a, raw.row_b);
    block.count = 0;
    for c in raw.contacts {
        block.count = block.count.max(c.count);
    }
    let mut warm = match block.count {
        1 => build_rows::<S, FIXED, 1>(simd, source, &raw, block),
        2 => build_rows::<S, FIXED, 2>(simd, source, &raw, block),
        _ => build_rows::<S, FIXED, 4>(simd, source, &raw, block),
    };
    if let Some(extra) = extra {
        *extra = Extra::default();
        for lane in 0..LANES {
            if owners[lane] != u32::MAX {
                pack_extra::<FIXED>(source, &raw, lane, extra);
            }
        }
        if extra.rolls {
            let impulse = Vec3w::load(simd, &extra.rolling_impulse);
            warm.turn_a = warm.turn_a + Sym3w::load(simd, &extra.s_a).mul(impulse);
            warm.turn_b = warm.turn_b + Sym3w::load(simd, &extra.s_b).mul(impulse);
        }
    }
    // v̂ += M^-½ Jᵀ λ for the impulses of the last step.
    let mut vb = load_velocity(simd, lines, &block.row_b);
    vb.v = vb.v + warm.push * load(simd, &block.beta);
    vb.w = vb.w + warm.turn_b;
    store_velocity(simd, lines, &block.row_b, vb);
    if !FIXED {
        let mut va = load_velocity(simd, lines, &block.row_a);
        va.v = va.v - warm.push * load(simd, &block.alpha);
        va.w = va.w - warm.turn_a;
        store_velocity(simd, lines, &block.row_a, va);
    }
}

/// The warm start: a linear impulse, and what turns A and B.
struct Warm<S: Simd> {
    push: Vec3w<S>,
    turn_a: Vec3w<S>,
    turn_b: Vec3w<S>,
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

    let count = load(simd, &raw.count);
    let scale = splat(simd, source.ctx.impulse_scale);
    let inv_margin = splat(simd, 1.0 / source.ctx.margin);
    let rest_offset = splat(simd, source.ctx.rest_offset);
    let least = splat(simd, 0.01);
    let zeros = Vec3w::zero(simd);
    let turned = above(zero, load(simd, &raw.sign));
    let (mut a, mut b, mut ra, mut there) = ([zeros; N], [zeros; N], [zeros; N], [zero; N]);
    let (mut ca, mut cb, mut weight) = (zeros, zeros, zero);
    let (mut total, mut most) = (zero, zero);
    let (mut turn_a, mut turn_b) = (zeros, zeros);
    for j in 0..N {
        #[expect(clippy::cast_precision_loss, reason = "below 4")]
        let is_there = above(count, splat(simd, j as f32 + 0.5));
        there[j] = select(is_there, one, zero);
        let [[x, y, z, s], [p, q, r, impulse]] = raw.point(simd, j);
        let arm_a = Vec3w::select(is_there, Vec3w { x, y, z }, zeros);
        let arm_b = Vec3w::select(is_there, Vec3w { x: p, y: q, z: r }, zeros);
        let s0 = select(is_there, s - rest_offset, zero);
        let impulse = select(is_there, impulse, zero);
        most = max(most, impulse);
        let impulse = impulse * scale;
        let point = &mut block.points[j];
        // Friction acts at the middle of what is close.
        let w = min(max(one - s0 * inv_margin, least), one) * there[j];
        s0.store_array(&mut point.s0);
        impulse.store_array(&mut point.impulse);
        ra[j] = arm_a;
        if FIXED {
            let arm = Vec3w::select(turned, arm_a, arm_b);
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
    let share = inverse_or_zero(simd, weight);
    (ca, cb) = (ca * share, cb * share);
    for j in 0..N {
        let arm = ra[j] - ca;
        (sqrt(arm.dot(arm)) * there[j]).store_array(&mut block.points[j].lever);
    }

    let arms = Arms { sa, sb, ca, cb, linear };
    let f = build_friction::<S, FIXED>(simd, &arms, [n, t1, t2], block);
    let [tx, ty, tz, twist] = tangent;
    let tangent = Vec3w { x: tx, y: ty, z: tz };
    let busy = above(count, zero);
    let impulse = [
        select(busy, t1.dot(tangent) * scale, zero),
        select(busy, t2.dot(tangent) * scale, zero),
        select(busy, twist * scale, zero),
    ];
    for i in 0..3 {
        impulse[i].store_array(&mut block.friction[i]);
        turn_a = turn_a + f[0][i] * impulse[i];
        turn_b = turn_b + f[1][i] * impulse[i];
    }

    // Impulses are never negative: the greatest is zero where all are. A lone point needs no rounds, and
    // gets none in whatever company it is.
    let several = select(above(count, splat(simd, 1.5)), one, zero);
    select(above(most, zero), zero, several).store_array(&mut block.fresh);
    block.any_fresh = false;
    for fresh in &block.fresh {
        block.any_fresh |= *fresh > 0.0;
    }
    let push = n * total + t1 * impulse[0] + t2 * impulse[1];
    Warm { push, turn_a, turn_b }
}

/// Where friction acts.
struct Arms<S: Simd> {
    sa: Sym3w<S>,
    sb: Sym3w<S>,
    ca: Vec3w<S>,
    cb: Vec3w<S>,
    /// α² + β²
    linear: Wide<S>,
}

/// Rows of friction along t1 and t2, and of twist about n. Returns those of A and of B.
#[inline(always)]
fn build_friction<S: Simd, const FIXED: bool>(
    simd: S,
    arms: &Arms<S>,
    [n, t1, t2]: [Vec3w<S>; 3],
    block: &mut ContactBlock,
) -> [[Vec3w<S>; 3]; 2] {
    let Arms { sa, sb, ca, cb, linear } = *arms;
    let zero = splat(simd, 0.0);
    let mut at = [Vec3w::zero(simd); 3];
    let bt = [sb.mul(cb.cross(t1)), sb.mul(cb.cross(t2)), sb.mul(n)];
    let (mut k11, mut k12, mut k22, mut k33) = (linear, zero, linear, zero);
    if !FIXED {
        at = [sa.mul(ca.cross(t1)), sa.mul(ca.cross(t2)), sa.mul(n)];
        k11 += at[0].dot(at[0]);
        k12 = at[0].dot(at[1]);
        k22 += at[1].dot(at[1]);
        k33 = at[2].dot(at[2]);
        for i in 0..3 {
            at[i].store(&mut block.a_t[i]);
        }
    }
    for i in 0..3 {
        bt[i].store(&mut block.b_t[i]);
    }
    k11 += bt[0].dot(bt[0]);
    k12 += bt[0].dot(bt[1]);
    k22 += bt[1].dot(bt[1]);
    k33 += bt[2].dot(bt[2]);
    let inv = inverse_or_zero(simd, k11 * k22 - k12 * k12);
    (k22 * inv).store_array(&mut block.mass_t[0]);
    (-(k12 * inv)).store_array(&mut block.mass_t[1]);
    (k11 * inv).store_array(&mut block.mass_t[2]);
    inverse_or_zero(simd, k33).store_array(&mut block.mass_t[3]);
    [at, bt]
}

#[inline(always)]
fn put(lanes: &mut [Lanes; 3], lane: usize, v: Vec3) {
    lanes[0][lane] = v.x;
    lanes[1][lane] = v.y;
    lanes[2][lane] = v.z;
}

#[inline(always)]
fn put_sym(lanes: &mut [Lanes; 6], lane: usize, s: Sym3, sign: f32) {
    for (i, v) in [s.xx, s.yy, s.zz, s.xy, s.xz, s.yz].into_iter().enumerate() {
        lanes[i][lane] = v * sign;
    }
}

/// Bounce, rolling and drift of one contact.
fn pack_extra<const FIXED: bool>(
    source: &Source<'_>,
    raw: &Raw<'_>,
    lane: usize,
    extra: &mut Extra,
) {
    let c = raw.contacts[lane];
    let (a, b) = (source.bodies.at(c.body_a), source.bodies.at(c.body_b));
    if c.restitution > 0.0 {
        let acc = |body: u32| *source.acceleration.read(source.line_of[body as usize] as usize);
        let fall = c.normal.dot(acc(c.body_b) - acc(c.body_a));
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
        if !FIXED {
            let s = source.whitening.read(raw.row_a[lane] as usize).s();
            put_sym(&mut extra.s_a, lane, s, 1.0);
        }
        let s = source.whitening.read(raw.row_b[lane] as usize).s();
        put_sym(&mut extra.s_b, lane, s, raw.sign[lane]);
        let impulse = c.rolling_impulse * source.ctx.impulse_scale;
        put(&mut extra.rolling_impulse, lane, impulse);
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
        let t1 = c.normal.any_perpendicular();
        extra.drift_t[0][lane] = t1.dot(mean);
        extra.drift_t[1][lane] = t1.cross(c.normal).dot(mean);
        extra.drift_t[2][lane] = c.normal.dot(spin(b) - spin(a));
    }
}

/// Velocity of a point of a moving kinematic body; zero of any other.
fn drift_velocity(body: &Body, r: Vec3) -> Vec3 {
    if !body.is_dynamic() && body.active() { body.velocity_at(r) } else { Vec3::ZERO }
}

/// Adds a block's normal impulses to what is known of how its bodies are squeezed.
#[inline(always)]
pub(super) fn weigh<S: Simd>(simd: S, block: &ContactBlock, squeezes: &Rows<'_, Squeeze>) {
    let mut total = load(simd, &block.points[0].impulse);
    for point in &block.points[1..usize::from(block.count.clamp(1, 4))] {
        total += load(simd, &point.impulse);
    }
    // B's side, where a turned row has a negative beta.
    let turned = above(splat(simd, 0.0), load(simd, &block.beta));
    let push = Vec3w::load(simd, &block.n) * total;
    let push = Vec3w::select(turned, push * splat(simd, -1.0), push);
    let of_b = scatter4([push.x, push.y, push.z, total]);
    for lane in 0..LANES {
        let mut impulse = [0.0; 4];
        of_b[lane].store_array(&mut impulse);
        let (a, b) = (block.row_a[lane], block.row_b[lane]);
        if b != 0 {
            for (sum, x) in squeezes.row(b as usize).impulse.iter_mut().zip(impulse) {
                *sum += x;
            }
        }
        if a != 0 {
            let [x, y, z, size] = impulse;
            for (sum, x) in squeezes.row(a as usize).impulse.iter_mut().zip([-x, -y, -z, size]) {
                *sum += x;
            }
        }
    }
}

/// Writes a block's impulses back. Returns a bit for each lane whose touch is new.
#[inline(always)]
pub(super) fn store<S: Simd>(
    simd: S,
    block: &ContactBlock,
    extra: Option<&Extra>,
    owners: &[u32; LANES],
    contacts: &Rows<'_, Option<Contact>>,
) -> u8 {
    let (f1, f2) = (load(simd, &block.friction[0]), load(simd, &block.friction[1]));
    let t = Vec3w::load(simd, &block.t1) * f1 + Vec3w::load(simd, &block.t2) * f2;
    let rub = scatter4([t.x, t.y, t.z, load(simd, &block.friction[2])]);
    let p = &block.points;
    let push = scatter4([
        load(simd, &p[0].impulse),
        load(simd, &p[1].impulse),
        load(simd, &p[2].impulse),
        load(simd, &p[3].impulse),
    ]);
    let mut begun = 0;
    for lane in 0..LANES {
        if owners[lane] == u32::MAX {
            continue;
        }
        let Some(c) = contacts.row(owners[lane] as usize) else { continue };
        let (mut push_of, mut rub_of) = ([0.0; 4], [0.0; 4]);
        push[lane].store_array(&mut push_of);
        rub[lane].store_array(&mut rub_of);
        let mut pressed = false;
        for j in 0..usize::from(c.count.min(4)) {
            c.points[j].impulse = push_of[j];
            pressed |= push_of[j] > 0.0 || c.points[j].separation <= 0.0;
            if let Some(e) = extra {
                pressed |= e.bounces && e.pressed[j][lane] > 0.0;
            }
        }
        let [x, y, z, twist] = rub_of;
        (c.tangent_impulse, c.twist_impulse) = (Vec3 { x, y, z }, twist);
        if let Some(extra) = extra
            && extra.rolls
        {
            let [x, y, z] = &extra.rolling_impulse;
            c.rolling_impulse = Vec3 { x: x[lane], y: y[lane], z: z[lane] };
        }
        begun |= u8::from(pressed && !c.touching) << lane;
    }
    begun
}
