//! The solver's own rows: whitened bodies, and blocks of eight constraints.
//!
//! Symbols: α = 1/√m, S = R diag(1/√I) Rᵀ; v̂ = v/α, ŵ = S⁻¹ω. A row of a constraint along n at
//! the arm r is one vector `a = S (r × n)`: it reads the velocity (`a · ŵ`) and takes the impulse
//! (`ŵ += a λ`). See docs/derivations/soft-step.md.

use crate::base::disjoint::Rows;
use crate::base::sym3::Sym3;
use crate::base::wide::{LANES, Lanes, Sym3w, Vec3w, Wide, gather, gather4, load, scatter, splat};
use crate::step::context::StepContext;
use fearless_simd::{Simd, SimdBase, f32x4};

/// A body in the solver: one cache line. Line 0 is everything that cannot be pushed: always zero.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Line {
    /// v̂
    pub(crate) v: [f32; 4],
    /// ŵ
    pub(crate) w: [f32; 4],
    /// Change of position since the step's start, /α.
    pub(crate) x: [f32; 4],
    /// Change of rotation (vector) since the step's start, S⁻¹.
    pub(crate) t: [f32; 4],
}

/// α and S of a body, for preparing rows: (xx, yy, zz, α), (xy, xz, yz, 0).
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct Whitening {
    diagonal: [f32; 4],
    rest: [f32; 4],
}

impl Whitening {
    pub(crate) const fn new(alpha: f32, s: &Sym3) -> Self {
        Self { diagonal: [s.xx, s.yy, s.zz, alpha], rest: [s.xy, s.xz, s.yz, 0.0] }
    }

    pub(crate) const fn alpha(&self) -> f32 {
        self.diagonal[3]
    }

    pub(crate) const fn s(&self) -> Sym3 {
        let ([xx, yy, zz, _], [xy, xz, yz, _]) = (self.diagonal, self.rest);
        Sym3 { xx, yy, zz, xy, xz, yz }
    }

    /// α and S of bodies, lane by lane.
    #[inline(always)]
    pub(crate) fn gather<S: Simd>(simd: S, of: [&Self; LANES]) -> (Wide<S>, Sym3w<S>) {
        let (mut diagonal, mut rest) = ([&of[0].diagonal; LANES], [&of[0].rest; LANES]);
        for lane in 1..LANES {
            (diagonal[lane], rest[lane]) = (&of[lane].diagonal, &of[lane].rest);
        }
        let [xx, yy, zz, alpha] = gather4(simd, diagonal);
        let Vec3w { x: xy, y: xz, z: yz } = gather(simd, rest);
        (alpha, Sym3w { xx, yy, zz, xy, xz, yz })
    }
}

/// The velocities of eight bodies.
#[derive(Clone, Copy)]
pub(crate) struct Velocity<S: Simd> {
    pub(crate) v: Vec3w<S>,
    pub(crate) w: Vec3w<S>,
}

impl<S: Simd> Velocity<S> {
    #[inline(always)]
    pub(crate) fn zero(simd: S) -> Self {
        Self { v: Vec3w::zero(simd), w: Vec3w::zero(simd) }
    }
}

/// The rows of a block's bodies.
#[inline(always)]
pub(crate) fn read_lanes<'a, T: Sync>(rows: &'a Rows<'_, T>, r: &[u32; LANES]) -> [&'a T; LANES] {
    let mut all = [rows.read(r[0] as usize); LANES];
    for lane in 1..LANES {
        all[lane] = rows.read(r[lane] as usize);
    }
    all
}

/// v̂ and ŵ of a block's bodies.
#[inline(always)]
pub(crate) fn load_velocity<S: Simd>(
    simd: S,
    lines: &Rows<'_, Line>,
    rows: &[u32; LANES],
) -> Velocity<S> {
    let of = read_lanes(lines, rows);
    let (mut v, mut w) = ([&of[0].v; LANES], [&of[0].w; LANES]);
    for lane in 1..LANES {
        (v[lane], w[lane]) = (&of[lane].v, &of[lane].w);
    }
    Velocity { v: gather(simd, v), w: gather(simd, w) }
}

/// The motion of a block's bodies since the step's start, in place of velocities.
#[inline(always)]
pub(crate) fn load_motion<S: Simd>(
    simd: S,
    lines: &Rows<'_, Line>,
    rows: &[u32; LANES],
) -> Velocity<S> {
    let of = read_lanes(lines, rows);
    let (mut x, mut t) = ([&of[0].x; LANES], [&of[0].t; LANES]);
    for lane in 1..LANES {
        (x[lane], t[lane]) = (&of[lane].x, &of[lane].t);
    }
    Velocity { v: gather(simd, x), w: gather(simd, t) }
}

/// Writes velocities back. Line 0 is everyone's, and is never written.
#[inline(always)]
pub(crate) fn store_velocity<S: Simd>(
    simd: S,
    lines: &Rows<'_, Line>,
    rows: &[u32; LANES],
    velocity: Velocity<S>,
) {
    let v: [f32x4<S>; LANES] = scatter(simd, velocity.v);
    let w: [f32x4<S>; LANES] = scatter(simd, velocity.w);
    for i in 0..LANES {
        if rows[i] != 0 {
            let line = lines.row(rows[i] as usize);
            v[i].store_array(&mut line.v);
            w[i].store_array(&mut line.w);
        }
    }
}

/// What a contact has for each of its points.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct PointRows {
    pub(crate) b: [Lanes; 3],
    /// Separation at the step's start.
    pub(crate) s0: Lanes,
    /// 1/K_jj, 0 for a point not there.
    pub(crate) mass: Lanes,
    pub(crate) impulse: Lanes,
    /// Last, so that contacts with fixed bodies do not come near it.
    pub(crate) a: [Lanes; 3],
}

/// Eight contacts. Where only one body can be pushed, it is B, whichever it is in the contact (signs of
/// its rows and of β are turned if it is A): `row_a`, `alpha` and the rows `a` are zero then, and unread.
///
/// Lanes must not straddle cache lines. (With a single `u32` in between, the sweeps took half as long again.)
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct ContactBlock {
    pub(crate) row_b: [u32; LANES],
    pub(crate) beta: Lanes,
    pub(crate) n: [Lanes; 3],
    pub(crate) mu: Lanes,
    pub(crate) t1: [Lanes; 3],
    pub(crate) t2: [Lanes; 3],
    pub(crate) b_t: [[Lanes; 3]; 3],
    /// Inverse of the 3 × 3 matrix of friction's rows (t1, t2, twist): 11, 12, 22, 13, 23, 33.
    pub(crate) mass_t: [Lanes; 6],
    /// A step along all three rows alike that does not overshoot: for what slides.
    pub(crate) mass_slide: Lanes,
    /// Friction along t1 and t2, and twist about n as an impulse at the reach [N s].
    pub(crate) friction: [Lanes; 3],
    pub(crate) row_a: [u32; LANES],
    pub(crate) alpha: Lanes,
    pub(crate) a_t: [[Lanes; 3]; 3],
    /// K_ij, the upper triangle by columns: 00, 01 11, 02 12 22, 03 13 23 33.
    pub(crate) k: [Lanes; 10],
    /// 1 where the contact had no impulse when the step began: it gets more rounds.
    pub(crate) fresh: Lanes,
    pub(crate) any_fresh: bool,
    /// Not all contacts have as many points as the rows that are solved for the block: 1, 2 or 4.
    pub(crate) is_mixed: bool,
    /// Most points of a contact in it.
    pub(crate) count: u8,
    /// A bit for each lane that was pressed in any sweep of the step: what the last one leaves tells nothing of a landing
    /// that an earlier one stopped.
    pub(crate) pressed: u8,
    /// A bit for each lane that overlaps more than its load explains: see parting.rs.
    pub(crate) parting: u8,
    /// A bit for each lane that may bounce or get a blow in this step, and for each that did.
    pub(crate) arrives: u8,
    pub(crate) hit: u8,
    /// Its rows are made anew in each substep.
    pub(crate) is_renewed: bool,
    /// Of each lane its points that may land in this step: see [`Watch`](super::tally::Watch).
    pub(crate) landing: [u8; LANES],
    /// Last, so that with fewer points less is read.
    pub(crate) points: [PointRows; 4],
}

impl ContactBlock {
    /// How many rows the kernel solves: more than its contacts have points, if those are three.
    pub(crate) const fn rows(&self) -> usize {
        match self.count {
            0 | 1 => 1,
            2 => 2,
            _ => 4,
        }
    }

    /// How much of a block a sweep reads whose contacts have so many points.
    #[inline(always)]
    pub(crate) const fn cache_lines(points: usize) -> usize {
        (core::mem::offset_of!(Self, points) + points * size_of::<PointRows>()).div_ceil(64)
    }
}

/// What only some contacts need, beside their block: bounce, rolling resistance, moving partners.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Extra {
    pub(crate) bounces: bool,
    pub(crate) rolls: bool,
    pub(crate) drifts: bool,
    /// Kinetic friction is less than static friction.
    pub(crate) slips: bool,
    /// Some give as springs of their own.
    pub(crate) softens: bool,
    /// Coefficient of restitution; 0: no bounce.
    pub(crate) restitution: Lanes,
    /// Relative acceleration along the normal [m/s²].
    pub(crate) fall: Lanes,
    /// Speed that forces alone give one of the bodies along the normal in a step [m/s].
    pub(crate) slow: Lanes,
    /// Normal speed of the points that comes from kinematic bodies; that of friction's rows.
    pub(crate) drift: [Lanes; 4],
    pub(crate) drift_t: [Lanes; 3],
    /// How that of the tangents grows [m/s²].
    pub(crate) drift_rate: [Lanes; 2],
    /// Kinetic friction as a part of the static one.
    pub(crate) kinetic: Lanes,
    /// [`Softness`](super::softness::Softness) of those that have one of their own; the mass of others is 0.
    pub(crate) soft_rate: Lanes,
    pub(crate) soft_mass: Lanes,
    pub(crate) soft_impulse: Lanes,
    /// S of both bodies, for rolling.
    pub(crate) s_a: [Lanes; 6],
    pub(crate) s_b: [Lanes; 6],
    /// Limit of the rolling impulse per normal impulse [m].
    pub(crate) rolling: Lanes,
    pub(crate) rolling_impulse: [Lanes; 3],
}

impl Extra {
    /// Adds what the tangents' velocity grows by [m/s²] between bodies that turn together. The rows are those of the middle of the step,
    /// and a sweep makes the velocity of the substep after it: that at its middle.
    #[inline(always)]
    pub(crate) fn corotate<S: Simd>(&mut self, simd: S, rate: &[Wide<S>; 2], ctx: &StepContext) {
        self.drifts = true;
        let from = splat(simd, 0.5 * (ctx.h - ctx.dt));
        for i in 0..2 {
            let velocity = load(simd, &self.drift_t[i]) + rate[i] * from;
            velocity.store_array(&mut self.drift_t[i]);
            let rate = load(simd, &self.drift_rate[i]) + rate[i];
            rate.store_array(&mut self.drift_rate[i]);
        }
    }

    /// Square of the frequency of a lane that is a spring of its own [rad²/s²], in substeps of this rate [1/s].
    pub(crate) fn spring(&self, lane: usize, inv_h: f32) -> Option<f64> {
        let is_soft = self.softens && self.soft_mass[lane] > 0.0;
        is_soft.then(|| f64::from(self.soft_rate[lane] / self.soft_impulse[lane] * inv_h))
    }
}

/// Eight joints, balls or distances. As in [`ContactBlock`], lanes do not straddle cache lines.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct JointBlock {
    pub(crate) row_a: [u32; LANES],
    pub(crate) row_b: [u32; LANES],
    pub(crate) alpha: Lanes,
    pub(crate) beta: Lanes,
    /// Of balls the one number of S of each body, if the inertia of all of them is the same about every axis, and nothing in
    /// [`JointRest::s_a`] and `s_b` then; else the first is below 0.
    pub(crate) round: [Lanes; 2],
    /// Arms at the step's start.
    pub(crate) r_a: [Lanes; 3],
    pub(crate) r_b: [Lanes; 3],
    /// Anchor B less anchor A at the step's start.
    pub(crate) gap: [Lanes; 3],
    pub(crate) impulse: [Lanes; 3],
    /// The part of the warm start that the bodies carry, as it was applied: r × p of each body.
    pub(crate) carried_a: [Lanes; 3],
    pub(crate) carried_b: [Lanes; 3],
}

/// What only some blocks of joints need, beside them: so that the others lie closer together.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct JointRest {
    pub(crate) s_a: [Lanes; 6],
    pub(crate) s_b: [Lanes; 6],
    /// Velocity of the gap that comes from kinematic bodies, where one of the bodies cannot be pushed.
    pub(crate) drift: [Lanes; 3],
    /// Distances: the linear part of the warm start; of balls it is their impulse.
    pub(crate) carried: [Lanes; 3],
    /// Distances: least, greatest, rest length; spring rate, mass, impulse (all 0: no spring).
    pub(crate) limits: [Lanes; 3],
    pub(crate) spring: [Lanes; 3],
}

impl JointBlock {
    /// It is one of balls, and the inertia of all its bodies is the same about every axis.
    pub(crate) fn is_round(&self) -> bool {
        self.round[0][0] >= 0.0
    }
}
