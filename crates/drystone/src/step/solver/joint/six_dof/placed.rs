//! A block of six-axis joints at its current poses, and the solve of drive, friction and limit of
//! one axis.

use fearless_simd::Simd;

use super::block::SixDofBlock;
use super::drive::Law;
use super::locked_axes::Row;
use crate::base::simd::wide::{
    Sym3w, Vec3w, Wide, above, inverse_or_zero, load, max, min, select, splat,
};
use crate::base::threads::disjoint::ReadRows;
use crate::step::solver::body::integrate::load_start;
use crate::step::solver::body::row::Aux;
use crate::step::solver::joint::sweep::{JointSweep, Rotation};
use crate::step::solver_body::{SolverBody, Velocity};

/// Maximum impulse with which a drive presses on a hard limit of its own axis, in closing speeds of
/// limits per inverse mass. Two opposite impulses round to 6e-8 of their size, so what is left over
/// moves an axis at 2.5e-4 of that speed at most: 0.7 mm/s, 2 mrad/s.
const PRESS: f32 = 4096.0;

/// State of an axis for drive, friction and limit: inverse mass, coordinate, speed, and the speed
/// at the start of the substep.
#[derive(Clone, Copy)]
pub(crate) struct AxisState<S: Simd> {
    pub(crate) k: Wide<S>,
    pub(crate) x: Wide<S>,
    pub(crate) v: Wide<S>,
    pub(crate) start: Wide<S>,
}

/// Solves drive, friction and limit of an axis. `old` are their accumulated impulses; returns the
/// new ones. In a relax sweep springs keep their impulse, because it depends on the former
/// positions.
#[inline(always)]
pub(crate) fn act<S: Simd>(
    simd: S,
    block: &SixDofBlock,
    axis: usize,
    [old, old_friction, old_limit]: [Wide<S>; 3],
    felt: AxisState<S>,
    sweep: &JointSweep,
) -> [Wide<S>; 3] {
    let (zero, inv_h) = (splat(simd, 0.0), splat(simd, sweep.inv_h));
    let hardest = splat(simd, sweep.hardest);
    let is_locked = above(load(simd, &block.locked[axis]), zero);
    let max_back = splat(simd, sweep.caps.push(axis));
    let press = splat(simd, PRESS) * max_back;
    let axis = &block.axes[axis];
    let AxisState { k, x, v, start } = felt;
    // Speed added by forces, contacts and other joints in the substep: the change without the
    // axis's own impulse.
    let gained = |v: Wide<S>, own: Wide<S>| v - k * own - start;
    let inverse = inverse_or_zero(simd, k);
    let mut drive = zero;
    if axis.drives {
        let maximum = load(simd, &axis.maximum);
        let law = axis.drive.law(simd, k, gained(v, old), [inv_h, hardest]);
        let new = law.impulse(inverse, v, x - load(simd, &axis.drive.place), old);
        drive = max(min(new, maximum), -maximum);
        if axis.limits {
            // A hard stop would take the excess: neither row gets it.
            let hard = above(load(simd, &axis.hard), zero);
            let most = press * inverse;
            let low = select(above(old_limit, zero), max(drive, -most), drive);
            let both = select(above(zero, old_limit), min(low, most), low);
            drive = select(hard, both, drive);
        }
        if sweep.is_relax {
            drive = select(above(law.rate, zero), old, drive);
        }
    }
    let drive = select(is_locked, old, drive);
    let v = v + k * (drive - old);

    let maximum = load(simd, &axis.friction);
    let friction = max(min(old_friction - v * inverse, maximum), -maximum);
    let v = v + k * (friction - old_friction);

    if !axis.limits {
        return [drive, friction, zero];
    }
    let old = old_limit;
    let (low, high) = (load(simd, &axis.low), load(simd, &axis.high));
    let (over_low, over_high) = (x - low, x - high);
    let is_low = above(-over_high, over_low);
    let error = select(is_low, over_low, over_high);
    let open = above(select(is_low, error, -error), zero);
    let s = &sweep.softness;
    let hard = Law { gain: splat(simd, s.mass), rate: splat(simd, s.rate), bias: zero };
    // A stop is soft to what bodies press on it, not to the drive of its own axis.
    let pressed = select(is_low, min(drive, zero), max(drive, zero));
    let held = hard.impulse(inverse, v, error, old) - splat(simd, s.impulse) * pressed;
    // The speed at which an error closes is bounded, not the load.
    let shut = select(
        is_low,
        min(held, old + (max_back - v) * inverse),
        max(held, old - (max_back + v) * inverse),
    );
    let ahead = old - (v + error * inv_h) * inverse;
    let one_way = |new: Wide<S>| select(is_low, max(new, zero), min(new, zero));
    let mut limit = one_way(select(open, ahead, shut));
    if axis.yields {
        let is_hard = above(load(simd, &axis.hard), zero);
        let law = axis.limit.law(simd, k, gained(v, old), [inv_h, hardest]);
        let sprung = law.impulse(inverse, v, error, old);
        // With no range between them, both limits hold: a spring about one coordinate.
        let tight = above(splat(simd, 1.0e-9), high - low);
        let soft = select(tight, sprung, one_way(select(open, zero, sprung)));
        limit = select(is_hard, limit, if sweep.is_relax { old } else { soft });
    }
    [drive, friction, select(is_locked, zero, limit)]
}

/// The bodies of a block's joints at the poses of this sweep's rows.
pub(crate) struct Placed<S: Simd> {
    pub(crate) alpha: Wide<S>,
    pub(crate) beta: Wide<S>,
    pub(crate) sa: Sym3w<S>,
    pub(crate) sb: Sym3w<S>,
    pub(crate) va: Velocity<S>,
    pub(crate) vb: Velocity<S>,
    /// Velocities at the start of the substep; the current ones if no spring needs them.
    pub(crate) start_a: Velocity<S>,
    pub(crate) start_b: Velocity<S>,
    /// Angular velocities of kinematic bodies.
    pub(crate) spin_a: Vec3w<S>,
    pub(crate) spin_b: Vec3w<S>,
    /// Rotation of A since the step's start, and rotation of B relative to A.
    pub(crate) to_a: Rotation<S>,
    turn: Vec3w<S>,
    pub(crate) arm_a: Vec3w<S>,
    pub(crate) arm_b: Vec3w<S>,
    pub(crate) gap: Vec3w<S>,
    /// Velocity of B's anchor less that of A's, from kinematic bodies.
    pub(crate) drift: Vec3w<S>,
}

impl<S: Simd> Placed<S> {
    #[inline(always)]
    pub(crate) fn read(
        simd: S,
        block: &SixDofBlock,
        (solver_bodies, aux): (&ReadRows<'_, SolverBody>, &ReadRows<'_, Aux>),
        sweep: &JointSweep,
    ) -> Self {
        let (alpha, beta) = (load(simd, &block.alpha), load(simd, &block.beta));
        let (sa, sb) = (Sym3w::load(simd, &block.s_a), Sym3w::load(simd, &block.s_b));
        let (va, xa) = sweep.read(simd, solver_bodies, &block.row_a);
        let (vb, xb) = sweep.read(simd, solver_bodies, &block.row_b);
        let (mut start_a, mut start_b) = (va, vb);
        if block.springs {
            start_a = load_start(simd, aux, &block.row_a);
            start_b = load_start(simd, aux, &block.row_b);
        }
        let elapsed = splat(simd, sweep.elapsed);
        let (spin_a, spin_b) = (Vec3w::load(simd, &block.spin_a), Vec3w::load(simd, &block.spin_b));
        let turn_a = sa.mul(xa.w) + spin_a * elapsed;
        let turn_b = sb.mul(xb.w) + spin_b * elapsed;
        let (to_a, to_b) = (Rotation::new(simd, turn_a), Rotation::new(simd, turn_b));
        let (r0a, r0b) = (Vec3w::load(simd, &block.r_a), Vec3w::load(simd, &block.r_b));
        // Add displacements only: lever arms of meters would round away the gap.
        let (shift_a, shift_b) = (to_a.shift(r0a), to_b.shift(r0b));
        let (ra, arm_b) = (r0a + shift_a, r0b + shift_b);
        let drift = Vec3w::load(simd, &block.drift);
        let moved = xb.v * beta - xa.v * alpha + drift * elapsed;
        let gap = Vec3w::load(simd, &block.gap) + (moved + (shift_b - shift_a));
        let arm_a = ra + gap;
        let turn = turn_b - turn_a - turn_a.cross(turn_b) * splat(simd, 0.5);
        let drift = drift + spin_b.cross(arm_b) - spin_a.cross(arm_a);
        Self {
            alpha,
            beta,
            sa,
            sb,
            va,
            vb,
            start_a,
            start_b,
            spin_a,
            spin_b,
            to_a,
            turn,
            arm_a,
            arm_b,
            gap,
            drift,
        }
    }

    /// The row of a rotation, and its angle.
    #[inline(always)]
    pub(crate) fn about(&self, simd: S, block: &SixDofBlock, i: usize) -> (Row<S>, Wide<S>) {
        let n = Vec3w::load(simd, &block.n[i]);
        let row = Row::about(self.to_a.apply(n), [&self.sa, &self.sb]);
        (row, load(simd, &block.angles[i]) + n.dot(self.turn))
    }

    /// Angular velocities.
    #[inline(always)]
    pub(crate) fn spins(&self) -> [Vec3w<S>; 2] {
        [self.sa.mul(self.va.w) + self.spin_a, self.sb.mul(self.vb.w) + self.spin_b]
    }

    /// Velocity of B's anchor less that of A's.
    #[inline(always)]
    pub(crate) fn slip(&self) -> Vec3w<S> {
        let (wa, wb) = (self.sa.mul(self.va.w), self.sb.mul(self.vb.w));
        self.vb.v * self.beta - self.va.v * self.alpha + self.drift + wb.cross(self.arm_b)
            - wa.cross(self.arm_a)
    }
}

/// The warm start of a block in the current rows, and the impulses that a sweep adds: linear, and
/// about anchor B.
pub(crate) struct LockedImpulses<S: Simd> {
    pub(crate) old: [Vec3w<S>; 2],
    pub(crate) new: [Vec3w<S>; 2],
}
