//! Rows of the solver for bodies: whitened velocities and displacements, and their access for eight
//! lanes.
//!
//! Symbols: α = 1/√m, S = R diag(1/√I) Rᵀ; v̂ = v/α, ŵ = S⁻¹ω. A row of a constraint along n at
//! the arm r is one vector `a = S (r × n)`: it reads the velocity (`a · ŵ`) and takes the impulse
//! (`ŵ += a λ`). See docs/derivations/soft-step.md.

use fearless_simd::{Simd, SimdBase, f32x4};

use crate::base::math::{Vec3, vec3};
use crate::base::simd::wide::{LANES, Sym3w, Vec3w, Wide, gather, gather4, scatter};
use crate::base::sym3::Sym3;
use crate::base::threads::disjoint::{ReadRows, Rows};

pub(crate) const fn four(v: Vec3) -> [f32; 4] {
    [v.x, v.y, v.z, 0.0]
}

pub(crate) const fn three(v: [f32; 4]) -> Vec3 {
    vec3(v[0], v[1], v[2])
}

/// v̂ of a velocity.
pub(crate) fn whitened(v: Vec3, alpha: f32) -> [f32; 4] {
    four(v * (1.0 / alpha))
}

/// Velocity of a solver body that began with velocity `v`. A small change is added to `v` instead,
/// since √m v / √m is not exactly v. Otherwise an undisturbed body gained or lost up to 6e-8 of its
/// speed in every step, always in the same direction.
pub(crate) fn unwhitened(v: Vec3, solver_body: &SolverBody, alpha: f32) -> Vec3 {
    let (start, mut end) = (whitened(v, alpha), three(solver_body.v) * alpha);
    for i in 0..3 {
        let change = solver_body.v[i] - start[i];
        if change.abs() < 0.5 * start[i].abs() {
            end[i] = v[i] + change * alpha;
        }
    }
    end
}

/// A body in the solver: one cache line. Row 0 stands for everything that cannot be pushed: always
/// zero.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct SolverBody {
    /// v̂
    pub(crate) v: [f32; 4],
    /// ŵ
    pub(crate) w: [f32; 4],
    /// Displacement since the step's start, divided by α.
    pub(crate) x: [f32; 4],
    /// Change of rotation (vector) since the step's start, times S⁻¹.
    pub(crate) t: [f32; 4],
}

/// α and S of a body, for preparing rows: (xx, yy, zz, α), (xy, xz, yz, 0).
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct Whitening {
    diagonal: [f32; 4],
    off_diagonal: [f32; 4],
}

impl Whitening {
    pub(crate) const fn new(alpha: f32, s: &Sym3) -> Self {
        Self { diagonal: [s.xx, s.yy, s.zz, alpha], off_diagonal: [s.xy, s.xz, s.yz, 0.0] }
    }

    pub(crate) const fn alpha(&self) -> f32 {
        self.diagonal[3]
    }

    pub(crate) const fn s(&self) -> Sym3 {
        let ([xx, yy, zz, _], [xy, xz, yz, _]) = (self.diagonal, self.off_diagonal);
        Sym3 { xx, yy, zz, xy, xz, yz }
    }

    /// α and S of eight bodies, in lanes.
    #[inline(always)]
    pub(crate) fn gather<S: Simd>(simd: S, of: [&Self; LANES]) -> (Wide<S>, Sym3w<S>) {
        let (mut diagonal, mut off_diagonal) =
            ([&of[0].diagonal; LANES], [&of[0].off_diagonal; LANES]);
        for lane in 1..LANES {
            (diagonal[lane], off_diagonal[lane]) = (&of[lane].diagonal, &of[lane].off_diagonal);
        }
        let [xx, yy, zz, alpha] = gather4(simd, diagonal);
        let Vec3w { x: xy, y: xz, z: yz } = gather(simd, off_diagonal);
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
pub(crate) fn read_lanes<'a, T: Sync>(
    rows: &'a ReadRows<'_, T>,
    r: &[u32; LANES],
) -> [&'a T; LANES] {
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
    solver_bodies: &ReadRows<'_, SolverBody>,
    rows: &[u32; LANES],
) -> Velocity<S> {
    let of = read_lanes(solver_bodies, rows);
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
    solver_bodies: &ReadRows<'_, SolverBody>,
    rows: &[u32; LANES],
) -> Velocity<S> {
    let of = read_lanes(solver_bodies, rows);
    let (mut x, mut t) = ([&of[0].x; LANES], [&of[0].t; LANES]);
    for lane in 1..LANES {
        (x[lane], t[lane]) = (&of[lane].x, &of[lane].t);
    }
    Velocity { v: gather(simd, x), w: gather(simd, t) }
}

/// Writes velocities back. Row 0 is shared by all, and is never written.
#[inline(always)]
pub(crate) fn store_velocity<S: Simd>(
    simd: S,
    solver_bodies: &Rows<'_, SolverBody>,
    rows: &[u32; LANES],
    velocity: Velocity<S>,
) {
    let v: [f32x4<S>; LANES] = scatter(simd, velocity.v);
    let w: [f32x4<S>; LANES] = scatter(simd, velocity.w);
    for i in 0..LANES {
        if rows[i] != 0 {
            let solver_body = solver_bodies.row(rows[i] as usize);
            v[i].store_array(&mut solver_body.v);
            w[i].store_array(&mut solver_body.w);
        }
    }
}
