//! Overlap correction: at the step's end, bodies are displaced out of overlaps that no load
//! explains, and keep their velocities.
//!
//! A contact yields under its load, so a depth of `load × give` is equilibrium. A greater depth is
//! an error, from the initial placement or from an impact. A push-out by velocity leaves the body
//! with that velocity, and the pushes of several contacts add up: twenty boxes in one place flew
//! apart at 68 m/s.
//!
//! So a contact that is deeper by [`StepContext::deep`] is *parting* until the excess is gone.
//! Sweeps stop its approach and push nothing out (`contact/kernel.rs`). This pass moves the bodies
//! by pseudo-velocities that are then discarded [Guendelman03]. All contacts around take part;
//! otherwise bodies would be pressed into their neighbors.
//!
//! Reads: blocks, solver bodies. Writes: solver bodies (motion), blocks (which contacts still
//! part). Runs: over groups with a parting contact, and over the blocks of one color after another.
//! Bodies on joints or in ropes are left to the sweeps, because joints and ropes do not see this
//! displacement.
//!
//! References: docs/decisions/037-parting.md.

use fearless_simd::{Simd, SimdBase, dispatch};

use super::block::{ContactBlock, Extra, K};
use super::parting::{Parting, give, is_free, lanes};
use super::sweep::DEEP_RATE;
use crate::base::simd::wide::{
    LANES, Lanes, Vec3w, Wide, above, bits, load, max, min, select, splat,
};
use crate::base::threads::disjoint::{ReadRows, Rows};
use crate::base::threads::jobs::{Jobs, for_shares};
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::group::Group;
use crate::step::solver_body::{
    SolverBody, Velocity, load_motion, load_velocity, store_velocity, three,
};

/// Sweeps of the pass: as many as a step has.
const SWEEPS: u32 = 8;

impl Solver<'_> {
    /// Corrects the overlaps in a group that exceed what its loads explain.
    pub(crate) fn part(&self, group: &Group, locked: bool, jobs: &Jobs<'_>) {
        let blocks = self.plan.contacts.blocks_of(&group.contacts);
        if !self.contact.parts || !blocks.clone().any(|i| self.contact.blocks.read(i).parting != 0)
        {
            return;
        }
        for i in blocks {
            self.contact.partings.row(i).is_ready = false;
        }
        for i in group.solver_rows.clone() {
            *self.contact.pseudo_velocities.row(i) = SolverBody::default();
        }
        for _ in 0..SWEEPS {
            self.plan.contacts.for_blocks(&group.contacts, jobs, 8, |batch, blocks| {
                dispatch!(self.ctx.level, simd => {
                    for i in blocks {
                        if batch.fixed {
                            self.part_block::<_, true>(simd, i);
                        } else {
                            self.part_block::<_, false>(simd, i);
                        }
                    }
                });
            });
            if locked {
                for i in group.solver_rows.clone() {
                    self.body.aux.read(i).hold_locked(self.contact.pseudo_velocities.row(i));
                }
            }
        }
        for_shares(jobs, group.solver_rows.len(), 64, |part| {
            for i in group.solver_rows.start + part.start..group.solver_rows.start + part.end {
                self.move_apart(i);
            }
        });
    }

    #[inline(always)]
    fn part_block<S: Simd, const FIXED: bool>(&self, simd: S, i: usize) {
        let (block, parting) = (self.contact.blocks.row(i), self.contact.partings.row(i));
        if block.parting == 0 && !self.is_stirred(block) {
            return;
        }
        if !parting.is_ready {
            let extra =
                if self.contact.has_extras { Some(self.contact.extras.read(i)) } else { None };
            self.begin_parting::<S, FIXED>(simd, block, extra, parting);
        }
        match block.count {
            1 => sweep::<S, FIXED, 1>(simd, block, parting, &self.contact.pseudo_velocities),
            2 => sweep::<S, FIXED, 2>(simd, block, parting, &self.contact.pseudo_velocities),
            _ => sweep::<S, FIXED, 4>(simd, block, parting, &self.contact.pseudo_velocities),
        }
    }

    /// True if the pass moves a body of the block.
    fn is_stirred(&self, block: &ContactBlock) -> bool {
        block.row_a.iter().chain(&block.row_b).any(|row| {
            let displacement = self.contact.pseudo_velocities.read(*row as usize);
            displacement.v.iter().chain(&displacement.w).any(|x| *x != 0.0)
        })
    }

    /// Computes the target speed of each point of a block, and which of its contacts continue to
    /// part.
    #[inline(always)]
    fn begin_parting<S: Simd, const FIXED: bool>(
        &self,
        simd: S,
        block: &mut ContactBlock,
        extra: Option<&Extra>,
        parting: &mut Parting,
    ) {
        let ctx = self.ctx;
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let rows = block.rows();
        let softness = if FIXED { &ctx.soft_fixed } else { &ctx.soft };
        let (mut load_sum, mut points) = (zero, zero);
        for point in &block.points[..rows] {
            load_sum += load(simd, &point.impulse);
            points += select(above(load(simd, &point.mass), zero), one, zero);
        }
        let give = load_sum / max(points, one) * splat(simd, give(softness));
        let takes = self.taking_part(block);
        let parts = lanes(block.parting);
        let parts = above(load(simd, &parts), zero);
        let inv_dt = splat(simd, 1.0 / ctx.dt);
        let (minimum, rate) = (splat(simd, ctx.push_speed), splat(simd, DEEP_RATE));
        let of = |load: fn(S, &ReadRows<'_, SolverBody>, &[u32; LANES]) -> Velocity<S>| {
            (
                load(simd, &self.body.solver_bodies, &block.row_a),
                load(simd, &self.body.solver_bodies, &block.row_b),
            )
        };
        let (motion, velocity) = (of(load_motion), of(load_velocity));
        let mut maximum = zero;
        for j in 0..rows {
            let point = &block.points[j];
            let mut s = load(simd, &point.s0) + along::<S, FIXED>(simd, block, j, &motion);
            let mut vn = along::<S, FIXED>(simd, block, j, &velocity);
            if let Some(extra) = extra
                && extra.drifts
            {
                let drift = load(simd, &extra.drift[j]);
                (s, vn) = (s + drift * splat(simd, ctx.dt), vn + drift);
            }
            let mass = load(simd, &point.mass) * load(simd, &takes);
            let excess = max(-s - give * load(simd, &block.k[K[j][j]]), zero);
            let excess = select(above(mass, zero), excess, zero);
            maximum = max(maximum, excess);
            // Do not add to the speed of points that already separate: a bounce keeps its energy.
            let speed = min(excess * inv_dt, max(minimum, rate * -s));
            let speed = max(speed - max(vn, zero), zero);
            let wanted = select(parts, speed, zero) - max(s, zero) * inv_dt;
            wanted.store_array(&mut parting.wanted[j]);
            mass.store_array(&mut parting.mass[j]);
            parting.impulse[j] = [0.0; LANES];
        }
        let goes_on = above(maximum, splat(simd, ctx.parted[usize::from(FIXED)]));
        #[expect(clippy::cast_possible_truncation, reason = "eight bits")]
        let goes_on = bits(goes_on) as u8;
        block.parting &= goes_on;
        parting.is_ready = true;
    }

    /// 1 for each lane whose bodies may be displaced.
    fn taking_part(&self, block: &ContactBlock) -> Lanes {
        let free = |solver_row: u32| {
            solver_row == 0 || is_free(self.bodies.at(self.plan.members[solver_row as usize - 1]))
        };
        core::array::from_fn(|lane| {
            let is_free = free(block.row_a[lane]) && free(block.row_b[lane]);
            f32::from(u8::from(is_free))
        })
    }

    /// Displaces a body by its pseudo-velocity, limited to a part of its size.
    fn move_apart(&self, i: usize) {
        let displacement = self.contact.pseudo_velocities.read(i);
        if displacement.v.iter().chain(&displacement.w).all(|x| *x == 0.0) {
            return;
        }
        let row = self.plan.members[i - 1];
        let (extent, whitening) = (self.bodies.at(row).extent, self.body.whitening.read(i));
        let (v, w) =
            (three(displacement.v) * whitening.alpha(), whitening.s().mul(three(displacement.w)));
        let part = |size: f32, maximum: f32| if size > maximum { maximum / size } else { 1.0 };
        let of_v = part(v.length(), DEEP_RATE * extent);
        let of_w = part(w.length(), DEEP_RATE);
        let (solver_body, dt) = (self.body.solver_bodies.row(i), self.ctx.dt);
        for k in 0..4 {
            solver_body.x[k] += dt * of_v * displacement.v[k];
        }
        if self.plan.turning.bodies.contains(row) {
            let state = self.body.states.row(i);
            state.rotation = state.rotation.turned_by(w * (dt * of_w));
        } else {
            for k in 0..4 {
                solver_body.t[k] += dt * of_w * displacement.w[k];
            }
        }
        self.body.aux.row(i).parts_at(of_v * v.length() + of_w * w.length() * extent);
    }
}

/// Change of a point's separation by a motion of both bodies, or its speed by their velocities.
#[inline(always)]
fn along<S: Simd, const FIXED: bool>(
    simd: S,
    block: &ContactBlock,
    j: usize,
    (a, b): &(Velocity<S>, Velocity<S>),
) -> Wide<S> {
    let n = Vec3w::load(simd, &block.n);
    let point = &block.points[j];
    let of_b = n.dot(b.v) * load(simd, &block.beta) + Vec3w::load(simd, &point.b).dot(b.w);
    if FIXED {
        return of_b;
    }
    of_b - (n.dot(a.v) * load(simd, &block.alpha) + Vec3w::load(simd, &point.a).dot(a.w))
}

/// Runs a Gauss-Seidel sweep over a block: points separate at their target speeds, and none
/// approaches more than allowed.
#[inline(always)]
fn sweep<S: Simd, const FIXED: bool, const N: usize>(
    simd: S,
    block: &ContactBlock,
    parting: &mut Parting,
    displacements: &Rows<'_, SolverBody>,
) {
    let zero = splat(simd, 0.0);
    let mut a = Velocity::zero(simd);
    if !FIXED {
        a = load_velocity(simd, displacements, &block.row_a);
    }
    let mut of = (a, load_velocity(simd, displacements, &block.row_b));
    let (mut speed, mut given) = ([zero; N], [zero; N]);
    for j in 0..N {
        speed[j] = along::<S, FIXED>(simd, block, j, &of) - load(simd, &parting.wanted[j]);
    }
    for _ in 0..2 {
        for j in 0..N {
            let old = load(simd, &parting.impulse[j]);
            let new = max(old - load(simd, &parting.mass[j]) * speed[j], zero);
            new.store_array(&mut parting.impulse[j]);
            let d = new - old;
            given[j] += d;
            for i in 0..N {
                speed[i] += load(simd, &block.k[K[i][j]]) * d;
            }
        }
    }
    let mut push = zero;
    for j in 0..N {
        push += given[j];
        of.1.w = of.1.w + Vec3w::load(simd, &block.points[j].b) * given[j];
        if !FIXED {
            of.0.w = of.0.w - Vec3w::load(simd, &block.points[j].a) * given[j];
        }
    }
    let push = Vec3w::load(simd, &block.n) * push;
    of.1.v = of.1.v + push * load(simd, &block.beta);
    store_velocity(simd, displacements, &block.row_b, of.1);
    if !FIXED {
        of.0.v = of.0.v - push * load(simd, &block.alpha);
        store_velocity(simd, displacements, &block.row_a, of.0);
    }
}
