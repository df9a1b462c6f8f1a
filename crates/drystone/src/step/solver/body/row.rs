//! Data of a solver body that the kernels do not read.

use super::state::BodyState;
use crate::base::math::Vec3;
use crate::state::bodies::Body;
use crate::step::solver_body::{SolverBody, Whitening, four};

/// Turning by more than this in a step is far [rad].
pub(crate) const FAR_TURN: f32 = 0.25;

/// What a line needs between sweeps.
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
    /// An impact may change its velocity in this step, so what free rotation would do to that from its
    /// start is not known: nothing of it is left in `add_w`.
    pub(crate) calm: bool,
    /// The line holds the body at the step's end: velocity, angular velocity (`before_w` what rounding took
    /// from it), center, rotation.
    pub(crate) ended: bool,
    /// How fast overlaps that are parted move the body in this step [m/s].
    pub(crate) parting: f32,
}

/// A line's velocity with the carried impulses, and before them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Carried {
    v: [[f32; 4]; 2],
    w: [[f32; 4]; 2],
}

impl Aux {
    /// Takes the impulses that are carried from the last substep out of a line's velocity.
    pub(crate) fn lift(&self, line: &mut SolverBody) -> Carried {
        let carried = Carried { v: [line.v, self.before_v], w: [line.w, self.before_w] };
        (line.v, line.w) = (self.before_v, self.before_w);
        carried
    }

    /// Puts them back: exactly what was there if nothing struck the line.
    pub(crate) fn put_back(&self, line: &mut SolverBody, carried: &Carried) {
        let Carried { v: [v, before_v], w: [w, before_w] } = carried;
        for i in 0..4 {
            line.v[i] = v[i] + (self.before_v[i] - before_v[i]);
            line.w[i] = w[i] + (self.before_w[i] - before_w[i]);
        }
    }

    /// Leaves free rotation out of the rest of the step, of a body that turns far in it.
    pub(crate) fn calm(&mut self, whitening: &Whitening, body: &Body, dt: f32, h: f32) {
        self.calm = true;
        if body.w.length_squared() * (dt * dt) > FAR_TURN * FAR_TURN {
            self.add_w = four(whitening.s().mul(body.torque + body.step_torque) * h);
        }
    }

    /// What turns on its own has no part of free rotation in its velocity: a torque [N m, world] alone changes that.
    pub(crate) fn turn_by_torque(&mut self, whitening: &Whitening, body: &Body, h: f32) {
        self.add_w = four(whitening.s().mul(body.torque + body.step_torque) * h);
    }

    /// The line carries no impulses to the next substep.
    pub(crate) fn start_anew(&mut self, line: &SolverBody) {
        (self.before_v, self.before_w) = (line.v, line.w);
    }

    /// Takes impulses, times their scales, out of what is carried to the next substep.
    #[inline]
    pub(crate) fn begin_later(&mut self, v: &[f32; 4], scale_v: f32, w: &[f32; 4], scale_w: f32) {
        for i in 0..4 {
            self.before_v[i] += v[i] * scale_v;
            self.before_w[i] += w[i] * scale_w;
        }
    }

    /// Puts the end of the step of a body in its line, and what rounding took from its angular velocity.
    pub(crate) fn put_end(&mut self, line: &mut SolverBody, end: &BodyState, w_rest: Vec3) {
        (line.v, line.w) = (four(end.v), four(end.w));
        (line.x, line.t) = (four(end.center), end.rotation.to_array());
        (self.before_w, self.ended) = (four(w_rest), true);
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

    /// Notes how fast overlaps that are parted move the body [m/s].
    pub(crate) const fn parts_at(&mut self, speed: f32) {
        self.parting = speed;
    }

    /// See [`Self::parts_at`].
    pub(crate) const fn parting(&self) -> f32 {
        self.parting
    }

    /// The square of what forces add to the whitened velocity in a substep.
    pub(crate) const fn kick(&self) -> f32 {
        let [x, y, z, _] = self.add_v;
        x * x + y * y + z * z
    }

    /// True if a translation is locked.
    pub(crate) fn is_locked(&self) -> bool {
        self.locked != [false; 3]
    }

    /// An impact on the line; no impulse that the next substep repeats.
    #[inline]
    pub(crate) fn strike(&mut self, line: &mut SolverBody, dv: Vec3, dw: Vec3) {
        let (dv, dw) = (four(dv), four(dw));
        for i in 0..4 {
            line.v[i] += dv[i];
            line.w[i] += dw[i];
            self.before_v[i] += dv[i];
            self.before_w[i] += dw[i];
        }
    }

    /// True if nothing but forces and damping moved the body's center in `substeps` substeps of `h`. (Every
    /// impulse of a row does.)
    pub(crate) fn flew(&self, line: &SolverBody, start: [f32; 4], substeps: u32, h: f32) -> bool {
        let (mut v, mut x) = (start, [0.0; 4]);
        for _ in 0..substeps {
            for i in 0..4 {
                v[i] = (v[i] + self.add_v[i]) * self.decay_v;
                x[i] += h * v[i];
            }
        }
        (0..4).all(|i| same(v[i], line.v[i]) && same(x[i], line.x[i]))
    }

    /// Takes locked translations out.
    pub(crate) fn hold_locked(&self, line: &mut SolverBody) {
        for i in 0..3 {
            if self.locked[i] {
                line.v[i] = 0.0;
            }
        }
    }
}

/// The same number: what two equal computations give.
#[expect(clippy::float_cmp, reason = "whether anything at all was added")]
pub(crate) fn same(a: f32, b: f32) -> bool {
    a == b
}
