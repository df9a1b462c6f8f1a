//! Solves for velocities with slips as unknowns, where the analytic method's rounds over slips do
//! not converge. A solution from which the rounds diverge may still be regular, and Newton's method
//! finds it from nearby.
//!
//! `y - y₀ - Σ Gᵀ P(λ - ρ (u - u* n + μ |u_t| n)) = 0`, u = G y + u₀ [Alart91]
//!
//! Friction is not the derivative of any energy, so the matrix is not symmetric and is stored in
//! full.

use super::budget::{POINT_LOOK, POINT_SOLVE, POINT_SWEEP};
use super::skyline::SIX_DOF;
use super::{Analytic, MIN_STIFFNESS, Outcome, Point, STIFFNESS, TOLERANCE, along, onto_cone};

/// Limits: rounds of impulses, Newton steps in a round, halvings of such a step.
const MAX_ROUNDS: u32 = 12;

const NEWTON: u32 = 40;

const HALVINGS: u32 = 12;

/// Maximum number of unknowns: a factorization of a tenth of a second.
const MAX_UNKNOWNS: usize = 600;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Whole {
    /// Stored by rows.
    matrix: Vec<f64>,
    /// Effect of the impulses less the present velocity change, and the Newton step from there.
    error: Vec<f64>,
    step: Vec<f64>,
    start: Vec<[f64; SIX_DOF]>,
}

impl Analytic {
    /// Runs Newton's method for velocities and slips together, from the current state.
    pub(crate) fn take_implicit(&mut self, scale: f64) -> Outcome {
        let mut outcome = Outcome { residual: self.residual() / scale, ..Outcome::default() };
        if SIX_DOF * self.y.len() > MAX_UNKNOWNS {
            return outcome;
        }
        let mut stiffness = STIFFNESS;
        self.whole.start.clone_from(&self.y);
        for _ in 0..MAX_ROUNDS {
            if !self.budget.allows(POINT_SWEEP, 0.0) {
                break;
            }
            for p in &mut self.points {
                p.mu = p.alone(&self.y).2;
            }
            let (solves, done) = self.settle(stiffness, 0.01 * TOLERANCE * scale);
            outcome.sweeps += solves;
            if !done && stiffness > MIN_STIFFNESS {
                stiffness *= 0.1;
                self.y.clone_from(&self.whole.start);
                continue;
            }
            let Self { points, y, free, .. } = self;
            for p in &mut *points {
                let next = pressed(p, y, stiffness);
                for (row, impulse) in p.rows.iter_mut().zip(next) {
                    row.impulse = impulse;
                }
            }
            y.clone_from(free);
            for p in &*points {
                p.push(p.rows.map(|r| r.impulse), y);
            }
            outcome.residual = self.residual() / scale;
            if outcome.residual <= TOLERANCE {
                break;
            }
        }
        outcome
    }

    /// Runs one round; returns the number of solves, and whether the velocities converged.
    fn settle(&mut self, stiffness: f64, tolerance: f64) -> (u32, bool) {
        // Work of a factorization without symmetry.
        #[expect(clippy::cast_precision_loss, reason = "at most 600")]
        let unknowns = (SIX_DOF * self.y.len()) as f64;
        for solves in 0..NEWTON {
            if !self.budget.allows(POINT_SOLVE, unknowns * unknowns * unknowns / 3.0) {
                return (solves, false);
            }
            let Self { points, y, free, trial, whole, step, budget, .. } = self;
            let error = whole.rate(points, y, free, stiffness);
            step.clone_from(y);
            for (s, e) in step.iter_mut().flatten().zip(&whole.error) {
                *s = *e;
            }
            let left = points
                .iter()
                .flat_map(|p| p.rows.map(|r| along(&r, p.bodies, step).abs()))
                .fold(0.0, f64::max);
            if left <= tolerance {
                return (solves, true);
            }
            whole.fill(points, y, stiffness);
            if !whole.solve() {
                return (solves, false);
            }
            let mut part = 1.0;
            let mut shrinks = false;
            for _ in 0..HALVINGS {
                trial.clone_from(y);
                for (t, s) in trial.iter_mut().flatten().zip(&whole.step) {
                    *t += part * s;
                }
                if whole.rate(points, trial, free, stiffness) <= (1.0 - 1.0e-4 * part) * error {
                    shrinks = true;
                    break;
                }
                if !budget.allows(POINT_LOOK, 0.0) {
                    break;
                }
                part *= 0.5;
            }
            if !shrinks {
                return (solves + 1, false);
            }
            core::mem::swap(y, trial);
        }
        (NEWTON, false)
    }
}

/// Argument of the projection, with the slip of these velocities; velocity along the surface;
/// stiffness.
fn reach(p: &Point, y: &[[f64; SIX_DOF]], stiffness: f64) -> ([f64; 3], [f64; 2], f64) {
    let ([n, a, b], rho) = p.reach(y, stiffness);
    let [_, x, z] = p.velocities(y);
    let slip = p.mu * (x * x + z * z).sqrt();
    ([n + rho * (p.slip - slip), a, b], [x, z], rho)
}

fn pressed(p: &Point, y: &[[f64; SIX_DOF]], stiffness: f64) -> [f64; 3] {
    onto_cone(p.mu, reach(p, y, stiffness).0)
}

/// Row of the first unknown of a body; none for a body that does not move.
fn first_row(body: u32, bodies: usize) -> Option<usize> {
    ((body as usize) < bodies).then_some(SIX_DOF * body as usize)
}

impl Whole {
    /// Writes the remaining error into `error` and returns its size.
    fn rate(
        &mut self,
        points: &[Point],
        y: &[[f64; SIX_DOF]],
        free: &[[f64; SIX_DOF]],
        stiffness: f64,
    ) -> f64 {
        self.error.clear();
        self.error.extend(free.iter().flatten().zip(y.iter().flatten()).map(|(f, y)| f - y));
        for p in points {
            let impulse = pressed(p, y, stiffness);
            for side in 0..2 {
                let Some(at) = first_row(p.bodies[side], y.len()) else { continue };
                let part = &mut self.error[at..at + SIX_DOF];
                for (row, j) in p.rows.iter().zip(impulse) {
                    for (e, g) in part.iter_mut().zip(&row.g[side]) {
                        *e += j * g;
                    }
                }
            }
        }
        self.error.iter().map(|e| e * e).sum::<f64>().sqrt()
    }

    /// Fills the matrix of the step: I + Σ Gᵀ P' ρ (1 + μ n tᵀ) G.
    fn fill(&mut self, points: &[Point], y: &[[f64; SIX_DOF]], stiffness: f64) {
        let n = self.error.len();
        self.matrix.clear();
        self.matrix.resize(n * n, 0.0);
        for i in 0..n {
            self.matrix[i * n + i] = 1.0;
        }
        for p in points {
            let (at, slide, rho) = reach(p, y, stiffness);
            let Some(slope) = slope_of_cone(p.mu, at) else { continue };
            let speed = (slide[0] * slide[0] + slide[1] * slide[1]).sqrt();
            let along = if speed > 0.0 { slide.map(|x| p.mu * x / speed) } else { [0.0; 2] };
            let weight = slope.map(|row| {
                [
                    rho * row[0],
                    rho * (row[1] + row[0] * along[0]),
                    rho * (row[2] + row[0] * along[1]),
                ]
            });
            for by in 0..2 {
                let Some(column) = first_row(p.bodies[by], y.len()) else { continue };
                let mut through = [[0.0; SIX_DOF]; 3];
                for (to, w) in through.iter_mut().zip(&weight) {
                    for (row, w) in p.rows.iter().zip(w) {
                        for (t, g) in to.iter_mut().zip(&row.g[by]) {
                            *t += w * g;
                        }
                    }
                }
                for of in 0..2 {
                    let Some(first) = first_row(p.bodies[of], y.len()) else { continue };
                    for i in 0..SIX_DOF {
                        let line = &mut self.matrix[(first + i) * n + column..][..SIX_DOF];
                        for (row, through) in p.rows.iter().zip(&through) {
                            let g = row.g[of][i];
                            for (value, t) in line.iter_mut().zip(through) {
                                *value += g * t;
                            }
                        }
                    }
                }
            }
        }
    }

    /// Gaussian elimination with row pivots: computes `step` from `error`. False if a pivot is
    /// zero.
    fn solve(&mut self) -> bool {
        let Self { matrix, error, step, .. } = self;
        let n = error.len();
        step.clone_from(error);
        for k in 0..n {
            let mut best = k;
            for i in k + 1..n {
                if matrix[i * n + k].abs() > matrix[best * n + k].abs() {
                    best = i;
                }
            }
            if best != k {
                let (upper, lower) = matrix.split_at_mut(best * n);
                upper[k * n..][..n].swap_with_slice(&mut lower[..n]);
                step.swap(best, k);
            }
            let (upper, lower) = matrix.split_at_mut((k + 1) * n);
            let row = &upper[k * n..];
            let pivot = row[k];
            if !(pivot.abs() > 0.0 && pivot.is_finite()) {
                return false;
            }
            for (i, other) in lower.chunks_exact_mut(n).enumerate() {
                let part = other[k] / pivot;
                if part != 0.0 {
                    for (x, y) in other[k..].iter_mut().zip(&row[k..]) {
                        *x -= part * y;
                    }
                    step[k + 1 + i] -= part * step[k];
                }
            }
        }
        for k in (0..n).rev() {
            let row = &matrix[k * n..][..n];
            let mut sum = step[k];
            for j in k + 1..n {
                sum -= row[j] * step[j];
            }
            step[k] = sum / row[k];
        }
        step.iter().all(|x| x.is_finite())
    }
}

/// Derivatives of the projection onto the cone; `None` where it is constant.
fn slope_of_cone(mu: f64, [n, x, z]: [f64; 3]) -> Option<[[f64; 3]; 3]> {
    let size = (x * x + z * z).sqrt();
    if size <= mu * n {
        return Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }
    if mu * size <= -n {
        return None;
    }
    let (c, s) = (x / size, z / size);
    let share = 1.0 / (1.0 + mu * mu);
    let around = mu * (n + mu * size) * share / size;
    let edge = [1.0, mu * c, mu * s];
    let turn = [0.0, -s, c];
    let mut slope = [[0.0; 3]; 3];
    for (i, row) in slope.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            *value = share * edge[i] * edge[j] + around * turn[i] * turn[j];
        }
    }
    Some(slope)
}
