//! Parameters of a sweep over joints, and the rotation of anchors within a step.

use fearless_simd::Simd;

use crate::base::simd::wide::{LANES, Vec3w, Wide, min, splat};
use crate::base::threads::disjoint::ReadRows;
use crate::step::context::StepContext;
use crate::step::context::caps::Caps;
use crate::step::context::softness::Softness;
use crate::step::solver_body::{SolverBody, Velocity, load_motion, load_velocity};

/// A rotation by a vector of up to 2.8 rad.
#[derive(Clone, Copy)]
pub(crate) struct Rotation<S: Simd> {
    /// Half the vector, and the factors on its product with a lever arm and on the product with
    /// this product.
    half: Vec3w<S>,
    once: Wide<S>,
    twice: Wide<S>,
}

impl<S: Simd> Rotation<S> {
    /// Rodrigues' formula with tan y = y a/b, a = 1 - y²/9 + y⁴/945, b = 1 - 4 y²/9 + y⁴/63, which
    /// has an error of 1e-6 at 1 rad. (With integers in a and b small rotations would be rounded.)
    #[inline(always)]
    pub(crate) fn new(simd: S, t: Vec3w<S>) -> Self {
        let half = t * splat(simd, 0.5);
        let q = min(half.dot(half), splat(simd, 2.0));
        let one = splat(simd, 1.0);
        let a = one - (splat(simd, 1.0 / 9.0) - splat(simd, 1.0 / 945.0) * q) * q;
        let b = one - (splat(simd, 4.0 / 9.0) - splat(simd, 1.0 / 63.0) * q) * q;
        let scale = (a + a) / (b * b + q * (a * a));
        Self { half, once: scale * b, twice: scale * a }
    }

    /// Displacement of `r`.
    #[inline(always)]
    pub(crate) fn shift(&self, r: Vec3w<S>) -> Vec3w<S> {
        let once = self.half.cross(r);
        once * self.once + self.half.cross(once) * self.twice
    }

    #[inline(always)]
    pub(crate) fn apply(&self, r: Vec3w<S>) -> Vec3w<S> {
        r + self.shift(r)
    }
}

/// Parameters of one sweep over joints.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointSweep {
    pub(crate) inv_h: f32,
    pub(crate) softness: Softness,
    /// Limits on the speed at which errors close.
    pub(crate) caps: Caps,
    /// [`Softness::hardness`] of locked axes, which limits drives and sprung limits: these act
    /// through the locked axes. (With twice the frequency of the locked axes, muscles of 1e5 N m
    /// drove ragdolls to 1e15 J.)
    pub(crate) hardest: f32,
    /// Time of the step that positions have advanced [s].
    pub(crate) elapsed: f32,
    /// Relax sweep: age of the rows [s]; the warm start stays at its former lever arms.
    pub(crate) back: f32,
    pub(crate) is_relax: bool,
}

impl JointSweep {
    /// A solve sweep after positions have advanced by `elapsed` [s].
    pub(crate) const fn solving(ctx: &StepContext, elapsed: f32) -> Self {
        let softness = ctx.soft_joint;
        let hardest = softness.hardness();
        let (inv_h, caps) = (ctx.inv_h, ctx.caps);
        Self { inv_h, softness, caps, hardest, elapsed, back: 0.0, is_relax: false }
    }

    /// A relax sweep at the middle of a substep, after positions have advanced to its end, `moved`
    /// [s].
    pub(crate) fn relaxing(ctx: &StepContext, moved: f32) -> Self {
        let back = 0.5 * ctx.h;
        let solving = Self::solving(ctx, moved - back);
        Self { softness: Softness::RIGID, back, is_relax: true, ..solving }
    }

    /// Velocities of eight bodies, and their motion at the time of this sweep's rows.
    #[inline(always)]
    pub(crate) fn read<S: Simd>(
        &self,
        simd: S,
        solver_bodies: &ReadRows<'_, SolverBody>,
        rows: &[u32; LANES],
    ) -> (Velocity<S>, Velocity<S>) {
        let v = load_velocity(simd, solver_bodies, rows);
        let mut x = load_motion(simd, solver_bodies, rows);
        if self.is_relax {
            let back = splat(simd, self.back);
            (x.v, x.w) = (x.v - v.v * back, x.w - v.w * back);
        }
        (v, x)
    }
}

/// Difference of the distances of the ends of arms B and A from their tangents after a substep,
/// over the substep: w × (w × r) h/2. It is at most a chord for a fast rotation. Without it the
/// joints of a crank at ten turns per second open by centimeters.
#[inline(always)]
pub(crate) fn bend<S: Simd>(
    simd: S,
    [wa, wb]: [Vec3w<S>; 2],
    [ra, rb]: [Vec3w<S>; 2],
    h: Wide<S>,
) -> Vec3w<S> {
    let half = h * splat(simd, 0.5);
    let one = splat(simd, 1.0);
    let chord = |w: Vec3w<S>| one + half * half * w.dot(w);
    let (chord_a, chord_b) = (chord(wa), chord(wb));
    let share = half / (chord_a * chord_b);
    wb.cross(wb.cross(rb)) * (chord_a * share) - wa.cross(wa.cross(ra)) * (chord_b * share)
}
