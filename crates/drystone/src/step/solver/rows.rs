//! The solver's own rows: whitened bodies, and blocks of eight constraints.
//!
//! Symbols: α = 1/√m, S = R diag(1/√I) Rᵀ; v̂ = v/α, ŵ = S⁻¹ω. A row of a constraint along n at
//! the arm r is one vector `a = S (r × n)`: it reads the velocity (`a · ŵ`) and takes the impulse
//! (`ŵ += a λ`). See docs/derivations/soft-step.md.

use crate::base::disjoint::Rows;
use crate::base::wide::{LANES, Lanes, Vec3w, gather, scatter};
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

/// α and S of a body, for preparing rows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Whitening {
    pub(crate) alpha: f32,
    pub(crate) s: [f32; 6],
}

/// The velocities of eight bodies.
#[derive(Clone, Copy)]
pub(crate) struct Velocity<S: Simd> {
    pub(crate) v: Vec3w<S>,
    pub(crate) w: Vec3w<S>,
}

#[inline(always)]
fn lines8<'a>(lines: &'a Rows<'_, Line>, r: &[u32; LANES]) -> [&'a Line; LANES] {
    [
        lines.read(r[0] as usize),
        lines.read(r[1] as usize),
        lines.read(r[2] as usize),
        lines.read(r[3] as usize),
        lines.read(r[4] as usize),
        lines.read(r[5] as usize),
        lines.read(r[6] as usize),
        lines.read(r[7] as usize),
    ]
}

/// v̂ and ŵ of eight bodies.
#[inline(always)]
pub(crate) fn load_velocity<S: Simd>(
    simd: S,
    lines: &Rows<'_, Line>,
    rows: &[u32; LANES],
) -> Velocity<S> {
    let [a, b, c, d, e, f, g, h] = lines8(lines, rows);
    Velocity {
        v: gather(simd, [&a.v, &b.v, &c.v, &d.v, &e.v, &f.v, &g.v, &h.v]),
        w: gather(simd, [&a.w, &b.w, &c.w, &d.w, &e.w, &f.w, &g.w, &h.w]),
    }
}

/// The motion of eight bodies since the step's start, in place of velocities.
#[inline(always)]
pub(crate) fn load_motion<S: Simd>(
    simd: S,
    lines: &Rows<'_, Line>,
    rows: &[u32; LANES],
) -> Velocity<S> {
    let [a, b, c, d, e, f, g, h] = lines8(lines, rows);
    Velocity {
        v: gather(simd, [&a.x, &b.x, &c.x, &d.x, &e.x, &f.x, &g.x, &h.x]),
        w: gather(simd, [&a.t, &b.t, &c.t, &d.t, &e.t, &f.t, &g.t, &h.t]),
    }
}

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
        // Line 0 is shared by all colors' statics: it is never written.
        if rows[i] != 0 {
            let line = lines.row(rows[i] as usize);
            v[i].store_array(&mut line.v);
            w[i].store_array(&mut line.w);
        }
    }
}

/// Eight contacts.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct ContactBlock {
    pub(crate) row_a: [u32; LANES],
    pub(crate) row_b: [u32; LANES],
    pub(crate) contact: [u32; LANES],
    /// Most points of a contact in it.
    pub(crate) points: u32,
    pub(crate) alpha: Lanes,
    pub(crate) beta: Lanes,
    pub(crate) n: [Lanes; 3],
    pub(crate) t1: [Lanes; 3],
    pub(crate) t2: [Lanes; 3],
    pub(crate) a: [[Lanes; 3]; 4],
    pub(crate) b: [[Lanes; 3]; 4],
    /// Separation at the step's start.
    pub(crate) s0: [Lanes; 4],
    /// 1/K_jj, 0 for points not there.
    pub(crate) mass: [Lanes; 4],
    /// K_ij, upper triangle by rows: 00 01 02 03 11 12 13 22 23 33.
    pub(crate) k: [Lanes; 10],
    pub(crate) impulse: [Lanes; 4],
    /// 1 where the contact had no impulse when the step began: it gets more rounds.
    pub(crate) fresh: Lanes,
    pub(crate) any_fresh: bool,
    pub(crate) lever: [Lanes; 4],
    pub(crate) mu: Lanes,
    pub(crate) a_t: [[Lanes; 3]; 3],
    pub(crate) b_t: [[Lanes; 3]; 3],
    /// Inverse of the 2 × 2 tangent matrix: 11, 12, 22; and of the twist row.
    pub(crate) mass_t: [Lanes; 4],
    /// Friction along t1 and t2, twist about n.
    pub(crate) friction: [Lanes; 3],
}

const Z: Lanes = [0.0; LANES];

impl Default for ContactBlock {
    fn default() -> Self {
        Self {
            row_a: [0; LANES],
            row_b: [0; LANES],
            contact: [u32::MAX; LANES],
            points: 0,
            alpha: Z,
            beta: Z,
            n: [Z; 3],
            t1: [Z; 3],
            t2: [Z; 3],
            a: [[Z; 3]; 4],
            b: [[Z; 3]; 4],
            s0: [Z; 4],
            mass: [Z; 4],
            k: [Z; 10],
            impulse: [Z; 4],
            fresh: Z,
            any_fresh: false,
            lever: [Z; 4],
            mu: Z,
            a_t: [[Z; 3]; 3],
            b_t: [[Z; 3]; 3],
            mass_t: [Z; 4],
            friction: [Z; 3],
        }
    }
}

/// What only some contacts need, beside their block: bounce, rolling resistance, moving partners.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Extra {
    pub(crate) bounces: bool,
    pub(crate) rolls: bool,
    pub(crate) drifts: bool,
    /// Speed after the bounce squared, e² u²; 0: no bounce.
    pub(crate) bounce: [Lanes; 4],
    /// Twice the relative acceleration along the normal: height already gained is paid for.
    pub(crate) fall: Lanes,
    /// Greatest impulse in any sweep.
    pub(crate) pressed: [Lanes; 4],
    /// Normal speed of the points that comes from kinematic bodies; that of friction's rows.
    pub(crate) drift: [Lanes; 4],
    pub(crate) drift_t: [Lanes; 3],
    /// S of both bodies, for rolling.
    pub(crate) s_a: [Lanes; 6],
    pub(crate) s_b: [Lanes; 6],
    /// Limit of the rolling impulse per normal impulse [m].
    pub(crate) rolling: Lanes,
    pub(crate) rolling_impulse: [Lanes; 3],
}

/// Eight joints, balls or distances.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct JointBlock {
    pub(crate) row_a: [u32; LANES],
    pub(crate) row_b: [u32; LANES],
    pub(crate) joint: [u32; LANES],
    pub(crate) is_distance: bool,
    pub(crate) alpha: Lanes,
    pub(crate) beta: Lanes,
    pub(crate) s_a: [Lanes; 6],
    pub(crate) s_b: [Lanes; 6],
    /// Arms at the step's start.
    pub(crate) r_a: [Lanes; 3],
    pub(crate) r_b: [Lanes; 3],
    /// Anchor B less anchor A at the step's start.
    pub(crate) gap: [Lanes; 3],
    /// Velocity of the gap that comes from kinematic bodies.
    pub(crate) drift: [Lanes; 3],
    pub(crate) impulse: [Lanes; 3],
    /// Arms and linear impulse as they were applied last: the part of the warm start that the bodies
    /// carry.
    pub(crate) last_r_a: [Lanes; 3],
    pub(crate) last_r_b: [Lanes; 3],
    pub(crate) last_p: [Lanes; 3],
    /// Distances: least, greatest, rest length; spring rate, mass, impulse (all 0: no spring).
    pub(crate) limits: [Lanes; 3],
    pub(crate) spring: [Lanes; 3],
}

impl Default for JointBlock {
    fn default() -> Self {
        Self {
            row_a: [0; LANES],
            row_b: [0; LANES],
            joint: [u32::MAX; LANES],
            is_distance: false,
            alpha: Z,
            beta: Z,
            s_a: [Z; 6],
            s_b: [Z; 6],
            r_a: [Z; 3],
            r_b: [Z; 3],
            gap: [Z; 3],
            drift: [Z; 3],
            impulse: [Z; 3],
            last_r_a: [Z; 3],
            last_r_b: [Z; 3],
            last_p: [Z; 3],
            limits: [Z; 3],
            spring: [Z; 3],
        }
    }
}
