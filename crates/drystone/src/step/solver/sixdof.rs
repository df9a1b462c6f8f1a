//! The kernel of joints of six axes, eight at a time.
//!
//! Symbols: u are the axes of motion (turned with body A), n those of the turns, λ impulses along u, μ about
//! n; d is anchor B less anchor A. A force along u acts at anchor B on both bodies, so that with d ≠ 0 (a
//! slider) it makes no torque: the arm of A is r_a + d. Angles go on from the step's start by
//! ε = θ_b - θ_a - θ_a × θ_b / 2, the turn of B against A to second order: no trigonometry here.
//!
//! All locked axes come first, at once: their 6 × 6 matrix by blocks, L over the locked motions, C over both,
//! A over the turns; the turns are solved with A - Cᵀ L⁻¹ C. Then drive, friction and limit, one axis after the
//! other. Each is felt through the locked axes: with K the coupling of its row to theirs, its inverse mass
//! is less by Kᵀ M K, M their inverse matrix, and along with its impulse they get -M K of it, which leaves
//! them at rest. So a hinge's limit is that of a body about its anchor, and a slider's spring is one on the
//! whole mass wherever its anchor is. (Without that a sweep takes away only a quarter of the speed of a rod
//! held at its end.) Warm start as of balls: see joint.rs and docs/decisions/016-joint-energy.md.

use fearless_simd::{Simd, SimdBase};

use super::held::{Held, Pair, Row, Turn};
use super::integrate::{Aux, load_start};
use super::joint::{JointSweep, bend};
use super::pinned;
use super::rows::{Line, Velocity, store_velocity};
use super::spring::{Law, Push};
use crate::base::disjoint::Rows;
use crate::base::wide::{
    LANES, Lanes, Sym3w, Vec3w, Wide, above, inverse_or_zero, load, max, min, select, splat,
};

/// Drive, friction and limit of an axis.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Axis {
    pub(crate) drive: Push,
    /// Greatest impulse of the drive; 0: none.
    pub(crate) most: Lanes,
    /// Greatest impulse of friction; 0: none.
    pub(crate) friction: Lanes,
    pub(crate) limit: Push,
    /// 1 where the limit is as hard as the joint.
    pub(crate) hard: Lanes,
    pub(crate) low: Lanes,
    pub(crate) high: Lanes,
    /// Whether some of the eight have any of it: a drive, a limit, a limit that is a spring.
    pub(crate) drives: bool,
    pub(crate) limits: bool,
    pub(crate) yields: bool,
    /// Or anything at all that acts on the axis.
    pub(crate) acts: bool,
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
    /// Direction of the swing at the step's start where there is a cone: along y, and along z.
    pub(crate) swing: [Lanes; 2],
    /// 1 where an axis is locked, and the place where it is.
    pub(crate) locked: [Lanes; 6],
    pub(crate) place: [Lanes; 6],
    /// Impulse of lock or drive, of friction, and of the limit.
    pub(crate) held: [Lanes; 6],
    pub(crate) friction: [Lanes; 6],
    pub(crate) limit: [Lanes; 6],
    /// What the bodies carry of the warm start: linear; the moments on A and B.
    pub(crate) carried: [Lanes; 3],
    pub(crate) carried_a: [Lanes; 3],
    pub(crate) carried_b: [Lanes; 3],
    /// Impulse about B's anchor.
    pub(crate) torque: [Lanes; 3],
    /// Some axis of motion is locked, and some turn.
    pub(crate) holds: [bool; 2],
    /// Something acts on some axis of motion, and on some turn.
    pub(crate) acts: [bool; 2],
    /// Some axis is driven, or has a limit that is a spring: they ask how fast the bodies were when the substep began.
    pub(crate) springs: bool,
    /// A tree solves all there is: see tree_six.rs.
    pub(crate) is_direct: bool,
    /// All motions are locked, and what is to be of the gap is none: see pinned.rs.
    pub(crate) is_pinned: bool,
    pub(crate) axes: [Axis; 6],
}

impl SixBlock {
    /// True if something acts on an axis of one of the joints. (What is known of an axis is not filled in where
    /// nothing acts on any motion, or on any turn.)
    #[inline(always)]
    pub(super) fn acts_on(&self, axis: usize) -> bool {
        self.acts[axis / 3] && self.axes[axis].acts
    }

    /// Impulse of all that acts on an axis.
    #[inline(always)]
    pub(super) fn pushes<S: Simd>(&self, simd: S, axis: usize) -> Wide<S> {
        load(simd, &self.held[axis])
            + load(simd, &self.friction[axis])
            + load(simd, &self.limit[axis])
    }
}

/// What drive, friction and limit feel: inverse mass, coordinate, speed, and the speed when the substep began.
#[derive(Clone, Copy)]
pub(super) struct Felt<S: Simd> {
    pub(super) k: Wide<S>,
    pub(super) x: Wide<S>,
    pub(super) v: Wide<S>,
    pub(super) start: Wide<S>,
}

/// Solves what acts on an axis, whose impulses so far are `old`, drive, friction and limit; returns them anew. In
/// a relax sweep springs do not push: they go by where the bodies were.
#[inline(always)]
pub(super) fn act<S: Simd>(
    simd: S,
    block: &SixBlock,
    axis: usize,
    [old, old_friction, old_limit]: [Wide<S>; 3],
    felt: Felt<S>,
    sweep: &JointSweep,
) -> [Wide<S>; 3] {
    let (zero, inv_h) = (splat(simd, 0.0), splat(simd, sweep.inv_h));
    let hardest = splat(simd, sweep.hardest);
    let is_locked = above(load(simd, &block.locked[axis]), zero);
    let most_back = splat(simd, sweep.caps.push(axis));
    let axis = &block.axes[axis];
    let Felt { k, x, v, start } = felt;
    // What forces, contacts and other joints give in the substep: all but the impulse itself.
    let gained = |v: Wide<S>, own: Wide<S>| v - k * own - start;
    let inverse = inverse_or_zero(simd, k);
    let mut drive = zero;
    if axis.drives {
        let most = load(simd, &axis.most);
        let law = axis.drive.law(simd, k, gained(v, old), [inv_h, hardest]);
        let new = law.impulse(inverse, v, x - load(simd, &axis.drive.place), old);
        drive = max(min(new, most), -most);
        if sweep.is_relax {
            drive = select(above(law.rate, zero), old, drive);
        }
    }
    let drive = select(is_locked, old, drive);
    let v = v + k * (drive - old);

    let most = load(simd, &axis.friction);
    let friction = max(min(old_friction - v * inverse, most), -most);
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
    let bias = max(min(splat(simd, s.rate) * error, most_back), -most_back);
    let hard = Law { gain: splat(simd, s.mass), rate: zero, bias };
    let shut = hard.impulse(inverse, v, error, old);
    let ahead = old - (v + error * inv_h) * inverse;
    let one_way = |new: Wide<S>| select(is_low, max(new, zero), min(new, zero));
    let mut limit = one_way(select(open, ahead, shut));
    if axis.yields {
        let is_hard = above(load(simd, &axis.hard), zero);
        let law = axis.limit.law(simd, k, gained(v, old), [inv_h, hardest]);
        let sprung = law.impulse(inverse, v, error, old);
        // Without room between them, both hold: a spring about one place.
        let tight = above(splat(simd, 1.0e-9), high - low);
        let soft = select(tight, sprung, one_way(select(open, zero, sprung)));
        limit = select(is_hard, limit, if sweep.is_relax { old } else { soft });
    }
    [drive, friction, select(is_locked, zero, limit)]
}

/// The joints of a block as they are in this sweep.
struct State<S: Simd> {
    pair: Pair<S>,
    along: [Row<S>; 3],
    about: [Row<S>; 3],
    /// Coordinates.
    x: [Wide<S>; 6],
    locked: [Wide<S>; 6],
}

/// The bodies of a block's joints at the place of this sweep's rows.
pub(super) struct Placed<S: Simd> {
    pub(super) alpha: Wide<S>,
    pub(super) beta: Wide<S>,
    pub(super) sa: Sym3w<S>,
    pub(super) sb: Sym3w<S>,
    pub(super) va: Velocity<S>,
    pub(super) vb: Velocity<S>,
    /// Their velocities when the substep began; nothing where no spring asks.
    pub(super) start_a: Velocity<S>,
    pub(super) start_b: Velocity<S>,
    /// Angular velocities of kinematic bodies.
    pub(super) spin_a: Vec3w<S>,
    pub(super) spin_b: Vec3w<S>,
    /// How A turned since the step's start, and B against A.
    to_a: Turn<S>,
    turn: Vec3w<S>,
    pub(super) arm_a: Vec3w<S>,
    pub(super) arm_b: Vec3w<S>,
    pub(super) gap: Vec3w<S>,
    /// Velocity of B's anchor less that of A's by kinematic bodies.
    drift: Vec3w<S>,
}

impl<S: Simd> Placed<S> {
    #[inline(always)]
    fn read(
        simd: S,
        block: &SixBlock,
        (lines, aux): (&Rows<'_, Line>, &Rows<'_, Aux>),
        sweep: &JointSweep,
    ) -> Self {
        let (alpha, beta) = (load(simd, &block.alpha), load(simd, &block.beta));
        let (sa, sb) = (Sym3w::load(simd, &block.s_a), Sym3w::load(simd, &block.s_b));
        let (va, xa) = sweep.read(simd, lines, &block.row_a);
        let (vb, xb) = sweep.read(simd, lines, &block.row_b);
        let (mut start_a, mut start_b) = (va, vb);
        if block.springs {
            start_a = load_start(simd, aux, &block.row_a);
            start_b = load_start(simd, aux, &block.row_b);
        }
        let elapsed = splat(simd, sweep.elapsed);
        let (spin_a, spin_b) = (Vec3w::load(simd, &block.spin_a), Vec3w::load(simd, &block.spin_b));
        let turn_a = sa.mul(xa.w) + spin_a * elapsed;
        let turn_b = sb.mul(xb.w) + spin_b * elapsed;
        let (to_a, to_b) = (Turn::new(simd, turn_a), Turn::new(simd, turn_b));
        let (r0a, r0b) = (Vec3w::load(simd, &block.r_a), Vec3w::load(simd, &block.r_b));
        // Shifts by themselves: arms of meters would round away what a gap is.
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

    /// The row of a turn, and its angle.
    #[inline(always)]
    pub(super) fn about(&self, simd: S, block: &SixBlock, i: usize) -> (Row<S>, Wide<S>) {
        let n = Vec3w::load(simd, &block.n[i]);
        let row = Row::about(self.to_a.apply(n), [&self.sa, &self.sb]);
        (row, load(simd, &block.angles[i]) + n.dot(self.turn))
    }

    /// Angular velocities.
    #[inline(always)]
    pub(super) fn spins(&self) -> [Vec3w<S>; 2] {
        [self.sa.mul(self.va.w) + self.spin_a, self.sb.mul(self.vb.w) + self.spin_b]
    }

    /// Velocity of B's anchor less that of A's.
    #[inline(always)]
    pub(super) fn slip(&self) -> Vec3w<S> {
        let (wa, wb) = (self.sa.mul(self.va.w), self.sb.mul(self.vb.w));
        self.vb.v * self.beta - self.va.v * self.alpha + self.drift + wb.cross(self.arm_b)
            - wa.cross(self.arm_a)
    }
}

#[inline(always)]
fn state_of<S: Simd>(simd: S, block: &SixBlock, at: &Placed<S>, sweep: &JointSweep) -> State<S> {
    let u0 = Vec3w::load3(simd, &block.u);
    let (arms, roots) = ([at.arm_a, at.arm_b], [&at.sa, &at.sb]);
    // No loops: what is indexed by one lives in memory, and was copied from there.
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

/// The warm start of a block in the rows of now, and what a sweep gave beside it: linear impulses, and those about
/// anchor B.
pub(super) struct Given<S: Simd> {
    pub(super) old: [Vec3w<S>; 2],
    pub(super) new: [Vec3w<S>; 2],
}

/// Solves one block once.
#[inline(always)]
pub(crate) fn solve<S: Simd>(
    simd: S,
    block: &mut SixBlock,
    (lines, aux): (&Rows<'_, Line>, &Rows<'_, Aux>),
    sweep: &JointSweep,
) {
    let at = Placed::read(simd, block, (lines, aux), sweep);
    let given = match (block.is_pinned, block.holds[1]) {
        (true, true) => pinned::solve::<S, true>(simd, block, &at, sweep),
        (true, false) => pinned::solve::<S, false>(simd, block, &at, sweep),
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
    // All at once: what an addition rounds off a velocity is done again in every substep that follows.
    let a = Velocity { v: at.va.v - force * at.alpha, w: at.va.w - at.sa.mul(more_a) };
    let b = Velocity { v: at.vb.v + force * at.beta, w: at.vb.w + at.sb.mul(more_b) };
    store_velocity(simd, lines, &block.row_a, shown(simd, a, sweep));
    store_velocity(simd, lines, &block.row_b, shown(simd, b, sweep));
}

/// Joints that leave some motion free, or only spring it. `TURNS`: some joint of the block locks a turn.
#[inline(always)]
fn solve_loose<S: Simd, const TURNS: bool>(
    simd: S,
    block: &mut SixBlock,
    at: &Placed<S>,
    sweep: &JointSweep,
) -> Given<S> {
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
    Given { old: [p, t], new: [state.pair.force, state.pair.torque] }
}

/// A velocity without what is so small that it never shows. Where all axes hold, by friction for one, every visit
/// leaves but 1e-7 of a speed, which would end as a subnormal number, and turns with it: those take a processor
/// up to a hundred times as long.
#[inline(always)]
fn shown<S: Simd>(simd: S, velocity: Velocity<S>, sweep: &JointSweep) -> Velocity<S> {
    let (zero, least) = (splat(simd, 0.0), splat(simd, sweep.caps.least));
    let part = |x: Wide<S>| select(above(least, max(x, -x)), zero, x);
    let Velocity { v, w } = velocity;
    Velocity {
        v: Vec3w { x: part(v.x), y: part(v.y), z: part(v.z) },
        w: Vec3w { x: part(w.x), y: part(w.y), z: part(w.z) },
    }
}

impl<S: Simd> State<S> {
    /// The row of an axis where it is not locked. `TURNS`: some joint of the block locks a turn.
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

/// The locked axes, then drives and limits behind them. `TURNS`: some joint of the block locks a turn.
#[inline(always)]
fn solve_axes<S: Simd, const TURNS: bool>(
    simd: S,
    block: &mut SixBlock,
    (state, start): (&mut State<S>, [&Velocity<S>; 2]),
    sweep: &JointSweep,
) {
    let zero = splat(simd, 0.0);
    let linear = state.pair.alpha * state.pair.alpha + state.pair.beta * state.pair.beta;
    let locked = state.locked;
    let mut held = Held::<S, TURNS>::of(simd, &state.along, &state.about, &locked, block.holds[0]);
    held.invert(simd, &locked, linear);
    // Of each drive and limit its inverse mass, and how the locked axes answer it.
    let none = Vec3w::zero(simd);
    let (mut give, mut back) = ([zero; 6], [[none; 2]; 6]);
    let mut loads = [zero; 6];
    for i in 0..6 {
        loads[i] = load(simd, &block.held[i]);
    }
    for i in 0..6 {
        if !block.acts_on(i) {
            continue;
        }
        let row = state.free_row::<TURNS>(simd, i);
        let k;
        (k, back[i]) = held.behind(&row);
        // What is left of a turn that the locked axes allow not at all is rounding.
        let least = row.coupling(&row) * splat(simd, 1.0e-5);
        give[i] = if i < 3 { max(linear + k, linear) } else { select(above(k, least), k, zero) };
        let pushes = block.pushes(simd, i);
        let [a, b] = [back[i][0] * pushes, back[i][1] * pushes];
        let parts = [a.x, a.y, a.z, b.x, b.y, b.z];
        for j in 0..6 {
            if block.holds[j / 3] {
                loads[j] += parts[j];
            }
        }
    }
    let mut given = held.solve(simd, block, &mut state.pair, &state.x, &loads, sweep);
    for i in 0..6 {
        if !block.acts_on(i) {
            continue;
        }
        let row = state.free_row::<TURNS>(simd, i);
        let q = &mut state.pair;
        let speed = |of| if i < 3 { q.speed_along(&row, of) } else { q.speed_about(&row, of) };
        let (v, start) = (speed([&q.va, &q.vb]), speed(start));
        let felt = Felt { k: give[i], x: state.x[i], v, start };
        let (drive, friction) = (load(simd, &block.held[i]), load(simd, &block.friction[i]));
        let old = [drive, friction, load(simd, &block.limit[i])];
        let new = act(simd, block, i, old, felt, sweep);
        new[0].store_array(&mut block.held[i]);
        new[1].store_array(&mut block.friction[i]);
        new[2].store_array(&mut block.limit[i]);
        let d = (new[0] - old[0]) + (new[1] - old[1]) + (new[2] - old[2]);
        if i < 3 {
            q.push_along(&row, d);
            held.answer::<true>(q, d, &back[i], &mut given);
        } else {
            q.push_about(&row, d);
            held.answer::<false>(q, d, &back[i], &mut given);
        }
    }
    for i in 0..6 {
        // Those of a drive are stored already.
        let lock = load(simd, &block.held[i]) + given[i] * locked[i];
        lock.store_array(&mut block.held[i]);
    }
}
