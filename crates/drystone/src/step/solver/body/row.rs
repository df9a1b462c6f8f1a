//! Data of a solver body that the kernels do not read.

use crate::base::math::Vec3;
use crate::state::bodies::body::Body;
use crate::step::solver_body::{SolverBody, Whitening, four};

/// Rotation in a step above which free rotation is integrated apart from impulses [rad].
pub(crate) const SPLIT_ROTATION: f32 = 0.25;

/// Data of a solver body between sweeps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Aux {
    /// Whitened velocity after forces and before any impulse of this substep.
    pub(crate) before_v: [f32; 4],
    pub(crate) before_w: [f32; 4],
    /// Whitened velocity that forces and free rotation add in a substep.
    pub(crate) add_v: [f32; 4],
    pub(crate) add_w: [f32; 4],
    pub(crate) decay_v: f32,
    pub(crate) decay_w: f32,
    pub(crate) locked: [bool; 3],
    /// An impact may change the velocity in this step, so free rotation cannot be computed from the
    /// step's start: `add_w` contains none of it.
    pub(crate) calm: bool,
    /// [`Solved::ends`](super::solved::Solved::ends) holds the body's state at the step's end; the
    /// solver body's motion does not count.
    pub(crate) ended: bool,
    /// Speed at which overlap correction moves the body in this step [m/s].
    pub(crate) parting: f32,
}

/// Velocity of a solver body with the carried impulses, and before them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Carried {
    v: [[f32; 4]; 2],
    w: [[f32; 4]; 2],
}

impl Aux {
    /// Removes the impulses carried from the last substep from the solver body's velocity.
    pub(crate) fn lift(&self, solver_body: &mut SolverBody) -> Carried {
        let carried =
            Carried { v: [solver_body.v, self.before_v], w: [solver_body.w, self.before_w] };
        (solver_body.v, solver_body.w) = (self.before_v, self.before_w);
        carried
    }

    /// Restores them: exactly the former velocity if no impact changed it.
    pub(crate) fn put_back(&self, solver_body: &mut SolverBody, carried: &Carried) {
        let Carried { v: [v, before_v], w: [w, before_w] } = carried;
        for i in 0..4 {
            solver_body.v[i] = v[i] + (self.before_v[i] - before_v[i]);
            solver_body.w[i] = w[i] + (self.before_w[i] - before_w[i]);
        }
    }

    /// Leaves out free rotation for the rest of the step, for a body that turns far in it.
    pub(crate) fn calm(&mut self, whitening: &Whitening, body: &Body, dt: f32, h: f32) {
        self.calm = true;
        if body.w.length_squared() * (dt * dt) > SPLIT_ROTATION * SPLIT_ROTATION {
            self.add_w = four(whitening.s().mul(body.forces.torque + body.forces.step_torque) * h);
        }
    }

    /// Sets the angular acceleration of a body that is rotated separately: only torque [N m,
    /// world], no free rotation.
    pub(crate) fn turn_by_torque(&mut self, whitening: &Whitening, body: &Body, h: f32) {
        self.add_w = four(whitening.s().mul(body.forces.torque + body.forces.step_torque) * h);
    }

    /// Clears the impulses that the next substep would repeat.
    pub(crate) fn start_anew(&mut self, solver_body: &SolverBody) {
        (self.before_v, self.before_w) = (solver_body.v, solver_body.w);
    }

    /// Removes impulses, times their scales, from those carried to the next substep.
    #[inline]
    pub(crate) fn begin_later(&mut self, v: &[f32; 4], scale_v: f32, w: &[f32; 4], scale_w: f32) {
        for i in 0..4 {
            self.before_v[i] += v[i] * scale_v;
            self.before_w[i] += w[i] * scale_w;
        }
    }

    /// Whitened velocity and angular velocity before any impulse of this substep.
    pub(crate) const fn before(&self) -> [[f32; 4]; 2] {
        [self.before_v, self.before_w]
    }

    /// Whitened velocity and angular velocity when the substep began, before forces.
    #[inline(always)]
    pub(crate) fn start(&self) -> [[f32; 4]; 2] {
        let back = |before: f32, decay: f32, add: f32| {
            if decay > 0.0 { before / decay - add } else { 0.0 }
        };
        let mut start = [[0.0; 4]; 2];
        for i in 0..3 {
            start[0][i] = back(self.before_v[i], self.decay_v, self.add_v[i]);
            start[1][i] = back(self.before_w[i], self.decay_w, self.add_w[i]);
        }
        start
    }

    /// Records the speed at which overlap correction moves the body [m/s].
    pub(crate) const fn parts_at(&mut self, speed: f32) {
        self.parting = speed;
    }

    /// See [`Self::parts_at`].
    pub(crate) const fn parting(&self) -> f32 {
        self.parting
    }

    /// Square of the whitened velocity that forces add in a substep.
    pub(crate) const fn kick(&self) -> f32 {
        let [x, y, z, _] = self.add_v;
        x * x + y * y + z * z
    }

    /// True if a translation is locked.
    pub(crate) fn is_locked(&self) -> bool {
        self.locked != [false; 3]
    }

    /// Applies an impact, whose impulse the next substep does not repeat.
    #[inline]
    pub(crate) fn strike(&mut self, solver_body: &mut SolverBody, dv: Vec3, dw: Vec3) {
        let (dv, dw) = (four(dv), four(dw));
        for i in 0..4 {
            solver_body.v[i] += dv[i];
            solver_body.w[i] += dw[i];
            self.before_v[i] += dv[i];
            self.before_w[i] += dw[i];
        }
    }

    /// True if only forces and damping moved the body's center in `substeps` substeps of `h`.
    /// (Every impulse of a row moves it.)
    pub(crate) fn flew(
        &self,
        solver_body: &SolverBody,
        start: [f32; 4],
        substeps: u32,
        h: f32,
    ) -> bool {
        let (mut v, mut x) = (start, [0.0; 4]);
        for _ in 0..substeps {
            for i in 0..4 {
                v[i] = (v[i] + self.add_v[i]) * self.decay_v;
                x[i] += h * v[i];
            }
        }
        (0..4).all(|i| same(v[i], solver_body.v[i]) && same(x[i], solver_body.x[i]))
    }

    /// Removes locked translations.
    pub(crate) fn hold_locked(&self, solver_body: &mut SolverBody) {
        for i in 0..3 {
            if self.locked[i] {
                solver_body.v[i] = 0.0;
            }
        }
    }
}

/// Exact equality, to compare the results of two equal computations.
#[expect(clippy::float_cmp, reason = "whether anything at all was added")]
pub(crate) fn same(a: f32, b: f32) -> bool {
    a == b
}
