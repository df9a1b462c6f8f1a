//! The kernel of joints of six axes, eight at a time.
//!
//! Symbols: u are the axes of motion (turned with body A), n those of the turns, λ impulses along u, μ about
//! n; d is anchor B less anchor A. A force along u acts at anchor B on both bodies, so that with d ≠ 0 (a
//! slider) it makes no torque: the arm of A is r_a + d. Angles go on from the step's start by
//! ε = θ_b - θ_a - θ_a × θ_b / 2, the turn of B against A to second order: no trigonometry here.
//!
//! Drives come first, then limits, one axis after the other, then all locked axes at once: their 6 × 6
//! matrix by blocks, L over the locked motions, C over both, A over the turns; the turns are solved with
//! A - Cᵀ L⁻¹ C. That matrix is the effective mass of a drive about an axis too, and its impulse is given
//! along with -L⁻¹ C of it, which leaves the locked motions at rest: a hinge's limit is that of a body
//! about its anchor. (Without that a sweep takes away only a quarter of the speed of a rod held at its
//! end.) Warm start as of balls: see joint.rs and docs/decisions/016-joint-energy.md.

use fearless_simd::{Simd, SimdBase};

use super::joint::{JointSweep, turned};
use super::rows::{Line, Velocity, load_motion, load_velocity, store_velocity};
use crate::base::disjoint::Rows;
use crate::base::wide::{
    LANES, Lanes, Sym3w, Vec3w, Wide, above, inverse_or_zero, load, max, min, select, splat,
};

/// How an axis pushes: `v + rate · error + bias + (give + give_mass K) λ = 0`, K the inverse effective mass.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Push {
    pub(crate) rate: Lanes,
    pub(crate) give: Lanes,
    pub(crate) give_mass: Lanes,
    pub(crate) bias: Lanes,
}

/// Drive and limit of an axis.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Axis {
    pub(crate) drive: Push,
    /// Greatest impulse of the drive; 0: none.
    pub(crate) most: Lanes,
    pub(crate) limit: Push,
    /// 1 where the limit is as hard as the joint.
    pub(crate) hard: Lanes,
    pub(crate) low: Lanes,
    pub(crate) high: Lanes,
}

/// Eight joints of six axes.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct SixBlock {
    pub(crate) row_a: [u32; LANES],
    pub(crate) row_b: [u32; LANES],
    pub(crate) alpha: Lanes,
    pub(crate) beta: Lanes,
    pub(crate) s_a: [Lanes; 6],
    pub(crate) s_b: [Lanes; 6],
    pub(crate) r_a: [Lanes; 3],
    pub(crate) r_b: [Lanes; 3],
    /// Anchor B less anchor A at the step's start.
    pub(crate) gap: [Lanes; 3],
    /// Velocities of kinematic bodies: B's less A's, and angular ones.
    pub(crate) drift: [Lanes; 3],
    pub(crate) spin_a: [Lanes; 3],
    pub(crate) spin_b: [Lanes; 3],
    /// u and n at the step's start.
    pub(crate) u: [[Lanes; 3]; 3],
    pub(crate) n: [[Lanes; 3]; 3],
    /// Angles at the step's start.
    pub(crate) angles: [Lanes; 3],
    /// 1 where an axis is locked, and the place where it is.
    pub(crate) locked: [Lanes; 6],
    pub(crate) place: [Lanes; 6],
    /// Impulse of lock or drive, and of the limit.
    pub(crate) held: [Lanes; 6],
    pub(crate) limit: [Lanes; 6],
    /// What the bodies carry of the warm start: linear; the moments on A and B.
    pub(crate) carried: [Lanes; 3],
    pub(crate) carried_a: [Lanes; 3],
    pub(crate) carried_b: [Lanes; 3],
    /// Impulse about B's anchor.
    pub(crate) torque: [Lanes; 3],
    /// Some axis of motion has a drive or limit, and some turn.
    pub(crate) moves: bool,
    pub(crate) turns: bool,
    pub(crate) axes: [Axis; 6],
}

/// Rows of an axis at both bodies: u and n, and S (r × u) or S n.
#[derive(Clone, Copy)]
struct Row<S: Simd> {
    n: Vec3w<S>,
    a: Vec3w<S>,
    b: Vec3w<S>,
}

impl<S: Simd> Row<S> {
    #[inline(always)]
    fn masked(self, m: Wide<S>) -> Self {
        Self { n: self.n * m, a: self.a * m, b: self.b * m }
    }

    #[inline(always)]
    fn coupling(&self, o: &Self) -> Wide<S> {
        self.a.dot(o.a) + self.b.dot(o.b)
    }
}

/// Both bodies as the sweep changes them.
struct Pair<S: Simd> {
    alpha: Wide<S>,
    beta: Wide<S>,
    va: Velocity<S>,
    vb: Velocity<S>,
    /// Relative velocities of kinematic bodies.
    drift: Vec3w<S>,
    spin: Vec3w<S>,
    arm_a: Vec3w<S>,
    arm_b: Vec3w<S>,
    /// Impulses of this sweep: linear, and about anchor B.
    force: Vec3w<S>,
    torque: Vec3w<S>,
}

impl<S: Simd> Pair<S> {
    #[inline(always)]
    fn speed_along(&self, row: &Row<S>) -> Wide<S> {
        row.n.dot(self.vb.v * self.beta - self.va.v * self.alpha + self.drift)
            + row.b.dot(self.vb.w)
            - row.a.dot(self.va.w)
    }

    #[inline(always)]
    fn speed_about(&self, row: &Row<S>) -> Wide<S> {
        row.n.dot(self.spin) + row.b.dot(self.vb.w) - row.a.dot(self.va.w)
    }

    #[inline(always)]
    fn push_along(&mut self, row: &Row<S>, d: Wide<S>) {
        let p = row.n * d;
        self.force = self.force + p;
        self.va.v = self.va.v - p * self.alpha;
        self.vb.v = self.vb.v + p * self.beta;
        self.va.w = self.va.w - row.a * d;
        self.vb.w = self.vb.w + row.b * d;
    }

    #[inline(always)]
    fn push_about(&mut self, row: &Row<S>, d: Wide<S>) {
        self.torque = self.torque + row.n * d;
        self.va.w = self.va.w - row.a * d;
        self.vb.w = self.vb.w + row.b * d;
    }
}

/// The inverse of a positive definite matrix; zero if it is not.
#[inline(always)]
fn inverse<S: Simd>(simd: S, m: &Sym3w<S>) -> Sym3w<S> {
    let cx = m.yy * m.zz - m.yz * m.yz;
    let cy = m.xz * m.yz - m.xy * m.zz;
    let cz = m.xy * m.yz - m.xz * m.yy;
    let k = inverse_or_zero(simd, m.xx * cx + m.xy * cy + m.xz * cz);
    Sym3w {
        xx: cx * k,
        xy: cy * k,
        xz: cz * k,
        yy: (m.xx * m.zz - m.xz * m.xz) * k,
        yz: (m.xy * m.xz - m.xx * m.yz) * k,
        zz: (m.xx * m.yy - m.xy * m.xy) * k,
    }
}

/// The matrix of three rows, with `own` more on its diagonal.
#[inline(always)]
fn matrix<S: Simd>(r: &[Row<S>; 3], own: [Wide<S>; 3]) -> Sym3w<S> {
    Sym3w {
        xx: own[0] + r[0].coupling(&r[0]),
        yy: own[1] + r[1].coupling(&r[1]),
        zz: own[2] + r[2].coupling(&r[2]),
        xy: r[0].coupling(&r[1]),
        xz: r[0].coupling(&r[2]),
        yz: r[1].coupling(&r[2]),
    }
}

/// An impulse that makes `v + rate x + bias + (give + give_mass K) λ` zero.
#[inline(always)]
fn wanted<S: Simd>(
    simd: S,
    push: &Push,
    [rate, give_mass]: [Wide<S>; 2],
    k: Wide<S>,
    v: Wide<S>,
    x: Wide<S>,
    old: Wide<S>,
) -> Wide<S> {
    let give = load(simd, &push.give) + give_mass * k;
    let miss = v + rate * x + load(simd, &push.bias) + give * old;
    -miss * inverse_or_zero(simd, k + give)
}

/// Solves drive and limit of an axis at the coordinate `x`, speed `v`; returns the impulse to give. `rigid`:
/// rate and give of a hard limit.
#[inline(always)]
fn drive_and_limit<S: Simd>(
    simd: S,
    axis: &Axis,
    [held, limit]: [&mut Lanes; 2],
    locked: Wide<S>,
    [k, x, v]: [Wide<S>; 3],
    rigid: [Wide<S>; 2],
    inv_h: Wide<S>,
) -> Wide<S> {
    let zero = splat(simd, 0.0);
    let is_locked = above(locked, zero);
    let old = load(simd, held);
    let most = load(simd, &axis.most);
    let law = [load(simd, &axis.drive.rate), load(simd, &axis.drive.give_mass)];
    let new = old + wanted(simd, &axis.drive, law, k, v, x, old);
    let new = max(min(new, most), -most);
    let new = select(is_locked, old, new);
    new.store_array(held);
    let d = new - old;
    let v = v + k * d;

    let old = load(simd, limit);
    let (low, high) = (load(simd, &axis.low), load(simd, &axis.high));
    let (over_low, over_high) = (x - low, x - high);
    let is_low = above(-over_high, over_low);
    let error = select(is_low, over_low, over_high);
    let open = select(is_low, error, -error);
    let hard = load(simd, &axis.hard);
    let rate = load(simd, &axis.limit.rate) + hard * rigid[0];
    let give = load(simd, &axis.limit.give_mass) + hard * rigid[1];
    let shut = wanted(simd, &axis.limit, [rate, give], k, v, error, old);
    let ahead = -(v + error * inv_h) * inverse_or_zero(simd, k);
    let new = old + select(above(open, zero), ahead, shut);
    let new = select(is_low, max(new, zero), min(new, zero));
    // Without room between them, both hold: a spring about one place.
    let tight = above(splat(simd, 1.0e-9), high - low);
    let new = select(tight, old + shut, new);
    let new = select(is_locked, zero, new);
    new.store_array(limit);
    d + (new - old)
}

/// Solves one block once.
#[inline(always)]
pub(crate) fn solve<S: Simd>(
    simd: S,
    block: &mut SixBlock,
    lines: &Rows<'_, Line>,
    sweep: &JointSweep,
) {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let (alpha, beta) = (load(simd, &block.alpha), load(simd, &block.beta));
    let (sa, sb) = (Sym3w::load(simd, &block.s_a), Sym3w::load(simd, &block.s_b));
    let va = load_velocity(simd, lines, &block.row_a);
    let vb = load_velocity(simd, lines, &block.row_b);
    let mut xa = load_motion(simd, lines, &block.row_a);
    let mut xb = load_motion(simd, lines, &block.row_b);
    if sweep.is_relax {
        let back = splat(simd, sweep.back);
        (xa.v, xa.w) = (xa.v - va.v * back, xa.w - va.w * back);
        (xb.v, xb.w) = (xb.v - vb.v * back, xb.w - vb.w * back);
    }
    let elapsed = splat(simd, sweep.elapsed);
    let (spin_a, spin_b) = (Vec3w::load(simd, &block.spin_a), Vec3w::load(simd, &block.spin_b));
    let turn_a = sa.mul(xa.w) + spin_a * elapsed;
    let turn_b = sb.mul(xb.w) + spin_b * elapsed;
    let (r0a, r0b) = (Vec3w::load(simd, &block.r_a), Vec3w::load(simd, &block.r_b));
    let (ra, rb) = (turned(simd, r0a, turn_a), turned(simd, r0b, turn_b));
    let drift = Vec3w::load(simd, &block.drift);
    let gap = Vec3w::load(simd, &block.gap) + xb.v * beta - xa.v * alpha + (rb - r0b) - (ra - r0a)
        + drift * elapsed;
    let arm_a = ra + gap;
    let turn = turn_b - turn_a - turn_a.cross(turn_b) * splat(simd, 0.5);

    let (u0, n0) = (Vec3w::load3(simd, &block.u), Vec3w::load3(simd, &block.n));
    let none = Row { n: gap, a: gap, b: gap };
    let (mut along, mut about) = ([none; 3], [none; 3]);
    let (mut x, mut locked) = ([zero; 6], [zero; 6]);
    for i in 0..3 {
        let u = turned(simd, u0[i], turn_a);
        along[i] = Row { n: u, a: sa.mul(arm_a.cross(u)), b: sb.mul(rb.cross(u)) };
        let n = turned(simd, n0[i], turn_a);
        about[i] = Row { n, a: sa.mul(n), b: sb.mul(n) };
        x[i] = u.dot(gap);
        x[i + 3] = load(simd, &block.angles[i]) + n0[i].dot(turn);
        locked[i] = load(simd, &block.locked[i]);
        locked[i + 3] = load(simd, &block.locked[i + 3]);
    }

    let mut q = Pair {
        alpha,
        beta,
        va,
        vb,
        drift: drift + spin_b.cross(rb) - spin_a.cross(arm_a),
        spin: spin_b - spin_a,
        arm_a,
        arm_b: rb,
        force: Vec3w::zero(simd),
        torque: Vec3w::zero(simd),
    };
    let carried = Vec3w::load(simd, &block.carried);
    let carried_a = Vec3w::load(simd, &block.carried_a);
    let carried_b = Vec3w::load(simd, &block.carried_b);
    // The warm start, in the rows of now.
    let (mut p, mut t) = (Vec3w::zero(simd), Vec3w::zero(simd));
    for i in 0..3 {
        let (lambda, mu) = (
            load(simd, &block.held[i]) + load(simd, &block.limit[i]),
            load(simd, &block.held[i + 3]) + load(simd, &block.limit[i + 3]),
        );
        p = p + along[i].n * lambda;
        t = t + about[i].n * mu;
    }
    if !sweep.is_relax {
        let d = p - carried;
        let da = q.arm_a.cross(p) + t - carried_a;
        let db = q.arm_b.cross(p) + t - carried_b;
        q.va.v = q.va.v - d * alpha;
        q.vb.v = q.vb.v + d * beta;
        q.va.w = q.va.w - sa.mul(da);
        q.vb.w = q.vb.w + sb.mul(db);
    }

    let linear = alpha * alpha + beta * beta;
    let s = &sweep.softness;
    let inv_h = splat(simd, sweep.inv_h);
    let rigid = [splat(simd, s.rate / s.mass), splat(simd, s.impulse / s.mass)];
    if block.moves {
        for i in 0..3 {
            let row = &along[i];
            let state = [linear + row.coupling(row), x[i], q.speed_along(row)];
            let impulses = [&mut block.held[i], &mut block.limit[i]];
            let axis = &block.axes[i];
            let d = drive_and_limit(simd, axis, impulses, locked[i], state, rigid, inv_h);
            q.push_along(row, d);
        }
    }

    // L, L⁻¹ C and A - Cᵀ L⁻¹ C over the locked motions and all turns.
    let held = [along[0].masked(locked[0]), along[1].masked(locked[1]), along[2].masked(locked[2])];
    let own = [
        select(above(locked[0], zero), linear, one),
        select(above(locked[1], zero), linear, one),
        select(above(locked[2], zero), linear, one),
    ];
    let l = inverse(simd, &matrix(&held, own));
    let (mut c, mut lc) = ([gap; 3], [gap; 3]);
    for i in 0..3 {
        c[i] = Vec3w {
            x: held[0].coupling(&about[i]),
            y: held[1].coupling(&about[i]),
            z: held[2].coupling(&about[i]),
        };
        lc[i] = l.mul(c[i]);
    }
    let a = matrix(&about, [zero; 3]);
    let a = Sym3w {
        xx: a.xx - c[0].dot(lc[0]),
        yy: a.yy - c[1].dot(lc[1]),
        zz: a.zz - c[2].dot(lc[2]),
        xy: a.xy - c[0].dot(lc[1]),
        xz: a.xz - c[0].dot(lc[2]),
        yz: a.yz - c[1].dot(lc[2]),
    };

    // What locked motions receive.
    let mut lambda = Vec3w::zero(simd);
    if block.turns {
        let own = [a.xx, a.yy, a.zz];
        for i in 0..3 {
            let row = &about[i];
            let state = [max(own[i], zero), x[i + 3], q.speed_about(row)];
            let impulses = [&mut block.held[i + 3], &mut block.limit[i + 3]];
            let axis = &block.axes[i + 3];
            let d = drive_and_limit(simd, axis, impulses, locked[i + 3], state, rigid, inv_h);
            q.push_about(row, d);
            let r = lc[i] * -d;
            q.push_along(&held[0], r.x);
            q.push_along(&held[1], r.y);
            q.push_along(&held[2], r.z);
            lambda = lambda + r;
        }
    }

    // All locked axes.
    let (mass, rate, leak) = (splat(simd, s.mass), splat(simd, s.rate), splat(simd, s.impulse));
    let old = Vec3w::load(simd, &[block.held[0], block.held[1], block.held[2]]) + lambda;
    let old_turn = Vec3w::load(simd, &[block.held[3], block.held[4], block.held[5]]);
    let mut miss = [zero; 6];
    for i in 0..3 {
        let (place, angle) = (load(simd, &block.place[i]), load(simd, &block.place[i + 3]));
        miss[i] = (mass * q.speed_along(&along[i]) + rate * (x[i] - place)) * locked[i];
        miss[i + 3] =
            (mass * q.speed_about(&about[i]) + rate * (x[i + 3] - angle)) * locked[i + 3];
    }
    let lock = Vec3w { x: locked[0], y: locked[1], z: locked[2] };
    let (k0, k1, k2) = (locked[3], locked[4], locked[5]);
    let miss_l = Vec3w { x: miss[0], y: miss[1], z: miss[2] };
    let first = l.mul(miss_l);
    let rest = Vec3w {
        x: (miss[3] - c[0].dot(first)) * k0,
        y: (miss[4] - c[1].dot(first)) * k1,
        z: (miss[5] - c[2].dot(first)) * k2,
    };
    let a = Sym3w {
        xx: select(above(k0, zero), a.xx, one),
        yy: select(above(k1, zero), a.yy, one),
        zz: select(above(k2, zero), a.zz, one),
        xy: a.xy * (k0 * k1),
        xz: a.xz * (k0 * k2),
        yz: a.yz * (k1 * k2),
    };
    let mu = -inverse(simd, &a).mul(rest);
    let solved = -first - lc[0] * mu.x - lc[1] * mu.y - lc[2] * mu.z;
    let d = Vec3w {
        x: (solved.x - leak * old.x) * lock.x,
        y: (solved.y - leak * old.y) * lock.y,
        z: (solved.z - leak * old.z) * lock.z,
    };
    let dt = Vec3w {
        x: (mu.x - leak * old_turn.x) * k0,
        y: (mu.y - leak * old_turn.y) * k1,
        z: (mu.z - leak * old_turn.z) * k2,
    };
    q.push_along(&along[0], d.x);
    q.push_along(&along[1], d.y);
    q.push_along(&along[2], d.z);
    q.push_about(&about[0], dt.x);
    q.push_about(&about[1], dt.y);
    q.push_about(&about[2], dt.z);
    (old.x + d.x).store_array(&mut block.held[0]);
    (old.y + d.y).store_array(&mut block.held[1]);
    (old.z + d.z).store_array(&mut block.held[2]);
    (old_turn.x + dt.x).store_array(&mut block.held[3]);
    (old_turn.y + dt.y).store_array(&mut block.held[4]);
    (old_turn.z + dt.z).store_array(&mut block.held[5]);

    (t + q.torque).store(&mut block.torque);
    let more_a = q.arm_a.cross(q.force) + q.torque;
    let more_b = q.arm_b.cross(q.force) + q.torque;
    if sweep.is_relax {
        (carried + q.force).store(&mut block.carried);
        (carried_a + more_a).store(&mut block.carried_a);
        (carried_b + more_b).store(&mut block.carried_b);
    } else {
        (p + q.force).store(&mut block.carried);
        (q.arm_a.cross(p) + t + more_a).store(&mut block.carried_a);
        (q.arm_b.cross(p) + t + more_b).store(&mut block.carried_b);
    }
    store_velocity(simd, lines, &block.row_a, q.va);
    store_velocity(simd, lines, &block.row_b, q.vb);
}
