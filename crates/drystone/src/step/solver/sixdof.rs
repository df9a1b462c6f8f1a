//! The kernel of joints of six axes, eight at a time.
//!
//! Symbols: u are the axes of motion (turned with body A), n those of the turns, λ impulses along u, μ about
//! n; d is anchor B less anchor A. A force along u acts at anchor B on both bodies, so that with d ≠ 0 (a
//! slider) it makes no torque: the arm of A is r_a + d. Angles go on from the step's start by
//! ε = θ_b - θ_a - θ_a × θ_b / 2, the turn of B against A to second order: no trigonometry here.
//!
//! All locked axes come first, at once: their 6 × 6 matrix by blocks, L over the locked motions, C over both,
//! A over the turns; the turns are solved with A - Cᵀ L⁻¹ C. Then drives and limits, one axis after the
//! other. Each is felt through the locked axes: with K the coupling of its row to theirs, its inverse mass
//! is less by Kᵀ M K, M their inverse matrix, and along with its impulse they get -M K of it, which leaves
//! them at rest. So a hinge's limit is that of a body about its anchor, and a slider's spring is one on the
//! whole mass wherever its anchor is. (Without that a sweep takes away only a quarter of the speed of a rod
//! held at its end.) Warm start as of balls: see joint.rs and docs/decisions/016-joint-energy.md.

use fearless_simd::{Simd, SimdBase};

use super::joint::{JointSweep, turned};
use super::rows::{Line, Velocity, load_motion, load_velocity, store_velocity};
use super::softness::Softness;
use crate::base::disjoint::Rows;
use crate::base::wide::{
    LANES, Lanes, Sym3w, Vec3w, Wide, above, inverse_or_zero, load, max, min, select, splat,
};

/// A spring and damper of an axis.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Push {
    pub(crate) stiffness: Lanes,
    pub(crate) damping: Lanes,
    /// 1 where both count per effective mass.
    pub(crate) per_mass: Lanes,
    pub(crate) place: Lanes,
    pub(crate) speed: Lanes,
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
    /// Acceleration of B less that of A by gravity and forces.
    pub(crate) pull: [Lanes; 3],
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

/// The inverse of a positive semidefinite matrix, by L D Lᵀ. What has no inverse mass of its own (a body
/// whose rotation is locked) is left out.
#[inline(always)]
fn inverse<S: Simd>(simd: S, m: &Sym3w<S>) -> Sym3w<S> {
    let part = splat(simd, 1.0e-6);
    let zero = splat(simd, 0.0);
    let ix = inverse_or_zero(simd, m.xx);
    let (lx, mx) = (m.xy * ix, m.xz * ix);
    let dy = m.yy - m.xy * lx;
    let iy = select(above(dy, m.yy * part), inverse_or_zero(simd, dy), zero);
    let ly = (m.yz - m.xz * lx) * iy;
    let dz = m.zz - m.xz * mx - ly * ly * dy;
    let iz = select(above(dz, m.zz * part), inverse_or_zero(simd, dz), zero);
    // L⁻¹ has -lx, w, -ly below its ones.
    let w = lx * ly - mx;
    Sym3w {
        xx: ix + lx * lx * iy + w * w * iz,
        xy: -(lx * iy) - w * ly * iz,
        xz: w * iz,
        yy: iy + ly * ly * iz,
        yz: -(ly * iz),
        zz: iz,
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

/// Couplings of a row to three.
#[inline(always)]
fn couplings<S: Simd>(rows: &[Row<S>; 3], row: &Row<S>) -> Vec3w<S> {
    Vec3w { x: rows[0].coupling(row), y: rows[1].coupling(row), z: rows[2].coupling(row) }
}

/// The locked axes of a joint together.
struct Held<S: Simd> {
    along: [Row<S>; 3],
    about: [Row<S>; 3],
    /// L⁻¹, columns of C and of L⁻¹ C, (A - Cᵀ L⁻¹ C)⁻¹.
    l: Sym3w<S>,
    c: [Vec3w<S>; 3],
    lc: [Vec3w<S>; 3],
    a: Sym3w<S>,
}

impl<S: Simd> Held<S> {
    #[inline(always)]
    fn form(
        simd: S,
        along: &[Row<S>; 3],
        about: &[Row<S>; 3],
        locked: &[Wide<S>; 6],
        linear: Wide<S>,
    ) -> Self {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let [l0, l1, l2, k0, k1, k2] = *locked;
        let along = [along[0].masked(l0), along[1].masked(l1), along[2].masked(l2)];
        let about = [about[0].masked(k0), about[1].masked(k1), about[2].masked(k2)];
        // Axes that are not locked have ones on the diagonal.
        let own = [
            select(above(l0, zero), linear, one),
            select(above(l1, zero), linear, one),
            select(above(l2, zero), linear, one),
        ];
        let l = inverse(simd, &matrix(&along, own));
        let c = [
            couplings(&along, &about[0]),
            couplings(&along, &about[1]),
            couplings(&along, &about[2]),
        ];
        let lc = [l.mul(c[0]), l.mul(c[1]), l.mul(c[2])];
        let a = matrix(&about, [one - k0, one - k1, one - k2]);
        let a = Sym3w {
            xx: a.xx - c[0].dot(lc[0]),
            yy: a.yy - c[1].dot(lc[1]),
            zz: a.zz - c[2].dot(lc[2]),
            xy: a.xy - c[0].dot(lc[1]),
            xz: a.xz - c[0].dot(lc[2]),
            yz: a.yz - c[1].dot(lc[2]),
        };
        Self { along, about, l, c, lc, a: inverse(simd, &a) }
    }

    /// What impulses of the locked axes make these speeds of theirs.
    #[inline(always)]
    fn impulses(&self, along: Vec3w<S>, about: Vec3w<S>) -> [Vec3w<S>; 2] {
        let first = self.l.mul(along);
        let rest = Vec3w {
            x: about.x - self.c[0].dot(first),
            y: about.y - self.c[1].dot(first),
            z: about.z - self.c[2].dot(first),
        };
        let mu = self.a.mul(rest);
        [first - self.lc[0] * mu.x - self.lc[1] * mu.y - self.lc[2] * mu.z, mu]
    }

    /// Inverse mass of a row but for the linear part, and the impulses that keep the locked axes where they
    /// are under one of its own.
    #[inline(always)]
    fn behind(&self, row: &Row<S>) -> (Wide<S>, [Vec3w<S>; 2]) {
        let (kl, ka) = (couplings(&self.along, row), couplings(&self.about, row));
        let back = self.impulses(kl, ka);
        (row.coupling(row) - kl.dot(back[0]) - ka.dot(back[1]), back)
    }

    /// Gives the locked axes what answers an impulse `d`.
    #[inline(always)]
    fn answer(
        &self,
        q: &mut Pair<S>,
        d: Wide<S>,
        [along, about]: &[Vec3w<S>; 2],
        given: &mut [Wide<S>; 6],
    ) {
        let parts = [along.x, along.y, along.z, about.x, about.y, about.z];
        for i in 0..6 {
            let p = -(parts[i] * d);
            given[i] += p;
            if i < 3 {
                q.push_along(&self.along[i], p);
            } else {
                q.push_about(&self.about[i - 3], p);
            }
        }
    }

    /// Solves the locked axes. Their softness is that against loads: `loads` is what they carry but for
    /// their answers to drives and limits. (Those make torques that a small inertia would give way to by a
    /// tenth of a spring's stroke.)
    #[inline(always)]
    fn solve(
        &self,
        simd: S,
        block: &SixBlock,
        q: &mut Pair<S>,
        x: &[Wide<S>; 6],
        loads: &[Wide<S>; 6],
        softness: &Softness,
    ) -> [Wide<S>; 6] {
        let mass = splat(simd, softness.mass);
        let (rate, leak) = (splat(simd, softness.rate), splat(simd, softness.impulse));
        let mut miss = [splat(simd, 0.0); 6];
        for i in 0..6 {
            let locked = load(simd, &block.locked[i]);
            let off = (x[i] - load(simd, &block.place[i])) * locked;
            let speed = if i < 3 {
                q.speed_along(&self.along[i])
            } else {
                q.speed_about(&self.about[i - 3])
            };
            miss[i] = mass * speed + rate * off;
        }
        let [along, about] = self.impulses(
            Vec3w { x: miss[0], y: miss[1], z: miss[2] },
            Vec3w { x: miss[3], y: miss[4], z: miss[5] },
        );
        let solved = [along.x, along.y, along.z, about.x, about.y, about.z];
        let mut given = [splat(simd, 0.0); 6];
        for i in 0..6 {
            let locked = load(simd, &block.locked[i]);
            let d = -(solved[i] + leak * loads[i]) * locked;
            given[i] = d;
            if i < 3 {
                q.push_along(&self.along[i], d);
            } else {
                q.push_about(&self.about[i - 3], d);
            }
        }
        given
    }
}

/// The impulse of a spring in a substep: λ' = gain λ - (rate · error + gain v + bias) / K.
struct Law<S: Simd> {
    gain: Wide<S>,
    rate: Wide<S>,
    bias: Wide<S>,
}

impl Push {
    /// Where it is slower than a substep, a spring on the inverse mass `k` under the acceleration `pull`
    /// swings as the exact one does: v' = (1 - B) v - A x has the eigenvalues exp(z h), taken as
    /// (12 + 6 z + z²)/(12 - 6 z + z²), and rests where the exact one does. A faster one, or a motor, is taken
    /// at the end of the substep, which damps it. See docs/derivations/joints.md.
    #[inline(always)]
    fn law<S: Simd>(&self, simd: S, k: Wide<S>, pull: Wide<S>, inv_h: Wide<S>) -> Law<S> {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let (n6, n12, n72, n144) =
            (splat(simd, 6.0), splat(simd, 12.0), splat(simd, 72.0), splat(simd, 144.0));
        let h = one / inv_h;
        let per_mass = load(simd, &self.per_mass);
        let m = select(above(per_mass, zero), one, k) * h;
        let c = load(simd, &self.damping) * m;
        let p = load(simd, &self.stiffness) * m * h;
        let q = one / (n144 + n72 * c + n12 * (c * c + p) + n6 * p * c + p * p);
        let slow = Law {
            gain: n12 * c * (n12 + p) * q,
            rate: n144 * p * q * inv_h,
            bias: (n12 * p + p * p + n12 * c * c - n72 * c - n6 * p * c) * q * h * pull
                - n144 * c * q * load(simd, &self.speed),
        };
        let w = one / (one + c + p);
        let fast = Law {
            gain: (c + p) * w,
            rate: p * w * inv_h,
            bias: -(c * w * load(simd, &self.speed)),
        };
        let is_fast = above(max(c, p), one);
        Law {
            gain: select(is_fast, fast.gain, slow.gain),
            rate: select(is_fast, fast.rate, slow.rate),
            bias: select(is_fast, fast.bias, slow.bias),
        }
    }
}

impl<S: Simd> Law<S> {
    #[inline(always)]
    fn impulse(&self, inverse: Wide<S>, v: Wide<S>, error: Wide<S>, old: Wide<S>) -> Wide<S> {
        self.gain * old - (self.rate * error + self.gain * v + self.bias) * inverse
    }
}

/// What a drive or limit feels: inverse mass, coordinate, speed, and acceleration by gravity and forces.
#[derive(Clone, Copy)]
struct Felt<S: Simd> {
    k: Wide<S>,
    x: Wide<S>,
    v: Wide<S>,
    pull: Wide<S>,
}

/// Solves drive and limit of an axis; returns the impulse to give. In a relax sweep springs do not push:
/// they go by where the bodies were.
#[inline(always)]
fn drive_and_limit<S: Simd>(
    simd: S,
    block: &mut SixBlock,
    axis: usize,
    felt: Felt<S>,
    sweep: &JointSweep,
) -> Wide<S> {
    let (zero, inv_h) = (splat(simd, 0.0), splat(simd, sweep.inv_h));
    let is_locked = above(load(simd, &block.locked[axis]), zero);
    let (held, limit) = (&mut block.held[axis], &mut block.limit[axis]);
    let axis = &block.axes[axis];
    let Felt { k, x, v, pull } = felt;
    let inverse = inverse_or_zero(simd, k);
    let old = load(simd, held);
    let most = load(simd, &axis.most);
    let law = axis.drive.law(simd, k, pull, inv_h);
    let new = law.impulse(inverse, v, x - load(simd, &axis.drive.place), old);
    let new = max(min(new, most), -most);
    let new = if sweep.is_relax { select(above(law.rate, zero), old, new) } else { new };
    let new = select(is_locked, old, new);
    new.store_array(held);
    let given = new - old;
    let v = v + k * given;

    let old = load(simd, limit);
    let (low, high) = (load(simd, &axis.low), load(simd, &axis.high));
    let (over_low, over_high) = (x - low, x - high);
    let is_low = above(-over_high, over_low);
    let error = select(is_low, over_low, over_high);
    let open = above(select(is_low, error, -error), zero);
    let is_hard = above(load(simd, &axis.hard), zero);
    let soft = axis.limit.law(simd, k, pull, inv_h);
    let s = &sweep.softness;
    let hard = Law { gain: splat(simd, s.mass), rate: splat(simd, s.rate), bias: zero };
    let shut = hard.impulse(inverse, v, error, old);
    let ahead = old - (v + error * inv_h) * inverse;
    let push = soft.impulse(inverse, v, error, old);
    // Without room between them, both hold: a spring about one place.
    let tight = above(splat(simd, 1.0e-9), high - low);
    let new = select(is_hard, select(open, ahead, shut), select(open, zero, push));
    let new = select(tight, push, select(is_low, max(new, zero), min(new, zero)));
    let new = if sweep.is_relax { select(is_hard, new, old) } else { new };
    let new = select(is_locked, zero, new);
    new.store_array(limit);
    given + (new - old)
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
    let held = Held::form(simd, &along, &about, &locked, linear);
    // Drives and limits behind the locked axes: inverse masses, and the locked axes' answers.
    let (mut give, mut back) = ([zero; 6], [[gap; 2]; 6]);
    let mut loads = [zero; 6];
    for i in 0..6 {
        loads[i] = load(simd, &block.held[i]);
    }
    for i in 0..6 {
        if !(if i < 3 { block.moves } else { block.turns }) {
            continue;
        }
        let row = if i < 3 { &along[i] } else { &about[i - 3] };
        let row = row.masked(one - locked[i]);
        let k;
        (k, back[i]) = held.behind(&row);
        // What is left of a turn that the locked axes allow not at all is rounding.
        let least = row.coupling(&row) * splat(simd, 1.0e-5);
        give[i] = if i < 3 { max(linear + k, linear) } else { select(above(k, least), k, zero) };
        let pushes = load(simd, &block.held[i]) + load(simd, &block.limit[i]);
        let [a, b] = [back[i][0] * pushes, back[i][1] * pushes];
        let parts = [a.x, a.y, a.z, b.x, b.y, b.z];
        for j in 0..6 {
            loads[j] += parts[j];
        }
    }
    let mut given = held.solve(simd, block, &mut q, &x, &loads, &sweep.softness);
    let pull = Vec3w::load(simd, &block.pull);
    let pulls = [pull.dot(held.along[0].n), pull.dot(held.along[1].n), pull.dot(held.along[2].n)];
    for i in 0..6 {
        if !(if i < 3 { block.moves } else { block.turns }) {
            continue;
        }
        let row = if i < 3 { &along[i] } else { &about[i - 3] };
        let row = row.masked(one - locked[i]);
        let v = if i < 3 { q.speed_along(&row) } else { q.speed_about(&row) };
        let Vec3w { x: p0, y: p1, z: p2 } = back[i][0];
        let own = if i < 3 { pull.dot(row.n) } else { zero };
        let pull = own - (p0 * pulls[0] + p1 * pulls[1] + p2 * pulls[2]);
        let felt = Felt { k: give[i], x: x[i], v, pull };
        let d = drive_and_limit(simd, block, i, felt, sweep);
        if i < 3 {
            q.push_along(&row, d);
        } else {
            q.push_about(&row, d);
        }
        held.answer(&mut q, d, &back[i], &mut given);
    }
    for i in 0..6 {
        // Those of a drive are stored already.
        let lock = load(simd, &block.held[i]) + given[i] * locked[i];
        lock.store_array(&mut block.held[i]);
    }

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
