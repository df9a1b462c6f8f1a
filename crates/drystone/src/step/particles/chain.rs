//! The chain kernel: solves all links of a chain of rods or threads at once, eight chains in
//! parallel lanes.
//!
//! Symbols: w = 1/m; n of a link, λ and h as with single links. For the links of a chain, with the
//! velocities v of its particles at the substep's end,
//!
//! ```text
//! n_i · (v_{i+1} − v_i) + β C_i = −γ_i λ_i,     m_i Δv_i = n_{i−1} λ_{i−1} − n_i λ_i
//! ```
//!
//! is a tridiagonal system for the changes of λ. It needs two additions. *Threads only pull*: links
//! whose λ would push are deactivated, deactivated links that would be too long are activated, and
//! the system is solved again, several times. Any remaining push is cut off, and the next pass
//! continues from there. *Directions*: the existing impulses turn with the links. A taut chain of
//! light particles under a heavy load is so stiff across itself that turning them to the present
//! directions overshoots. So a separate system, implicit in the stiffness tension over length,
//! predicts the directions of the links [Tournier15].
//!
//! The particle at an end may be held by a body: it then responds to an impulse p with w p − B p,
//! where B accounts for the combined pair.

use fearless_simd::{Simd, SimdBase, f32x4};

use super::links::direction;
use super::pace::Pace;
use crate::base::math::{Vec3, vec3};
use crate::base::simd::wide::{
    LANES, Vec3w, Wide, above, bits, gather4, load, max, min, scatter4, select, splat, sqrt,
};
use crate::base::sym3::Sym3;
use crate::base::threads::disjoint::{ReadRows, Rows};
use crate::state::chains::{ChainBlock, ChainRow};
use crate::state::particles::{LinkColor, ParticleState};
use crate::step::solver_body::read_lanes;

/// Maximum number of times that a pass updates the set of slack threads.
const MAX_ROUNDS: usize = 4;

/// Compliance of a link, as a part of the inverse masses at its ends. It makes over-determined
/// systems solvable, such as a straight chain between two pins. Under a thousand times the mass of
/// a particle a link is longer by 20 µm with the substeps of a sixtieth of a second.
pub(super) const GIVE: f32 = 1.0e-4;

/// Minimum pivot, as a part of the diagonal.
const PIVOT: f32 = 1.0e-5;

/// Minimum inverse mass of a link's ends, as a part of that of their particles. A link below it is
/// held at both ends, and no impulse can change it.
const NOTHING: f32 = 1.0e-6;

/// Reduction of the response of a held end: B in the module doc. Zero where no body holds.
pub(crate) type Ends = [Sym3; 2];

/// Copies the chain's links from the blocks; their lanes are idle in this step.
pub(crate) fn begin(block: &mut ChainBlock, colors: &mut [LinkColor]) {
    for (row, spots) in block.rows.iter_mut().zip(&block.spots) {
        for (lane, spot) in spots.iter().enumerate() {
            let Some(spot) = spot else { continue };
            let from = &mut colors[spot.color as usize].blocks[spot.block as usize];
            let l = usize::from(spot.lane);
            let sign = if spot.turned { -1.0 } else { 1.0 };
            let live = from.mass[l] > 0.0;
            row.live[lane] = if live { 1.0 } else { 0.0 };
            row.length[lane] = from.length[l];
            row.slack[lane] = from.slack[l];
            row.impulse[lane] = if live { from.impulse[l] } else { 0.0 };
            for k in 0..3 {
                row.gap[k][lane] = sign * from.gap[k][l];
                row.n[k][lane] = sign * from.n[k][l];
            }
            (from.mass[l], from.gain[l], from.rate[l]) = (0.0, 0.0, 0.0);
            (from.leak[l], from.rigid[l]) = (0.0, 0.0);
            if live {
                from.impulse[l] = 0.0;
            }
        }
    }
}

/// Copies impulses back to the blocks.
pub(crate) fn end(block: &ChainBlock, colors: &mut [LinkColor]) {
    for (row, spots) in block.rows.iter().zip(&block.spots) {
        for (lane, spot) in spots.iter().enumerate() {
            if let Some(spot) = spot
                && row.live[lane] > 0.0
            {
                let to = &mut colors[spot.color as usize].blocks[spot.block as usize];
                to.impulse[usize::from(spot.lane)] = row.impulse[lane];
            }
        }
    }
}

/// Solves the chains once, with bias. Returns the impulses on the first and the last particle of
/// the first chain.
#[inline(always)]
pub(crate) fn solve<S: Simd>(
    simd: S,
    rows: &mut [ChainRow],
    ends: Option<&Ends>,
    states: &Rows<'_, ParticleState>,
    pace: &Pace,
    first: bool,
) -> [Vec3; 2] {
    let (zero, h) = (splat(simd, 0.0), splat(simd, pace.h));
    let keep = splat(simd, if first { pace.keep } else { 1.0 });
    read(simd, rows, states);
    for i in 1..rows.len() {
        let (a, b) = pair(rows, i);
        let old = load(simd, &a.impulse) * keep;
        old.store_array(&mut a.impulse);
        let now = Vec3w::load(simd, &a.work.now);
        let u = Vec3w::load(simd, &b.work.v) - Vec3w::load(simd, &a.work.v);
        let last = Vec3w::load(simd, &a.n);
        let (length, n) = direction(simd, now + u * h, last);
        ((n - last) * old).store(&mut a.work.turn);
        // Tension over length, per substep; only tension holds a chain straight.
        let across = h * max(-old, zero) / max(length, splat(simd, 1.0e-9));
        across.store_array(&mut a.work.beside);
    }
    foresee(simd, rows, ends);
    for i in 1..rows.len() {
        let (a, b) = pair(rows, i);
        let (now, last) = (Vec3w::load(simd, &a.work.now), Vec3w::load(simd, &a.n));
        let u = Vec3w::load(simd, &b.work.v) - Vec3w::load(simd, &a.work.v);
        let bend = Vec3w::load(simd, &b.work.bend) - Vec3w::load(simd, &a.work.bend);
        let (_, n) = direction(simd, now + (u + bend) * h, last);
        ((n - last) * load(simd, &a.impulse)).store(&mut a.work.turn);
        n.store(&mut a.n);
        n.store(&mut a.work.along);
    }
    let turned = push(simd, rows, ends);
    for i in 1..rows.len() {
        let (a, b) = pair(rows, i);
        let (now, n) = (Vec3w::load(simd, &a.work.now), Vec3w::load(simd, &a.n));
        let u = Vec3w::load(simd, &b.work.v) - Vec3w::load(simd, &a.work.v);
        let length = sqrt(now.dot(now));
        let inv_h = splat(simd, pace.inv_h);
        let vn = (n.dot(now + u * h) - length) * inv_h;
        let error = length - load(simd, &a.length);
        // A slack thread may lengthen until it is taut.
        let open = above(load(simd, &a.slack) * -error, zero);
        let closed = pace.caps.closing_link(simd, splat(simd, pace.chain_rate) * error, error);
        (vn + select(open, inv_h * error, closed)).store_array(&mut a.work.error);
    }
    system(simd, rows, ends);
    pull(simd, rows, pace.chain_give, pace.chain_give);
    let pulled = push(simd, rows, ends);
    write(simd, rows, states);
    [turned[0] + pulled[0], turned[1] + pulled[1]]
}

/// Solves the chains once, without bias.
#[inline(always)]
pub(crate) fn relax<S: Simd>(
    simd: S,
    rows: &mut [ChainRow],
    ends: Option<&Ends>,
    states: &Rows<'_, ParticleState>,
    pace: &Pace,
) -> [Vec3; 2] {
    let (zero, half) = (splat(simd, 0.0), splat(simd, 0.5 * pace.h));
    read(simd, rows, states);
    for i in 1..rows.len() {
        let (a, b) = pair(rows, i);
        let now = Vec3w::load(simd, &a.work.now);
        let u = Vec3w::load(simd, &b.work.v) - Vec3w::load(simd, &a.work.v);
        let (_, n) = direction(simd, now - u * half, Vec3w::load(simd, &a.n));
        let slack = min(sqrt(now.dot(now)) - load(simd, &a.length), zero);
        let can_slack = above(load(simd, &a.slack), zero);
        let slack = select(can_slack, slack * splat(simd, pace.inv_h), zero);
        n.store(&mut a.work.along);
        (n.dot(u) + slack).store_array(&mut a.work.error);
    }
    system(simd, rows, ends);
    pull(simd, rows, GIVE, 0.0);
    let pulled = push(simd, rows, ends);
    write(simd, rows, states);
    pulled
}

/// A row and the next one, both mutable.
#[inline(always)]
fn pair(rows: &mut [ChainRow], i: usize) -> (&mut ChainRow, &mut ChainRow) {
    let (a, b) = rows.split_at_mut(i);
    (&mut a[i - 1], &mut b[0])
}

/// Reads velocities, and vectors from particle to particle.
#[inline(always)]
fn read<S: Simd>(simd: S, rows: &mut [ChainRow], states: &ReadRows<'_, ParticleState>) {
    let mut before = Vec3w::zero(simd);
    for i in 0..rows.len() {
        let of = read_lanes(states, &rows[i].solver_row);
        let (mut v, mut x) = ([&of[0].v; LANES], [&of[0].x; LANES]);
        for lane in 1..LANES {
            (v[lane], x[lane]) = (&of[lane].v, &of[lane].x);
        }
        let [vx, vy, vz, w] = gather4(simd, v);
        let [x, y, z, _] = gather4(simd, x);
        let displacement = Vec3w { x, y, z };
        Vec3w { x: vx, y: vy, z: vz }.store(&mut rows[i].work.v);
        w.store_array(&mut rows[i].work.w);
        if i > 0 {
            let gap = Vec3w::load(simd, &rows[i - 1].gap);
            (gap + displacement - before).store(&mut rows[i - 1].work.now);
        }
        before = displacement;
    }
}

/// Writes velocities back. Line 0 is shared by all, and is never written.
#[inline(always)]
fn write<S: Simd>(simd: S, rows: &[ChainRow], states: &Rows<'_, ParticleState>) {
    for row in rows {
        let v = Vec3w::load(simd, &row.work.v);
        let v: [f32x4<S>; LANES] = scatter4([v.x, v.y, v.z, load(simd, &row.work.w)]);
        for lane in 0..LANES {
            if row.solver_row[lane] != 0 {
                v[lane].store_array(&mut states.row(row.solver_row[lane] as usize).v);
            }
        }
    }
}

/// Response of the particle of row `i` of `n` to the impulse `p`.
#[inline(always)]
fn answer<S: Simd>(
    simd: S,
    ends: Option<&Ends>,
    (i, n): (usize, usize),
    w: Wide<S>,
    p: Vec3w<S>,
) -> Vec3w<S> {
    let free = p * w;
    let Some(ends) = ends else { return free };
    let less = if i == 0 {
        &ends[0]
    } else if i + 1 == n {
        &ends[1]
    } else {
        return free;
    };
    free - Vec3w {
        x: Vec3w::splat(simd, vec3(less.xx, less.xy, less.xz)).dot(p),
        y: Vec3w::splat(simd, vec3(less.xy, less.yy, less.yz)).dot(p),
        z: Vec3w::splat(simd, vec3(less.xz, less.yz, less.zz)).dot(p),
    }
}

/// Applies the impulses `turn` of the links to the particles, and returns those on the first and on
/// the last.
#[inline(always)]
fn push<S: Simd>(simd: S, rows: &mut [ChainRow], ends: Option<&Ends>) -> [Vec3; 2] {
    let n = rows.len();
    let mut before = Vec3w::zero(simd);
    let mut out = [Vec3::ZERO; 2];
    for i in 0..n {
        let own = if i + 1 < n { Vec3w::load(simd, &rows[i].work.turn) } else { Vec3w::zero(simd) };
        let p = before - own;
        let w = load(simd, &rows[i].work.w);
        let v = Vec3w::load(simd, &rows[i].work.v) + answer(simd, ends, (i, n), w, p);
        v.store(&mut rows[i].work.v);
        if ends.is_some() && (i == 0 || i + 1 == n) {
            let mut lanes = [[0.0; LANES]; 3];
            p.store(&mut lanes);
            out[usize::from(i > 0)] = vec3(lanes[0][0], lanes[1][0], lanes[2][0]);
        }
        before = own;
    }
    out
}

/// Predicts the change of velocities by turning, implicit in the stiffness across the links (in
/// `beside`, with a mass for each particle): `bend`.
#[inline(always)]
fn foresee<S: Simd>(simd: S, rows: &mut [ChainRow], ends: Option<&Ends>) {
    let (n, zero, one) = (rows.len(), splat(simd, 0.0), splat(simd, 1.0));
    let (mut stiff, mut turn) = (zero, Vec3w::zero(simd));
    let (mut up, mut bend) = (zero, Vec3w::zero(simd));
    for i in 0..n {
        let mut w = load(simd, &rows[i].work.w);
        if let Some(ends) = ends
            && (i == 0 || i + 1 == n)
        {
            let less = &ends[usize::from(i > 0)];
            let third = (less.xx + less.yy + less.zz) * (1.0 / 3.0);
            w = max(w - splat(simd, third), zero);
        }
        let last = i + 1 == n;
        let next = if last { zero } else { load(simd, &rows[i].work.beside) };
        let own = if last { Vec3w::zero(simd) } else { Vec3w::load(simd, &rows[i].work.turn) };
        let back = w * stiff;
        let pivot = one / (one + back + w * next - back * up);
        bend = ((turn - own) * w + bend * back) * pivot;
        up = w * next * pivot;
        bend.store(&mut rows[i].work.bend);
        up.store_array(&mut rows[i].work.up);
        (stiff, turn) = (next, own);
    }
    for i in (1..n).rev() {
        let (a, b) = pair(rows, i);
        let after = Vec3w::load(simd, &b.work.bend) * load(simd, &a.work.up);
        (Vec3w::load(simd, &a.work.bend) + after).store(&mut a.work.bend);
    }
}

/// Builds the matrix: the effect of impulses along the links on the velocities along them.
#[inline(always)]
fn system<S: Simd>(simd: S, rows: &mut [ChainRow], ends: Option<&Ends>) {
    let (size, zero) = (rows.len(), splat(simd, 0.0));
    let mut before = Vec3w::zero(simd);
    for i in 0..size {
        let w = load(simd, &rows[i].work.w);
        let last = i + 1 == size;
        // Response of the particle to its preceding link: on the diagonal of that link, and beside
        // it.
        if i > 0 {
            let answered = answer(simd, ends, (i, size), w, before);
            let k = load(simd, &rows[i - 1].work.k) + before.dot(answered);
            k.store_array(&mut rows[i - 1].work.k);
            let minimum = (w + load(simd, &rows[i - 1].work.w)) * splat(simd, NOTHING);
            let live = select(above(k, minimum), load(simd, &rows[i - 1].live), zero);
            live.store_array(&mut rows[i - 1].live);
            let next =
                if last { zero } else { Vec3w::load(simd, &rows[i].work.along).dot(answered) };
            (-next).store_array(&mut rows[i - 1].work.beside);
        }
        if !last {
            let n = Vec3w::load(simd, &rows[i].work.along);
            n.dot(answer(simd, ends, (i, size), w, n)).store_array(&mut rows[i].work.k);
            before = n;
        }
    }
}

/// Solves the system: updates the impulses, and stores their changes, along the links, in `turn`.
/// `give`: compliance of the links, as a part of the diagonal; `leak`: released part of the
/// existing impulses, on the same scale.
#[inline(always)]
fn pull<S: Simd>(simd: S, rows: &mut [ChainRow], give: f32, leak: f32) {
    let (n, zero, one) = (rows.len() - 1, splat(simd, 0.0), splat(simd, 1.0));
    for row in &mut rows[..n] {
        let taut = above(max(load(simd, &row.work.error), -load(simd, &row.impulse)), zero);
        let can_slack = above(load(simd, &row.slack), zero);
        let active = select(can_slack, select(taut, one, zero), one);
        (active * load(simd, &row.live)).store_array(&mut row.work.active);
    }
    for round in 0..MAX_ROUNDS {
        eliminate(simd, rows, give, leak);
        if round + 1 == MAX_ROUNDS || !reconsider(simd, rows) {
            break;
        }
    }
    for row in &mut rows[..n] {
        let old = load(simd, &row.impulse);
        let new = old + load(simd, &row.work.change);
        let can_slack = above(load(simd, &row.slack), zero);
        let new = select(can_slack, min(new, zero), new);
        new.store_array(&mut row.impulse);
        (Vec3w::load(simd, &row.work.along) * (new - old)).store(&mut row.work.turn);
    }
}

/// Gaussian elimination of a tridiagonal matrix. A slack link's row sets its impulse to zero.
#[inline(always)]
fn eliminate<S: Simd>(simd: S, rows: &mut [ChainRow], give: f32, leak: f32) {
    let (n, zero, one) = (rows.len() - 1, splat(simd, 0.0), splat(simd, 1.0));
    let (give, leak) = (splat(simd, give), splat(simd, leak));
    let (mut beside, mut up, mut change) = (zero, zero, zero);
    for row in &mut rows[..n] {
        let active = above(load(simd, &row.work.active), zero);
        let (k, old) = (load(simd, &row.work.k), load(simd, &row.impulse));
        let next = load(simd, &row.work.beside);
        let diagonal = select(active, k + k * give, one);
        let (lower, upper) = (select(active, beside, zero), select(active, next, zero));
        let wanted = select(active, -load(simd, &row.work.error) - leak * k * old, -old);
        let pivot = one / max(diagonal - lower * up, diagonal * splat(simd, PIVOT));
        up = upper * pivot;
        change = (wanted - lower * change) * pivot;
        up.store_array(&mut row.work.up);
        change.store_array(&mut row.work.change);
        beside = next;
    }
    let mut after = zero;
    for row in rows[..n].iter_mut().rev() {
        after = load(simd, &row.work.change) - load(simd, &row.work.up) * after;
        after.store_array(&mut row.work.change);
    }
}

/// Deactivates links that push, and activates links that would be too long; false if there was
/// neither.
#[inline(always)]
fn reconsider<S: Simd>(simd: S, rows: &mut [ChainRow]) -> bool {
    let (n, zero, one) = (rows.len() - 1, splat(simd, 0.0), splat(simd, 1.0));
    let mut changed = 0;
    let (mut beside, mut before) = (zero, zero);
    for i in 0..n {
        let after = if i + 1 < n { load(simd, &rows[i + 1].work.change) } else { zero };
        let row = &mut rows[i];
        let (active, change) = (load(simd, &row.work.active), load(simd, &row.work.change));
        let next = load(simd, &row.work.beside);
        let left = load(simd, &row.work.error)
            + load(simd, &row.work.k) * change
            + beside * before
            + next * after;
        let new = load(simd, &row.impulse) + change;
        let is_active = above(active, zero);
        let can = load(simd, &row.slack) * load(simd, &row.live);
        // The sign of an error: a push where the link is active, an excess length where it is not.
        let wrong = above(select(is_active, new, left) * can, zero);
        changed |= bits(wrong);
        select(wrong, one - active, active).store_array(&mut row.work.active);
        (beside, before) = (next, change);
    }
    changed != 0
}
