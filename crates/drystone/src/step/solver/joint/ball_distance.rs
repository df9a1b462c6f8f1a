//! The kernels of ball and distance joints: solve eight at a time.
//!
//! Anchors rotate with the bodies within a step, so that a pendulum follows its circle substep by
//! substep; S stays that of the step's start. As for contacts, the bodies carry the warm start of a
//! joint, along the joint's former rows. Each solve first maps it to the current rows, `(J -
//! J_last)ᵀ λ`. Without that the impulse lags behind and a pendulum gains energy.
//!
//! A relax sweep must not map it. The impulse of the solve before it has been applied once, at the
//! lever arms of that time. To rotate it after the position update would be a force against the
//! motion, g h θ' per sweep for a pendulum. Also, a relax sweep takes its rows at the middle of the
//! substep's motion. There the chord along which the bodies moved is tangent to their path, so a
//! steady rotation is left unchanged.
//!
//! See docs/decisions/016-joint-energy.md.

use fearless_simd::{Simd, SimdBase};

use super::block::{JointBlock, JointExtra};
use super::root::{Root, RootRows};
use super::sweep::{JointSweep, Rotation, bend};
use crate::base::simd::wide::{Sym3w, Vec3w, Wide, above, load, max, select, splat, sqrt};
use crate::base::threads::disjoint::{Next, ReadRows, Rows};
use crate::step::solver_body::{SolverBody, Velocity, store_velocity};

/// The next block, to prefetch.
#[derive(Clone, Copy)]
pub(crate) struct Ahead<'a> {
    pub(crate) block: Next<'a, JointBlock>,
    pub(crate) extra: Next<'a, JointExtra>,
}

impl Ahead<'_> {
    /// Prefetches its first or second half.
    #[inline(always)]
    fn prefetch<S: Simd, R: Root<S>>(&self, half: usize) {
        const LINES: usize = size_of::<JointBlock>() / 64;
        self.block.prefetch(half * LINES / 2..(half + 1) * LINES / 2);
        self.extra.prefetch(half * R::REST_LINES / 2..(half + 1) * R::REST_LINES / 2);
    }
}

/// Current lever arms, gap and velocities of eight joints.
struct State<S: Simd, R: Root<S>> {
    alpha: Wide<S>,
    beta: Wide<S>,
    sa: R,
    sb: R,
    ra: Vec3w<S>,
    rb: Vec3w<S>,
    gap: Vec3w<S>,
    drift: Vec3w<S>,
    va: Velocity<S>,
    vb: Velocity<S>,
}

#[inline(always)]
fn read<S: Simd, R: Root<S>>(
    simd: S,
    (block, extra): (&JointBlock, &JointExtra),
    fixed: bool,
    solver_bodies: &ReadRows<'_, SolverBody>,
    sweep: &JointSweep,
) -> State<S, R> {
    let (alpha, beta) = (load(simd, &block.alpha), load(simd, &block.beta));
    let [sa, sb] = R::pair(simd, block, extra);
    let (va, xa) = sweep.read(simd, solver_bodies, &block.row_a);
    let (vb, xb) = sweep.read(simd, solver_bodies, &block.row_b);
    let (r0a, r0b) = (Vec3w::load(simd, &block.r_a), Vec3w::load(simd, &block.r_b));
    // An exact rotation: to second order a lever arm would grow by an eighth at one radian per
    // step.
    let (to_a, to_b) = (Rotation::new(simd, sa.mul(xa.w)), Rotation::new(simd, sb.mul(xb.w)));
    let (shift_a, shift_b) = (to_a.shift(r0a), to_b.shift(r0b));
    let (ra, rb) = (r0a + shift_a, r0b + shift_b);
    let mut gap = Vec3w::load(simd, &block.gap) + xb.v * beta - xa.v * alpha + (shift_b - shift_a);
    let mut drift = Vec3w::zero(simd);
    if fixed {
        drift = Vec3w::load(simd, &extra.drift);
        gap = gap + drift * splat(simd, sweep.elapsed);
    }
    State { alpha, beta, sa, sb, ra, rb, gap, drift, va, vb }
}

impl<S: Simd, R: Root<S>> State<S, R> {
    /// Velocity of anchor B relative to anchor A.
    #[inline(always)]
    fn slip(&self) -> Vec3w<S> {
        self.vb.v * self.beta - self.va.v * self.alpha
            + self.drift
            + (self.sb.mul(self.vb.w).cross(self.rb) - self.sa.mul(self.va.w).cross(self.ra))
    }

    /// Contribution of rotation within the substep to the gap's mean speed; and the substep's
    /// length, 0 in a relax sweep, whose rows are at the middle of the substep.
    #[inline(always)]
    fn bend(&self, simd: S, sweep: &JointSweep) -> (Vec3w<S>, Wide<S>) {
        if sweep.is_relax {
            return (Vec3w::zero(simd), splat(simd, 0.0));
        }
        let h = splat(simd, 1.0) / splat(simd, sweep.inv_h);
        let (wa, wb) = (self.sa.mul(self.va.w), self.sb.mul(self.vb.w));
        (bend(simd, [wa, wb], [self.ra, self.rb], h), h)
    }

    /// Adds the moments of an impulse `p` at the current lever arms, less the moments that the
    /// bodies carry. Together with the carried linear part this equals applying `p` of the last
    /// sweep now.
    #[inline(always)]
    fn turn_moments(&mut self, simd: S, block: &JointBlock, p: Vec3w<S>) {
        let da = self.ra.cross(p) - Vec3w::load(simd, &block.carried_a);
        let db = self.rb.cross(p) - Vec3w::load(simd, &block.carried_b);
        self.va.w = self.va.w - self.sa.mul(da);
        self.vb.w = self.vb.w + self.sb.mul(db);
    }

    /// Stores the moments that the bodies carry after this sweep: those of `p` at the current lever
    /// arms.
    #[inline(always)]
    fn carry(&self, block: &mut JointBlock, p: Vec3w<S>) {
        self.ra.cross(p).store(&mut block.carried_a);
        self.rb.cross(p).store(&mut block.carried_b);
    }

    /// Adds the moments of a further impulse `d` to those that the bodies carry.
    #[inline(always)]
    fn carry_more(&self, simd: S, block: &mut JointBlock, d: Vec3w<S>) {
        let (a, b) = (Vec3w::load(simd, &block.carried_a), Vec3w::load(simd, &block.carried_b));
        (a + self.ra.cross(d)).store(&mut block.carried_a);
        (b + self.rb.cross(d)).store(&mut block.carried_b);
    }
}

/// Solves one block of ball joints once.
#[inline(always)]
pub(crate) fn solve_ball<S: Simd, R: Root<S>>(
    simd: S,
    (block, extra): (&mut JointBlock, &JointExtra),
    next: Ahead<'_>,
    fixed: bool,
    solver_bodies: &Rows<'_, SolverBody>,
    sweep: &JointSweep,
) {
    next.prefetch::<S, R>(0);
    let mut q = read::<S, R>(simd, (block, extra), fixed, solver_bodies, sweep);
    let old = Vec3w::load(simd, &block.impulse);
    if !sweep.is_relax {
        // The bodies carry the linear part unchanged.
        q.turn_moments(simd, block, old);
    }
    next.prefetch::<S, R>(1);
    let bend = q.bend(simd, sweep).0;
    let (a, b) = (q.sa.rows(q.ra), q.sb.rows(q.rb));
    let linear = q.alpha * q.alpha + q.beta * q.beta;
    let zero = splat(simd, 0.0);
    let k = Sym3w { xx: linear, yy: linear, zz: linear, xy: zero, xz: zero, yz: zero };
    let k = b.add_products(a.add_products(k));
    let speed =
        q.vb.v * q.beta - q.va.v * q.alpha + (q.drift + bend) + (b.dot(q.vb.w) - a.dot(q.va.w));
    let rate = splat(simd, sweep.softness.rate);
    let bias = Vec3w {
        x: sweep.caps.closing(simd, q.gap.x, rate),
        y: sweep.caps.closing(simd, q.gap.y, rate),
        z: sweep.caps.closing(simd, q.gap.z, rate),
    };
    let wanted = speed * splat(simd, sweep.softness.mass) + bias;
    let d = -k.solve(simd, wanted) - old * splat(simd, sweep.softness.impulse);
    (old + d).store(&mut block.impulse);
    if sweep.is_relax {
        q.carry_more(simd, block, d);
    } else {
        q.carry(block, old + d);
    }
    q.va.v = q.va.v - d * q.alpha;
    q.vb.v = q.vb.v + d * q.beta;
    q.va.w = a.take(q.va.w, d);
    q.vb.w = b.add(q.vb.w, d);
    store_velocity(simd, solver_bodies, &block.row_a, q.va);
    store_velocity(simd, solver_bodies, &block.row_b, q.vb);
}

/// Solves one block of distance joints once: a rod if both limits are equal, otherwise spring and
/// limits.
#[inline(always)]
pub(crate) fn solve_distance<S: Simd>(
    simd: S,
    (block, extra): (&mut JointBlock, &mut JointExtra),
    next: Ahead<'_>,
    fixed: bool,
    solver_bodies: &Rows<'_, SolverBody>,
    sweep: &JointSweep,
) {
    next.prefetch::<S, Sym3w<S>>(0);
    next.prefetch::<S, Sym3w<S>>(1);
    let mut q = read::<S, Sym3w<S>>(simd, (block, extra), fixed, solver_bodies, sweep);
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let length = sqrt(q.gap.dot(q.gap));
    let apart = above(length, splat(simd, 1.0e-9));
    // Anchors at one point have no direction: use a fixed one.
    let scale = select(apart, one / length, zero);
    let n = q.gap * scale;
    let n = Vec3w { x: n.x, y: select(apart, n.y, one), z: n.z };
    let (a, b) = (q.sa.mul(q.ra.cross(n)), q.sb.mul(q.rb.cross(n)));
    let k = q.alpha * q.alpha + q.beta * q.beta + a.dot(a) + b.dot(b);
    let mass = select(above(k, zero), one / k, zero);
    let Vec3w { x: i0, y: i1, z: i2 } = Vec3w::load(simd, &block.impulse);
    let carried = Vec3w::load(simd, &extra.carried);
    if !sweep.is_relax {
        let p = n * (i0 - i1 + i2);
        q.va.v = q.va.v - (p - carried) * q.alpha;
        q.vb.v = q.vb.v + (p - carried) * q.beta;
        q.turn_moments(simd, block, p);
    }
    let (bend, h) = q.bend(simd, sweep);
    let slip = q.slip();
    let along = n.dot(slip);
    // Add the rotation of the line between the anchors: v² h/2 over its length, at most a chord.
    let across = h * splat(simd, 0.5) * (slip.dot(slip) - along * along) * scale;
    let across = across / (one + across * h * splat(simd, 0.5) * scale);
    let mut vn = along + n.dot(bend) + across;
    let Vec3w { x: minimum, y: maximum, z: unstrained } = Vec3w::load(simd, &extra.limits);
    let Vec3w { x: rate, y: soft, z: leak } = Vec3w::load(simd, &extra.spring);
    let s = &sweep.softness;
    let (rigid_rate, rigid_mass, rigid_leak) =
        (splat(simd, s.rate), splat(simd, s.mass), splat(simd, s.impulse));
    let inv_h = splat(simd, sweep.inv_h);

    // Spring.
    let d = -(mass * (soft * vn + rate * (length - unstrained))) - leak * i2;
    let n2 = i2 + d;
    vn += k * d;
    let mut pushed = d;

    // Lower limit or rod. A rod's impulse may have either sign.
    let rod = above(splat(simd, 1.0e-9), maximum - minimum);
    let gap = length - minimum;
    let open = above(gap, zero);
    let free = select(rod, zero, select(open, one, zero));
    let is_free = above(free, zero);
    let bias = select(is_free, gap * inv_h, sweep.caps.closing(simd, gap, rigid_rate));
    let gain = select(is_free, one, rigid_mass);
    let give = select(is_free, zero, rigid_leak);
    let n0 = i0 - mass * (gain * vn + bias) - give * i0;
    let n0 = select(rod, n0, max(n0, zero));
    let d = n0 - i0;
    vn += k * d;
    pushed += d;

    // Upper limit: pulls the anchors together.
    let gap = maximum - length;
    let open = above(gap, zero);
    let bias = select(open, gap * inv_h, sweep.caps.closing(simd, gap, rigid_rate));
    let gain = select(open, one, rigid_mass);
    let give = select(open, zero, rigid_leak);
    let n1 = max(i1 - mass * (bias - gain * vn) - give * i1, zero);
    let n1 = select(rod, zero, n1);
    pushed -= n1 - i1;

    if sweep.is_relax {
        (carried + n * pushed).store(&mut extra.carried);
        q.carry_more(simd, block, n * pushed);
    } else {
        (n * (n0 - n1 + n2)).store(&mut extra.carried);
        q.carry(block, n * (n0 - n1 + n2));
    }
    n0.store_array(&mut block.impulse[0]);
    n1.store_array(&mut block.impulse[1]);
    n2.store_array(&mut block.impulse[2]);
    q.va.v = q.va.v - n * (pushed * q.alpha);
    q.vb.v = q.vb.v + n * (pushed * q.beta);
    q.va.w = q.va.w - a * pushed;
    q.vb.w = q.vb.w + b * pushed;
    store_velocity(simd, solver_bodies, &block.row_a, q.va);
    store_velocity(simd, solver_bodies, &block.row_b, q.vb);
}
