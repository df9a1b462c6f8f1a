//! The link kernels: solve eight links at a time.
//!
//! Symbols: w = 1/m; n the unit vector from A to B; λ the impulse along n on B, in one substep.
//! As with joints, the particles carry the impulses of the last substep, along the directions that
//! the links had. A sweep first turns them to the present directions, `(n - n_last) λ`, then
//! solves. A relax sweep turns nothing, and takes its directions in the middle of the substep's
//! motion (docs/decisions/016-joint-energy.md).

use fearless_simd::{Simd, SimdBase, f32x4};

use super::pace::{Form, Pace};
use crate::base::simd::wide::{
    LANES, Vec3w, Wide, above, gather4, load, max, min, scatter4, select, splat, sqrt,
};
use crate::base::threads::disjoint::{ReadRows, Rows};
use crate::state::particles::{LaneKind, LinkBlock, ParticleState};
use crate::step::context::softness::Softness;
use crate::step::solver_body::read_lanes;

/// Velocities, displacements and inverse masses of a block's particles.
struct Ends<S: Simd> {
    va: Vec3w<S>,
    vb: Vec3w<S>,
    xa: Vec3w<S>,
    xb: Vec3w<S>,
    wa: Wide<S>,
    wb: Wide<S>,
    /// 1 where the particle moves.
    ma: Wide<S>,
    mb: Wide<S>,
}

#[inline(always)]
fn read<S: Simd>(simd: S, states: &ReadRows<'_, ParticleState>, block: &LinkBlock) -> Ends<S> {
    let (a, b) = (read_lanes(states, &block.row_a), read_lanes(states, &block.row_b));
    let (mut v, mut x) = ([&a[0].v; LANES], [&a[0].x; LANES]);
    let (mut u, mut y) = ([&b[0].v; LANES], [&b[0].x; LANES]);
    for lane in 1..LANES {
        (v[lane], x[lane], u[lane], y[lane]) = (&a[lane].v, &a[lane].x, &b[lane].v, &b[lane].x);
    }
    let [vax, vay, vaz, wa] = gather4(simd, v);
    let [vbx, vby, vbz, wb] = gather4(simd, u);
    let [xax, xay, xaz, ma] = gather4(simd, x);
    let [xbx, xby, xbz, mb] = gather4(simd, y);
    Ends {
        va: Vec3w { x: vax, y: vay, z: vaz },
        vb: Vec3w { x: vbx, y: vby, z: vbz },
        xa: Vec3w { x: xax, y: xay, z: xaz },
        xb: Vec3w { x: xbx, y: xby, z: xbz },
        wa,
        wb,
        ma,
        mb,
    }
}

/// Writes velocities (with the inverse mass) or displacements back. Line 0 is shared by all, and is
/// never written.
#[inline(always)]
pub(super) fn write_ends<S: Simd>(
    states: &Rows<'_, ParticleState>,
    rows: &[u32; LANES],
    vectors: Vec3w<S>,
    beside: Wide<S>,
    are_ways: bool,
) {
    let all: [f32x4<S>; LANES] = scatter4([vectors.x, vectors.y, vectors.z, beside]);
    for i in 0..LANES {
        if rows[i] != 0 {
            let state = states.row(rows[i] as usize);
            all[i].store_array(if are_ways { &mut state.x } else { &mut state.v });
        }
    }
}

#[inline(always)]
fn write_velocities<S: Simd>(
    states: &Rows<'_, ParticleState>,
    rows: &[u32; LANES],
    v: Vec3w<S>,
    w: Wide<S>,
) {
    write_ends(states, rows, v, w, false);
}

/// Length of `d`, and its unit vector; `n` if the length is 0.
#[inline(always)]
pub(super) fn direction<S: Simd>(simd: S, d: Vec3w<S>, n: Vec3w<S>) -> (Wide<S>, Vec3w<S>) {
    let length = sqrt(d.dot(d));
    let apart = above(length, splat(simd, 1.0e-9));
    let unit = d * (splat(simd, 1.0) / length);
    (length, Vec3w::select(apart, unit, n))
}

/// Computes a block's constants for this step, and applies its stored impulses to the particles.
#[inline(always)]
pub(crate) fn prepare<S: Simd>(
    simd: S,
    block: &mut LinkBlock,
    places: &[[f32; 4]],
    states: &Rows<'_, ParticleState>,
    pace: &Pace,
) {
    for lane in 0..LANES {
        let (a, b) = (block.row_a[lane] as usize, block.row_b[lane] as usize);
        for i in 0..3 {
            block.gap[i][lane] = places[b][i] - places[a][i];
        }
    }
    let q = read(simd, states, block);
    let old = Vec3w::load(simd, &block.n);
    let (_, n) = direction(simd, Vec3w::load(simd, &block.gap), old);
    n.store(&mut block.n);
    let k = q.wa + q.wb;
    let zero = splat(simd, 0.0);
    let moves = above(q.ma + q.mb, zero);
    let mass = select(moves, select(above(k, zero), splat(simd, 1.0) / k, zero), zero);
    mass.store_array(&mut block.mass);
    for lane in 0..LANES {
        let (mass, kind) = (block.mass[lane], block.kinds[lane]);
        let is_spring = matches!(kind, LaneKind::Rate | LaneKind::Frequency);
        let soft = if pace.form == Form::Soft {
            softness(block, lane, pace)
        } else {
            compliance(block, lane, pace)
        };
        block.rate[lane] = mass * soft.rate;
        block.gain[lane] = mass * soft.mass;
        block.leak[lane] = if mass > 0.0 { soft.impulse } else { 0.0 };
        block.rigid[lane] = if is_spring { 0.0 } else { mass };
        block.slack[lane] = if kind == LaneKind::AtMost { 1.0 } else { 0.0 };
    }
    if pace.impulse_scale <= 0.0 {
        block.impulse = [0.0; LANES];
        return;
    }
    // A link that does not move keeps its impulse until it does.
    let scale = select(moves, splat(simd, pace.impulse_scale), splat(simd, 1.0));
    let impulse = load(simd, &block.impulse) * scale;
    impulse.store_array(&mut block.impulse);
    let p = select(moves, impulse, zero);
    write_velocities(states, &block.row_a, q.va - n * (p * q.wa), q.wa);
    write_velocities(states, &block.row_b, q.vb + n * (p * q.wb), q.wb);
}

/// A spring without stiffness: it releases all of its impulse.
const LIMP: Softness = Softness { rate: 0.0, mass: 0.0, impulse: 1.0 };

fn softness(block: &LinkBlock, lane: usize, pace: &Pace) -> Softness {
    let (stiffness, damping) = (block.stiffness[lane], block.damping[lane]);
    match block.kinds[lane] {
        LaneKind::Equal | LaneKind::AtMost => pace.softness,
        LaneKind::Frequency if stiffness > 0.0 => Softness::new(stiffness, damping, pace.h),
        LaneKind::Rate => by_rate(stiffness, damping, block.mass[lane], pace.h),
        LaneKind::Idle | LaneKind::Frequency => LIMP,
    }
}

/// A spring of `k` [N/m] and `c` [N s/m] as [`Softness`]. With s = h² k + h c, the impulse is that
/// of the force at the substep's end.
fn by_rate(k: f32, c: f32, mass: f32, h: f32) -> Softness {
    let s = h * (h * k + c);
    if !(s > 0.0 && mass > 0.0) {
        return LIMP;
    }
    let gain = s / (mass + s);
    Softness { rate: h * k / s * gain, mass: gain, impulse: mass / (mass + s) }
}

/// Softness for the projecting forms. Rods and threads remove all of the error. Springs, without
/// their damping, leave the part that follows from a compliance 1/(k h²).
fn compliance(block: &LinkBlock, lane: usize, pace: &Pace) -> Softness {
    let mass = block.mass[lane];
    let stiffness = match block.kinds[lane] {
        LaneKind::Idle => 0.0,
        LaneKind::Equal | LaneKind::AtMost => return Softness::RIGID,
        LaneKind::Rate => block.stiffness[lane],
        LaneKind::Frequency => {
            let omega = 2.0 * core::f32::consts::PI * block.stiffness[lane];
            omega * omega * mass
        }
    };
    let s = stiffness * (pace.h * pace.h);
    if !(s > 0.0 && mass > 0.0) {
        return LIMP;
    }
    Softness { rate: 0.0, mass: s / (mass + s), impulse: mass / (mass + s) }
}

/// Solves one block once, with bias.
#[inline(always)]
pub(crate) fn solve<S: Simd>(
    simd: S,
    block: &mut LinkBlock,
    states: &Rows<'_, ParticleState>,
    pace: &Pace,
    first: bool,
) {
    let mut q = read(simd, states, block);
    let last = Vec3w::load(simd, &block.n);
    let zero = splat(simd, 0.0);
    let now = Vec3w::load(simd, &block.gap) + q.xb - q.xa;
    let length = sqrt(now.dot(now));
    let (_, n) = direction(simd, now + (q.vb - q.va) * splat(simd, pace.h), last);
    let old = load(simd, &block.impulse) * splat(simd, if first { pace.keep } else { 1.0 });
    let turn = (n - last) * old;
    q.va = q.va - turn * q.wa;
    q.vb = q.vb + turn * q.wb;
    let end = now + (q.vb - q.va) * splat(simd, pace.h);
    let vn = (n.dot(end) - length) * splat(simd, pace.inv_h);
    let error = length - load(simd, &block.length);
    let can_slack = above(load(simd, &block.slack), zero);
    let mass = load(simd, &block.mass);
    // Springs apply their full force; rigid links close no faster than the cap.
    let rigid = load(simd, &block.rigid);
    let (bias, gain) = (load(simd, &block.rate) * error, load(simd, &block.gain));
    let leak = load(simd, &block.leak);
    let maximum = rigid * pace.caps.fastest_link(simd, error);
    let bias = select(above(rigid, zero), max(min(bias, maximum), -maximum), bias);
    // A slack thread may lengthen until it is taut.
    let is_slack = above(min(load(simd, &block.slack), -error), zero);
    let bias = select(is_slack, mass * splat(simd, pace.inv_h) * error, bias);
    let gain = select(is_slack, mass, gain);
    let leak = select(is_slack, zero, leak);
    let new = old - (gain * vn + bias) - leak * old;
    let new = select(can_slack, min(new, zero), new);
    n.store(&mut block.n);
    new.store_array(&mut block.impulse);
    let d = new - old;
    write_velocities(states, &block.row_a, q.va - n * (d * q.wa), q.wa);
    write_velocities(states, &block.row_b, q.vb + n * (d * q.wb), q.wb);
}

/// Solves one block once, without bias: spring impulses do not change.
#[inline(always)]
pub(crate) fn relax<S: Simd>(
    simd: S,
    block: &mut LinkBlock,
    states: &Rows<'_, ParticleState>,
    pace: &Pace,
) {
    let q = read(simd, states, block);
    let half = splat(simd, 0.5 * pace.h);
    let ahead = Vec3w::load(simd, &block.gap) + q.xb - q.xa;
    let last = Vec3w::load(simd, &block.n);
    let (length, _) = direction(simd, ahead, last);
    let (_, n) = direction(simd, ahead - (q.vb - q.va) * half, last);
    let (zero, vn) = (splat(simd, 0.0), n.dot(q.vb - q.va));
    let old = load(simd, &block.impulse);
    let can_slack = above(load(simd, &block.slack), zero);
    let mass = load(simd, &block.rigid);
    let slack = min(length - load(simd, &block.length), zero) * splat(simd, pace.inv_h);
    let slack = select(can_slack, slack, zero);
    let new = old - mass * (vn + slack);
    let new = select(can_slack, min(new, zero), new);
    new.store_array(&mut block.impulse);
    let d = new - old;
    write_velocities(states, &block.row_a, q.va - n * (d * q.wa), q.wa);
    write_velocities(states, &block.row_b, q.vb + n * (d * q.wb), q.wb);
}

/// Solves one block so that lengths are right at the substep's end: bias 1/h, impulses of this
/// substep alone, at the positions that the velocities lead to. `first`: the substep's first sweep.
#[inline(always)]
pub(crate) fn aim<S: Simd>(
    simd: S,
    block: &mut LinkBlock,
    states: &Rows<'_, ParticleState>,
    pace: &Pace,
    first: bool,
) {
    let q = read(simd, states, block);
    let h = splat(simd, pace.h);
    let end = Vec3w::load(simd, &block.gap) + (q.xb + q.vb * h) - (q.xa + q.va * h);
    let (length, n) = direction(simd, end, Vec3w::load(simd, &block.n));
    let d = correction(simd, block, length, pace, first);
    n.store(&mut block.n);
    write_velocities(states, &block.row_a, q.va - n * (d * q.wa), q.wa);
    write_velocities(states, &block.row_b, q.vb + n * (d * q.wb), q.wb);
}

/// [`aim`] on positions: Jakobsen's projection [Jakobsen01].
#[inline(always)]
pub(crate) fn project<S: Simd>(
    simd: S,
    block: &mut LinkBlock,
    states: &Rows<'_, ParticleState>,
    pace: &Pace,
    first: bool,
) {
    let q = read(simd, states, block);
    let end = Vec3w::load(simd, &block.gap) + q.xb - q.xa;
    let (length, n) = direction(simd, end, Vec3w::load(simd, &block.n));
    let d = correction(simd, block, length, pace, first) * splat(simd, pace.h);
    n.store(&mut block.n);
    write_ends(states, &block.row_a, q.xa - n * (d * q.wa), q.ma, true);
    write_ends(states, &block.row_b, q.xb + n * (d * q.wb), q.mb, true);
}

/// The impulse that removes the error at the substep's end. A spring leaves a part of the error,
/// which follows from its whole impulse in this substep [Macklin16].
#[inline(always)]
fn correction<S: Simd>(
    simd: S,
    block: &mut LinkBlock,
    length: Wide<S>,
    pace: &Pace,
    first: bool,
) -> Wide<S> {
    let zero = splat(simd, 0.0);
    let old = if first { zero } else { load(simd, &block.impulse) };
    let gap = length - load(simd, &block.length);
    let speed = gap * splat(simd, pace.inv_h);
    let is_rigid = above(load(simd, &block.rigid), zero);
    let error = select(is_rigid, pace.caps.closing_link(simd, speed, gap), speed);
    let new = old - load(simd, &block.gain) * error - load(simd, &block.leak) * old;
    let can_slack = above(load(simd, &block.slack), zero);
    let new = select(can_slack, min(new, zero), new);
    new.store_array(&mut block.impulse);
    new - old
}
