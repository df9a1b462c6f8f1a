//! Solves the contact problem to a tolerance. At the resulting velocities nothing approaches,
//! separating points have no impulse, and friction dissipates the maximum energy that its cone
//! allows [Baraff94].
//!
//! The unknowns are the velocities, not the impulses: four corners of a face share a load in no
//! unique way, so the matrix of impulses is singular. Coulomb's law is written as complementarity
//! of two cones [DeSaxce98]. With K = {|λ_t| ≤ μ λ_n}, λ lies in K, ũ = (u_n - u* + μ |u_t|, u_t)
//! in its dual, and λ · ũ = 0. With s = μ |u_t| of the last round the problem is convex [Cadoux09].
//! With λ of the last round and a stiffness ρ, its velocities minimize
//!
//! `½ |v - v₀|²_M + Σ ½/ρ |P(λ - ρ (u - u* n + s n))|²`, P onto K
//!
//! by Newton's method with a line search. The next λ is that projection, as in the augmented
//! Lagrangian [Alart91]. If the rounds do not converge, slips become unknowns like the velocities
//! (`implicit`). Sweeps alone need the fourth power of a column's height (19,000 per step for ten
//! cubes); here some ten rounds suffice.

mod budget;
mod implicit;
mod mixing;
mod rows;
mod skyline;

use self::budget::{Budget, POINT_LOOK, POINT_SOLVE, POINT_SWEEP};
use self::implicit::Whole;
use self::mixing::Mixing;
use self::skyline::{SIX_DOF, Skyline};
use super::rows::{Mover, Pair};
use super::sequence::Sequence;
use crate::base::double::{DVec3, greater};
use crate::step::classic::analytic::rows::{
    Point, along, each, inner, lower_root, onto_cone, response, row_of,
};

/// Residual at which the solve ends: the maximum change of velocity that one point alone would
/// still make. It is relative to the maximum initial speed of a contact point, or to the speed that
/// forces add in a substep.
pub(crate) const TOLERANCE: f64 = 1.0e-6;

/// Limits: rounds; Newton steps in a round; halvings of such a step.
const MAX_ROUNDS: u32 = 40;

const NEWTON: u32 = 60;

const HALVINGS: u32 = 30;

/// Stiffness ρ of the first round, relative to the effective mass, and its limits.
const STIFFNESS: f64 = 1.0e4;

const MAX_STIFFNESS: f64 = 1.0e6;

const MIN_STIFFNESS: f64 = 1.0;

/// Sweeps over the points of a scene that is too large for the direct solve, and sweeps before each
/// restart of the rounds.
const SWEEPS: u32 = 500;

const RESTARTS: [u32; 6] = [100, 100, 300, 300, 3000, 3000];

/// Part of an overlap that is removed in a substep, and overlap that is left uncorrected [m].
const BAUMGARTE: f64 = 0.2;

pub(crate) const SLOP: f64 = 5.0e-3;

/// Result of a solve.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outcome {
    /// Number of direct solves, or of sweeps.
    pub(crate) sweeps: u32,
    /// Relative residual.
    pub(crate) residual: f64,
    /// The solve used sweeps only, because a direct solve would be too expensive.
    pub(crate) too_large: bool,
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Analytic {
    points: Vec<Point>,
    /// Roots of inverse masses and inertias: v = roots.0 y, w = roots.1 y.
    roots: Vec<(DVec3, [DVec3; 3])>,
    /// Whitened velocities: the current ones, those without impulses, and the step to the next.
    y: Vec<[f64; SIX_DOF]>,
    free: Vec<[f64; SIX_DOF]>,
    step: Vec<[f64; SIX_DOF]>,
    downhill: Vec<[f64; SIX_DOF]>,
    trial: Vec<[f64; SIX_DOF]>,
    flat: Vec<f64>,
    matrix: Skyline,
    slips: Vec<f64>,
    changes: Vec<f64>,
    mixing: Mixing,
    whole: Whole,
    budget: Budget,
}

impl Analytic {
    /// Begins a step with this number of solves.
    pub(crate) const fn begin_step(&mut self, solves: u32) {
        self.budget = Budget::of_step(solves);
    }

    /// Solves for the velocities at the end of a substep of `h`. `slop`: velocity removes overlaps
    /// down to this [m]; ∞: none.
    pub(crate) fn solve(
        &mut self,
        sequence: &Sequence,
        h: f32,
        slop: f64,
        movers: &mut [Mover],
        pairs: &mut [Pair],
    ) -> Outcome {
        self.gather(sequence, h, slop, movers, pairs);
        self.budget.begin(self.points.len());
        let scale = self.points.iter().map(Point::speed).fold(0.0, f64::max);
        // At rest the impulses of the last step have already cancelled the speed that forces add.
        let force = |m: &Mover| DVec3::from(m.add_v).length();
        let scale = movers.iter().map(force).fold(scale, f64::max);
        if self.points.is_empty() || !(scale > 0.0 && scale.is_finite()) {
            return Outcome::default();
        }
        let Self { points, matrix, y, .. } = self;
        let n = y.len();
        let moves = |i: u32| (i as usize) < n;
        let couplings = points.iter().map(|p| (p.bodies[0], p.bodies[1]));
        let outcome = if matrix.shape(n, couplings.filter(|(a, b)| moves(*a) && moves(*b))) {
            self.search(scale)
        } else {
            Outcome { too_large: true, ..self.take_sweeps(SWEEPS, scale) }
        };
        self.hand_back(movers, pairs);
        outcome
    }

    /// With friction there may be several solutions. The rounds may circle between two, creep
    /// towards a distant one or diverge from one. Then slips become unknowns too. If that fails as
    /// well, sweeps choose another starting point, from the current state and from zero impulses.
    fn search(&mut self, scale: f64) -> Outcome {
        let mut outcome = Outcome::default();
        let mut add = |next: Outcome| {
            outcome.residual = next.residual;
            outcome.sweeps += next.sweeps;
            next.residual <= TOLERANCE
        };
        if add(self.take_rounds(scale)) || add(self.take_implicit(scale)) {
            return outcome;
        }
        for (i, sweeps) in RESTARTS.into_iter().enumerate() {
            if i % 2 == 1 {
                self.y.clone_from(&self.free);
                self.points.iter_mut().flat_map(|p| &mut p.rows).for_each(|r| r.impulse = 0.0);
            }
            let swept = self.take_sweeps(sweeps, scale);
            // Only direct solves are counted.
            if add(Outcome { sweeps: 0, ..swept })
                || !self.budget.allows(0.0, 0.0)
                || add(self.take_implicit(scale))
                || add(self.take_rounds(scale))
            {
                break;
            }
        }
        outcome
    }

    fn take_rounds(&mut self, scale: f64) -> Outcome {
        let mut outcome = Outcome { residual: f64::INFINITY, ..Outcome::default() };
        let mut stiffness = STIFFNESS;
        self.mixing.forget();
        for _ in 0..MAX_ROUNDS {
            if !self.budget.allows(POINT_SWEEP, 0.0) {
                break;
            }
            self.set_slips();
            let (solves, left) = self.minimize(stiffness, 0.01 * TOLERANCE * scale);
            outcome.sweeps += solves;
            if !(left <= 0.1 * TOLERANCE * scale) && stiffness > MIN_STIFFNESS {
                // Reduce a stiffness at which only rounding error is left: the impulses would have
                // that error times the stiffness.
                stiffness *= 0.1;
                continue;
            }
            for p in &mut self.points {
                let next = p.projected(&self.y, stiffness);
                for (row, impulse) in p.rows.iter_mut().zip(next) {
                    row.impulse = impulse;
                }
            }
            // Recompute velocities from the impulses, so that momentum is exact to rounding despite
            // the tolerance of Newton's method.
            self.y.clone_from(&self.free);
            for p in &self.points {
                p.push(p.rows.map(|r| r.impulse), &mut self.y);
            }
            let before = outcome.residual;
            outcome.residual = self.residual() / scale;
            if outcome.residual <= TOLERANCE {
                break;
            }
            if outcome.residual > 0.5 * before {
                stiffness = (10.0 * stiffness).min(MAX_STIFFNESS);
            }
        }
        if outcome.residual.is_infinite() {
            // No round was completed.
            outcome.residual = self.residual() / scale;
        }
        outcome
    }

    /// Sets s for the next round.
    fn set_slips(&mut self) {
        let Self { points, y, slips, changes, .. } = self;
        slips.clear();
        changes.clear();
        for p in &mut *points {
            // A point that does not slide has static friction, a sliding one kinetic friction.
            p.mu = p.alone(y).2;
            let [_, x, z] = p.velocities(y);
            slips.push(p.slip);
            changes.push(p.mu * (x * x + z * z).sqrt() - p.slip);
        }
        self.mixing.advance(slips, changes);
        for (p, slip) in points.iter_mut().zip(slips) {
            p.slip = greater(*slip, 0.0);
        }
    }

    fn residual(&self) -> f64 {
        self.points.iter().map(|p| p.alone(&self.y).1).fold(0.0, f64::max)
    }

    /// Runs Newton's method on the convex function of a round. Returns the number of direct solves,
    /// and the maximum velocity change of a point before the last one [m/s].
    fn minimize(&mut self, stiffness: f64, tolerance: f64) -> (u32, f64) {
        let mut left = f64::INFINITY;
        for solves in 0..NEWTON {
            if !self.budget.allows(POINT_SOLVE, self.matrix.work()) {
                return (solves, left);
            }
            let Self { points, y, free, step, downhill, trial, flat, matrix, budget, .. } = self;
            // Descent direction: the effect of the projected impulses, less the present velocity
            // change.
            step.clone_from(free);
            for p in &*points {
                p.push(p.projected(y, stiffness), step);
            }
            for (s, y) in step.iter_mut().flatten().zip(y.iter().flatten()) {
                *s -= y;
            }
            let error = points.iter().flat_map(|p| p.rows.map(|r| along(&r, p.bodies, step).abs()));
            left = error.fold(0.0, f64::max);
            if left <= tolerance {
                return (solves, left);
            }
            matrix.reset();
            for p in &*points {
                p.stiffen(y, stiffness, matrix);
            }
            downhill.clone_from(step);
            if !matrix.solve(step, flat) {
                return (solves, left);
            }
            let slope = -inner(downhill, step);
            let value = height(points, y, free, stiffness);
            let mut part = 1.0;
            for _ in 0..HALVINGS {
                trial.clone_from(y);
                for (t, s) in trial.iter_mut().flatten().zip(step.iter().flatten()) {
                    *t += part * s;
                }
                let rounding = 1.0e-14 * value.abs();
                if height(points, trial, free, stiffness)
                    <= value + 1.0e-4 * part * slope + rounding
                {
                    break;
                }
                if !budget.allows(POINT_LOOK, 0.0) {
                    return (solves + 1, left);
                }
                part *= 0.5;
            }
            if part < 1.0e-9 {
                return (solves + 1, left);
            }
            core::mem::swap(y, trial);
        }
        (NEWTON, left)
    }

    /// Projected Gauss-Seidel, alternately forward and backward.
    fn take_sweeps(&mut self, sweeps: u32, scale: f64) -> Outcome {
        let mut done = 0;
        for sweep in 0..sweeps {
            if !self.budget.allows(POINT_SWEEP, 0.0) {
                break;
            }
            done += 1;
            let Self { points, y, .. } = self;
            let mut visit = |p: &mut Point| {
                let (next, ..) = p.alone(y);
                let change = [0, 1, 2].map(|i| next[i] - p.rows[i].impulse);
                p.push(change, y);
                for (row, impulse) in p.rows.iter_mut().zip(next) {
                    row.impulse = impulse;
                }
            };
            if sweep % 2 == 0 {
                points.iter_mut().for_each(&mut visit);
            } else {
                points.iter_mut().rev().for_each(&mut visit);
            }
        }
        Outcome { sweeps: done, residual: self.residual() / scale, too_large: false }
    }

    fn gather(&mut self, sequence: &Sequence, h: f32, slop: f64, movers: &[Mover], pairs: &[Pair]) {
        self.roots.clear();
        self.roots.extend(movers.iter().map(|m| {
            let root = |x: f32| f64::from(x.max(0.0)).sqrt();
            let i = m.inv_mass;
            (DVec3 { x: root(i.x), y: root(i.y), z: root(i.z) }, lower_root(&m.inv_inertia))
        }));
        self.points.clear();
        let h = f64::from(h);
        for row in &sequence.pairs {
            let pair = &pairs[*row as usize];
            let sides = [&movers[pair.a as usize], &movers[pair.b as usize]];
            let roots = [&self.roots[pair.a as usize], &self.roots[pair.b as usize]];
            let t1 = pair.normal.any_perpendicular();
            let directions = [pair.normal, t1, t1.cross(pair.normal)];
            for (index, q) in pair.points().iter().enumerate() {
                // The velocities already contain the impulses of the last step.
                let impulses = pair.normal * q.press + q.rub;
                let rows = directions.map(|d| {
                    let arms = [q.r_a, q.r_b];
                    let mut row = row_of(d, arms, roots);
                    row.impulse = row.d.dot(impulses.into());
                    let velocity = |side: usize| -> DVec3 {
                        let (m, r) = (sides[side], DVec3::from(arms[side]));
                        DVec3::from(m.v) + DVec3::from(m.w).cross(r)
                    };
                    row.u = row.d.dot(velocity(1) - velocity(0) + pair.belt.into());
                    row
                });
                let k = |i: usize, j: usize| response(&rows[i], &rows[j]);
                if !(k(0, 0) > 0.0) {
                    continue;
                }
                let s = f64::from(pair.separation(q, movers));
                let bounce = -f64::from(pair.restitution) * f64::from(q.arrival);
                let target = if bounce > 0.0 {
                    bounce
                } else if s > 0.0 {
                    -s / h
                } else if slop < f64::INFINITY {
                    -BAUMGARTE / h * (s + slop).min(0.0)
                } else {
                    0.0
                };
                self.points.push(Point {
                    pair: *row,
                    index,
                    bodies: [pair.a.wrapping_sub(1), pair.b.wrapping_sub(1)],
                    normal: k(0, 0),
                    tangent: [k(1, 1), k(2, 2)],
                    rows,
                    friction: pair.friction.map(f64::from),
                    target,
                    mu: 0.0,
                    slip: 0.0,
                });
            }
        }
        let n = movers.len().saturating_sub(1);
        for list in [&mut self.y, &mut self.free] {
            list.clear();
            list.resize(n, [0.0; SIX_DOF]);
        }
        for p in &self.points {
            p.push(p.rows.map(|r| -r.impulse), &mut self.free);
        }
    }

    fn hand_back(&self, movers: &mut [Mover], pairs: &mut [Pair]) {
        for ((mover, (linear, angular)), y) in
            movers.iter_mut().zip(&self.roots).skip(1).zip(&self.y)
        {
            let [a, b, c, p, q, r] = *y;
            let v = each(*linear, DVec3 { x: a, y: b, z: c });
            let w = angular[0] * p + angular[1] * q + angular[2] * r;
            (mover.v, mover.w) =
                ((DVec3::from(mover.v) + v).single(), (DVec3::from(mover.w) + w).single());
        }
        for p in &self.points {
            let pair = &mut pairs[p.pair as usize];
            let [n, t1, t2] = &p.rows;
            let q = &mut pair.points[p.index];
            #[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
            let press = n.impulse as f32;
            q.press = press;
            q.rub = (t1.d * t1.impulse + t2.d * t2.impulse).single();
            pair.pressed |= press > 0.0;
            for body in [pair.a, pair.b] {
                movers[body as usize].pushed |= press > 0.0;
            }
        }
    }
}

/// The convex function of a round.
fn height(points: &[Point], y: &[[f64; SIX_DOF]], free: &[[f64; SIX_DOF]], stiffness: f64) -> f64 {
    let mut sum = 0.0;
    for (y, free) in y.iter().zip(free) {
        for i in 0..SIX_DOF {
            sum += 0.5 * (y[i] - free[i]) * (y[i] - free[i]);
        }
    }
    for p in points {
        let (reach, rho) = p.reach(y, stiffness);
        let [n, x, z] = onto_cone(p.mu, reach);
        sum += 0.5 * (n * n + x * x + z * z) / rho;
    }
    sum
}
