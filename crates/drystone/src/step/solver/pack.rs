//! Contacts to blocks: loads manifolds into lanes and builds the rows in wide arithmetic, with the warm
//! start fused in.

use fearless_simd::{Simd, SimdBase, SimdMask, mask32x8};

use super::contact::K;
use super::pack_extra::{blows, corotation, pack_extra};
use super::parting;
use super::rows::{
    ContactBlock, Extra, Line, Whitening, load_velocity, read_lanes, store_velocity,
};
use super::tally::NEW;
use crate::base::bit_set::BitSet;
use crate::base::disjoint::Rows;
use crate::base::math::Vec3;
use crate::base::wide::{
    LANES, Lanes, Sym3w, Vec3w, Wide, above, bits, gather_rows, gather4, inverse_or_zero, load,
    max, min, put, select, splat, sqrt,
};
use crate::state::bodies::Bodies;
use crate::state::contacts::{Contact, Slots, Softened, Traits};
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;
use crate::step::narrowphase;

/// Mean distance from the middle of a disc over its radius.
const DISC: f32 = 2.0 / 3.0;

/// Mean distance from the middle of a square over half its diagonal: (√2 + ln(1 + √2)) / (3 √2).
const SQUARE: f32 = 0.541_075_1;

/// Points, bits, of a pair that touches which bear nothing and come as fast as a hit; [`NEW`] of one that does not touch yet.
#[inline(always)]
fn landing(c: &Contact, source: &Source<'_>) -> u8 {
    if !c.touching {
        return NEW;
    }
    if c.traits.any(Traits::STRUCK) {
        return 0;
    }
    // While some shapes have hit speeds of their own any may count.
    let least = if source.shapes.give_hit_speed > 0 { 0.0 } else { source.ctx.hit_speed };
    if !(c.approach() > least) {
        return 0;
    }
    let bare = c.points().iter().map(|p| u8::from(!(p.impulse > 0.0)));
    bare.enumerate().fold(0, |bits, (j, bare)| bits | bare << j)
}

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
    pub(super) contacts: &'a Slots<'a>,
    pub(super) softened: &'a [Softened],
    pub(super) shapes: &'a Shapes,
    /// Some contact may be parted.
    pub(super) parts: bool,
    /// Some contact that does not bounce may get a blow.
    pub(super) blows: bool,
    /// Rows are made anew within the step. What becomes deep in it is parted from the next one on.
    pub(super) is_renewed: bool,
    /// If some contact's bodies turn together: bodies whose contacts are made anew within the step, which need nothing for that.
    pub(super) turning: Option<&'a BitSet>,
}

/// Lanes of a block before its rows are built. Idle lanes repeat the first contact, without a body, a
/// point or an impulse.
pub(super) struct Raw<'a> {
    pub(super) contacts: [&'a Contact; LANES],
    pub(super) row_a: [u32; LANES],
    pub(super) row_b: [u32; LANES],
    /// -1 where only B can be pushed and it is the contact's A: its rows turn their sign.
    pub(super) sign: Lanes,
    pub(super) count: Lanes,
    /// Mean distance from the middle of what the points enclose, over that of the points.
    patch: Lanes,
    /// As [`ContactBlock::landing`].
    landing: [u8; LANES],
    /// Reach of the spinning resistance times the friction coefficient [m]; whether there is any.
    spinning: Lanes,
    spins: bool,
    /// Where the bodies turn together, how far each turns in half of the step [rad, world].
    turns: Option<[[Lanes; 3]; 2]>,
    /// Some contact is being parted.
    parts: bool,
    /// How much of what each gives has been taken back [m].
    settled: Lanes,
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
            patch: [SQUARE; LANES],
            landing: [0; LANES],
            spinning: [0.0; LANES],
            spins: false,
            turns: None,
            parts: false,
            settled: [0.0; LANES],
        };
        for lane in 0..LANES {
            if owners[lane] == u32::MAX {
                continue;
            }
            let Some(c) = source.contacts.read(owners[lane] as usize) else { continue };
            let (a, b) = (source.line_of[c.body_a as usize], source.line_of[c.body_b as usize]);
            raw.contacts[lane] = c;
            raw.count[lane] = f32::from(c.count);
            raw.landing[lane] = landing(c, source);
            raw.parts |= c.traits.any(Traits::PARTING);
            raw.settled[lane] = c.settled();
            if c.round_patch {
                raw.patch[lane] = DISC;
            }
            if c.spinning > 0.0 {
                raw.spinning[lane] = c.spinning;
                raw.spins = true;
            }
            if !FIXED && let Some(turning) = source.turning {
                raw.note_corotation(source, turning, lane);
            }
            if FIXED {
                raw.sign[lane] = if b == 0 { -1.0 } else { 1.0 };
                raw.row_b[lane] = a.max(b);
            } else {
                (raw.row_a[lane], raw.row_b[lane]) = (a, b);
            }
        }
        Some(raw)
    }

    /// Notes how far the bodies of a contact turn if they turn together and it is made once for the whole step.
    #[inline(never)]
    fn note_corotation(&mut self, source: &Source<'_>, turning: &BitSet, lane: usize) {
        let c = self.contacts[lane];
        let bodies = [c.body_a, c.body_b];
        if bodies.iter().any(|row| turning.contains(*row)) {
            return;
        }
        let ends = bodies.map(|row| source.bodies.at(row));
        if !narrowphase::corotates(source.ctx, c, ends) {
            return;
        }
        let turns = self.turns.get_or_insert([[[0.0; LANES]; 3]; 2]);
        for (turn, body) in turns.iter_mut().zip(ends) {
            put(turn, lane, body.w * (0.5 * source.ctx.dt));
        }
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

    /// Centers of B less those of A when the manifolds were made.
    #[inline(always)]
    fn offset<S: Simd>(&self, simd: S) -> Vec3w<S> {
        let mut lanes = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let offset = self.contacts[lane].offset;
            (lanes[0][lane], lanes[1][lane], lanes[2][lane]) = (offset.x, offset.y, offset.z);
        }
        Vec3w::load(simd, &lanes)
    }

    /// Of point `j` the arm of A with the separation, and the impulse.
    #[inline(always)]
    fn point<S: Simd>(&self, simd: S, j: usize) -> ([Wide<S>; 4], Wide<S>) {
        let mut arm = [&[0.0; 4]; LANES];
        let mut impulse = [0.0; LANES];
        for lane in 0..LANES {
            let point = &self.contacts[lane].points[j];
            arm[lane] = point.arm();
            impulse[lane] = point.impulse;
        }
        (gather4(simd, arm), load(simd, &impulse))
    }
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
    let Some(warm) = build::<S, FIXED>(simd, source, owners, block, extra) else { return };
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

/// Fills a block from up to eight contacts; `None` if there is none.
#[inline(always)]
pub(super) fn build<S: Simd, const FIXED: bool>(
    simd: S,
    source: &Source<'_>,
    owners: &[u32; LANES],
    block: &mut ContactBlock,
    extra: Option<&mut Extra>,
) -> Option<Warm<S>> {
    let Some(raw) = Raw::load::<FIXED>(source, owners) else {
        // Other groups have been in the room: what they left must push nothing.
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
    if source.blows {
        block.arrives = blows(source, &raw, owners);
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

/// The warm start: a linear impulse, and what turns A and B.
pub(super) struct Warm<S: Simd> {
    push: Vec3w<S>,
    turn_a: Vec3w<S>,
    turn_b: Vec3w<S>,
    /// Arm at which twist is measured [m].
    reach: Wide<S>,
    /// How the velocity along the tangents grows that bodies which turn together have there [m/s²].
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
    let (mut total, mut most, mut lowest) = (zero, zero, zero);
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
        most = max(most, impulse);
        let impulse = impulse * scale;
        let point = &mut block.points[j];
        // Friction acts at the middle of what is close.
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
    if let Some(part) = kept(simd, block, most * scale * linear, source.ctx.warm_most) {
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
    // Friction acts on the surfaces, which an arm half way across a gap does not reach yet.
    let gap = n * (gap * share * splat(simd, 0.5));
    if FIXED {
        cb = cb + gap * load(simd, &raw.sign);
    } else {
        cb = cb + gap;
        ca = ca - gap;
    }

    let settling = above(select(above(most, zero), zero, count), splat(simd, 2.5));
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

    mark_fresh(simd, block, count, most);
    let push = n * total + t1 * impulse[0] + t2 * impulse[1];
    Warm { push, turn_a, turn_b, reach, grows }
}

/// K of each pair of points, and the mass that each bears: 1/K_jj, 0 of those that are not there.
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

/// Takes what contacts begin with down to what gives their bodies a speed of `most`, and returns that part; `None`: all of it stays.
/// `speeds`: what their greatest impulse would give.
///
/// What is caught between two that give way to nothing is pressed without end, and nothing is pressed so by weight. When one of both
/// goes, the sweep that takes the other's back leaves a part of it, which threw a crate out at 31 m/s.
#[inline(always)]
fn kept<S: Simd>(simd: S, block: &mut ContactBlock, speeds: Wide<S>, most: f32) -> Option<Wide<S>> {
    let most = splat(simd, most);
    if bits(above(speeds, most)) == 0 {
        return None;
    }
    let part = min(splat(simd, 1.0), most / max(speeds, most));
    for point in &mut block.points {
        (load(simd, &point.impulse) * part).store_array(&mut point.impulse);
    }
    Some(part)
}

/// Marks the contacts without a warm start, which get more rounds. Impulses are never negative: the
/// greatest is zero where all are. A lone point needs no rounds, and gets none in whatever company it is.
#[inline(always)]
fn mark_fresh<S: Simd>(simd: S, block: &mut ContactBlock, count: Wide<S>, most: Wide<S>) {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let several = select(above(count, splat(simd, 1.5)), one, zero);
    select(above(most, zero), zero, several).store_array(&mut block.fresh);
    block.any_fresh = false;
    for fresh in &block.fresh {
        block.any_fresh |= *fresh > 0.0;
    }
}

/// Where twist is measured: the mean distance of the points from the middle, times that of what they
/// enclose over theirs; farther out for what resists spinning.
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
    // A lone point beside contacts with more of them has none, by rounding neither.
    reach = select(above(count, splat(simd, 1.5)), reach, splat(simd, 0.0));
    if raw.spins {
        reach += load(simd, &raw.spinning) * inverse_or_zero(simd, mu);
    }
    reach
}

/// Where friction acts.
struct Arms<S: Simd> {
    sa: Sym3w<S>,
    sb: Sym3w<S>,
    ca: Vec3w<S>,
    cb: Vec3w<S>,
    /// α² + β²
    linear: Wide<S>,
    /// Arm at which twist is measured [m].
    reach: Wide<S>,
    /// Fresh contacts of three points or more.
    settling: mask32x8<S>,
}

/// Rows of each element of their matrix, as [`ContactBlock::mass_t`] has them.
const PAIRS: [[usize; 2]; 6] = [[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2]];

/// Rows of friction along t1 and t2, and of twist about n. Returns those of A and of B.
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
    // The tangents first; twist by what is left of it when they give way (Schur's complement). Without
    // a reach there is no twist, and zeros are left.
    // A contact that stands on a face holds the body: its normals take back the turn that friction's
    // impulse gives it. Rows that count on that turn take several substeps to stop a body, as long as
    // their impulses are not known. So a fresh contact leaves out as much of it as keeps the step below
    // 1.6 times that of a free body: at 2 it would no longer take energy. (In every step, four cubes on
    // a slope never came to rest.)
    if settling.any_true() {
        let turn = max(k[0], k[2]) - linear;
        let least = splat(simd, 0.625) - splat(simd, 0.375) * linear * inverse_or_zero(simd, turn);
        let part = max(least, zero);
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
    // Nor is there one at a reach of rounding, whose inverse would be beyond all numbers.
    let least = max(k33 * splat(simd, 1.0e-5), k11 * splat(simd, 1.0e-12));
    let m33 = select(above(left, least), inverse_or_zero(simd, left), zero);
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
    // No eigenvalue is above the root of the sum of squares, and a step by its inverse never overshoots.
    let off = k12 * k12 + k13 * k13 + k23 * k23;
    let norm = sqrt(k11 * k11 + k22 * k22 + k33 * k33 + (off + off));
    inverse_or_zero(simd, norm).store_array(&mut block.mass_slide);
    [at, bt]
}
