//! The kernel of six-axis joints: solves eight at a time.
//!
//! Symbols: u are the axes of translation (rotated with body A), n the axes of rotation, λ impulses
//! along u, μ about n; d is anchor B less anchor A. A force along u acts at anchor B on both
//! bodies, so it makes no torque at d ≠ 0 (a slider): the lever arm of A is r_a + d. Angles advance
//! from the step's start by ε = θ_b - θ_a - θ_a × θ_b / 2, the rotation of B relative to A to
//! second order, without trigonometry.
//!
//! All locked axes are solved first, as one system. Their 6 × 6 matrix has the blocks L over the
//! locked translations, A over the rotations and C between them:
//!
//! ```text
//! | L   C |
//! | Cᵀ  A |      rotations are solved with A - Cᵀ L⁻¹ C
//! ```
//!
//! Then drive, friction and limit follow, one axis after another, each through the locked axes.
//! With K the coupling of its row to theirs and M their inverse matrix, its inverse mass is reduced
//! by Kᵀ M K. Along with its impulse the locked axes get -M K of it, which keeps them at rest. So
//! the mass at a hinge's limit is that of a body about its anchor, and a slider's spring acts on
//! the whole mass wherever its anchor is. (Without that a sweep removes only a quarter of the speed
//! of a rod held at its end.)
//!
//! The warm start works as for ball joints: see ball_distance.rs and
//! docs/decisions/016-joint-energy.md.

use fearless_simd::{Simd, SimdBase};

use super::block::SixDofBlock;
use super::kernel_anchored;
use super::locked_axes::{LockedAxes, Pair, Row};
use super::placed::{AxisState, LockedImpulses, Placed, act};
use crate::base::simd::wide::{Vec3w, Wide, above, load, max, select, splat};
use crate::base::threads::disjoint::Rows;
use crate::step::solver::body::row::Aux;
use crate::step::solver::joint::sweep::{JointSweep, bend};
use crate::step::solver_body::{SolverBody, Velocity, store_velocity};

/// The joints of a block in this sweep.
struct State<S: Simd> {
    pair: Pair<S>,
    along: [Row<S>; 3],
    about: [Row<S>; 3],
    /// Coordinates.
    x: [Wide<S>; 6],
    locked: [Wide<S>; 6],
}

#[inline(always)]
fn state_of<S: Simd>(simd: S, block: &SixDofBlock, at: &Placed<S>, sweep: &JointSweep) -> State<S> {
    let u0 = Vec3w::load3(simd, &block.u);
    let (arms, roots) = ([at.arm_a, at.arm_b], [&at.sa, &at.sb]);
    // No loops: arrays indexed in a loop were kept in memory and copied from there.
    let along = [
        Row::along(at.to_a.apply(u0[0]), arms, roots),
        Row::along(at.to_a.apply(u0[1]), arms, roots),
        Row::along(at.to_a.apply(u0[2]), arms, roots),
    ];
    let [(n0, x0), (n1, x1), (n2, x2)] =
        [at.about(simd, block, 0), at.about(simd, block, 1), at.about(simd, block, 2)];
    let gap = at.gap;
    let x = [along[0].n.dot(gap), along[1].n.dot(gap), along[2].n.dot(gap), x0, x1, x2];
    let [l0, l1, l2, k0, k1, k2] = &block.locked;
    let locked = [
        load(simd, l0),
        load(simd, l1),
        load(simd, l2),
        load(simd, k0),
        load(simd, k1),
        load(simd, k2),
    ];
    let mut curve = Vec3w::zero(simd);
    if !sweep.is_relax {
        let h = splat(simd, 1.0) / splat(simd, sweep.inv_h);
        let [wa, wb] = at.spins();
        curve = bend(simd, [wa, wb], arms, h) - wa.cross(at.slip()) * h;
    }
    let pair = Pair {
        alpha: at.alpha,
        beta: at.beta,
        sa: at.sa,
        sb: at.sb,
        va: at.va,
        vb: at.vb,
        drift: at.drift,
        bend: curve,
        spin: at.spin_b - at.spin_a,
        arm_a: at.arm_a,
        arm_b: at.arm_b,
        force: Vec3w::zero(simd),
        torque: Vec3w::zero(simd),
    };
    State { pair, along, about: [n0, n1, n2], x, locked }
}

/// Solves one block once.
#[inline(always)]
pub(crate) fn solve<S: Simd>(
    simd: S,
    block: &mut SixDofBlock,
    (solver_bodies, aux): (&Rows<'_, SolverBody>, &Rows<'_, Aux>),
    sweep: &JointSweep,
) {
    let at = Placed::read(simd, block, (solver_bodies, aux), sweep);
    let given = match (block.is_anchored, block.locks[1]) {
        (true, true) => kernel_anchored::solve::<S, true>(simd, block, &at, sweep),
        (true, false) => kernel_anchored::solve::<S, false>(simd, block, &at, sweep),
        (false, true) => solve_loose::<S, true>(simd, block, &at, sweep),
        (false, false) => solve_loose::<S, false>(simd, block, &at, sweep),
    };
    let [p, t] = given.old;
    let [mut force, torque] = given.new;
    (t + torque).store(&mut block.torque);
    let mut more_a = at.arm_a.cross(force) + torque;
    let mut more_b = at.arm_b.cross(force) + torque;
    let carried = Vec3w::load(simd, &block.carried);
    let carried_a = Vec3w::load(simd, &block.carried_a);
    let carried_b = Vec3w::load(simd, &block.carried_b);
    if sweep.is_relax {
        (carried + force).store(&mut block.carried);
        (carried_a + more_a).store(&mut block.carried_a);
        (carried_b + more_b).store(&mut block.carried_b);
    } else {
        let (moment_a, moment_b) = (at.arm_a.cross(p) + t, at.arm_b.cross(p) + t);
        (p + force).store(&mut block.carried);
        (moment_a + more_a).store(&mut block.carried_a);
        (moment_b + more_b).store(&mut block.carried_b);
        force = force + (p - carried);
        more_a = more_a + (moment_a - carried_a);
        more_b = more_b + (moment_b - carried_b);
    }
    // One addition for all changes: the rounding error of an addition to a velocity is repeated in
    // every later substep.
    let a = Velocity { v: at.va.v - force * at.alpha, w: at.va.w - at.sa.mul(more_a) };
    let b = Velocity { v: at.vb.v + force * at.beta, w: at.vb.w + at.sb.mul(more_b) };
    store_velocity(simd, solver_bodies, &block.row_a, shown(simd, a, sweep));
    store_velocity(simd, solver_bodies, &block.row_b, shown(simd, b, sweep));
}

/// Solves joints with a free or sprung translation. `TURNS`: some joint of the block locks a
/// rotation.
#[inline(always)]
fn solve_loose<S: Simd, const TURNS: bool>(
    simd: S,
    block: &mut SixDofBlock,
    at: &Placed<S>,
    sweep: &JointSweep,
) -> LockedImpulses<S> {
    let mut state = state_of(simd, block, at, sweep);
    // The warm start, each impulse along its axis.
    let (mut p, mut t) = (Vec3w::zero(simd), Vec3w::zero(simd));
    for i in 0..3 {
        let (lambda, mu) = (block.pushes(simd, i), block.pushes(simd, i + 3));
        p = p + state.along[i].n * lambda;
        t = t + state.about[i].n * mu;
    }
    if !sweep.is_relax {
        let q = &mut state.pair;
        let more = p - Vec3w::load(simd, &block.carried);
        let more_a = q.arm_a.cross(p) + t - Vec3w::load(simd, &block.carried_a);
        let more_b = q.arm_b.cross(p) + t - Vec3w::load(simd, &block.carried_b);
        q.va.v = q.va.v - more * q.alpha;
        q.vb.v = q.vb.v + more * q.beta;
        q.va.w = q.va.w - q.sa.mul(more_a);
        q.vb.w = q.vb.w + q.sb.mul(more_b);
    }
    solve_axes::<S, TURNS>(simd, block, (&mut state, [&at.start_a, &at.start_b]), sweep);
    LockedImpulses { old: [p, t], new: [state.pair.force, state.pair.torque] }
}

/// Flushes negligible velocities to zero. Where all axes are held, by friction for example, every
/// visit leaves 1e-7 of a speed. It would end as a subnormal number, and rotations with it. These
/// take a processor up to a hundred times as long.
#[inline(always)]
fn shown<S: Simd>(simd: S, velocity: Velocity<S>, sweep: &JointSweep) -> Velocity<S> {
    let (zero, minimum) = (splat(simd, 0.0), splat(simd, sweep.caps.minimum));
    let part = |x: Wide<S>| select(above(minimum, max(x, -x)), zero, x);
    let Velocity { v, w } = velocity;
    Velocity {
        v: Vec3w { x: part(v.x), y: part(v.y), z: part(v.z) },
        w: Vec3w { x: part(w.x), y: part(w.y), z: part(w.z) },
    }
}

impl<S: Simd> State<S> {
    /// The row of an axis where it is not locked. `TURNS`: some joint of the block locks a
    /// rotation.
    #[inline(always)]
    fn free_row<const TURNS: bool>(&self, simd: S, axis: usize) -> Row<S> {
        let free = splat(simd, 1.0) - self.locked[axis];
        if axis < 3 {
            self.along[axis].masked(free)
        } else if TURNS {
            self.about[axis - 3].masked(free)
        } else {
            self.about[axis - 3]
        }
    }
}

/// Solves the locked axes, then drives and limits through them. `TURNS`: some joint of the block
/// locks a rotation.
#[inline(always)]
fn solve_axes<S: Simd, const TURNS: bool>(
    simd: S,
    block: &mut SixDofBlock,
    (state, start): (&mut State<S>, [&Velocity<S>; 2]),
    sweep: &JointSweep,
) {
    let zero = splat(simd, 0.0);
    let linear = state.pair.alpha * state.pair.alpha + state.pair.beta * state.pair.beta;
    let locked = state.locked;
    let mut locked_axes =
        LockedAxes::<S, TURNS>::of(simd, &state.along, &state.about, &locked, block.locks[0]);
    locked_axes.invert(simd, &locked, linear);
    // The inverse mass of each drive and limit, and the response of the locked axes to it.
    let none = Vec3w::zero(simd);
    let (mut give, mut back) = ([zero; 6], [[none; 2]; 6]);
    let mut loads = [zero; 6];
    for i in 0..6 {
        loads[i] = load(simd, &block.lock_or_drive[i]);
    }
    for i in 0..6 {
        if !block.acts_on(i) {
            continue;
        }
        let row = state.free_row::<TURNS>(simd, i);
        let k;
        (k, back[i]) = locked_axes.behind(&row);
        // For a rotation that the locked axes exclude completely, the remainder is rounding error.
        let minimum = row.coupling(&row) * splat(simd, 1.0e-5);
        give[i] = if i < 3 { max(linear + k, linear) } else { select(above(k, minimum), k, zero) };
        let pushes = block.pushes(simd, i);
        let [a, b] = [back[i][0] * pushes, back[i][1] * pushes];
        let parts = [a.x, a.y, a.z, b.x, b.y, b.z];
        for j in 0..6 {
            if block.locks[j / 3] {
                loads[j] += parts[j];
            }
        }
    }
    let mut given = locked_axes.solve(simd, block, &mut state.pair, &state.x, &loads, sweep);
    for i in 0..6 {
        if !block.acts_on(i) {
            continue;
        }
        let row = state.free_row::<TURNS>(simd, i);
        let q = &mut state.pair;
        let speed = |of| if i < 3 { q.speed_along(&row, of) } else { q.speed_about(&row, of) };
        let (v, start) = (speed([&q.va, &q.vb]), speed(start));
        let felt = AxisState { k: give[i], x: state.x[i], v, start };
        let (drive, friction) =
            (load(simd, &block.lock_or_drive[i]), load(simd, &block.friction[i]));
        let old = [drive, friction, load(simd, &block.limit[i])];
        let new = act(simd, block, i, old, felt, sweep);
        new[0].store_array(&mut block.lock_or_drive[i]);
        new[1].store_array(&mut block.friction[i]);
        new[2].store_array(&mut block.limit[i]);
        let d = (new[0] - old[0]) + (new[1] - old[1]) + (new[2] - old[2]);
        if i < 3 {
            q.push_along(&row, d);
            locked_axes.answer::<true>(q, d, &back[i], &mut given);
        } else {
            q.push_about(&row, d);
            locked_axes.answer::<false>(q, d, &back[i], &mut given);
        }
    }
    for i in 0..6 {
        // The impulses of drives are stored already.
        let lock = load(simd, &block.lock_or_drive[i]) + given[i] * locked[i];
        lock.store_array(&mut block.lock_or_drive[i]);
    }
}
