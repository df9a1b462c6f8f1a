//! The contact problem solved to a tolerance: velocities after which nothing approaches, nothing that parts
//! pushes, and friction takes the most energy that its cone allows [Baraff94].
//!
//! Unknown are the velocities, not the impulses: four corners of a face share a load in no unique way, and the
//! matrix of impulses is singular. Coulomb's law is written as complementarity of two cones [DeSaxce98]: with
//! K = {|λ_t| ≤ μ λ_n}, λ lies in K, ũ = (u_n - u* + μ |u_t|, u_t) in its dual, and λ · ũ = 0. With s = μ |u_t| of the
//! last round that is a convex problem [Cadoux09], and with λ of the last round and a stiffness ρ its velocities
//! are the least of
//!
//! `½ |v - v₀|²_M + Σ ½/ρ |P(λ - ρ (u - u* n + s n))|²`, P onto K
//!
//! which Newton's method with a line search finds; the next λ is that projection, as in the augmented
//! Lagrangian [Alart91]. Where rounds do not settle, slips are unknowns like the velocities (`implicit`). Sweeps alone take the fourth power of the height of a column (19,000 a step for ten
//! cubes); some ten rounds do here.

mod budget;
mod implicit;
mod mixing;
mod skyline;

use self::budget::{Budget, POINT_LOOK, POINT_SOLVE, POINT_SWEEP};
use self::implicit::Whole;
use self::mixing::Mixing;
use self::skyline::{SIX, Skyline};
use super::rows::{Mover, Pair};
use super::turns::Turns;
use crate::base::double::{DVec3, greater};
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;

/// Residual at which it ends: the greatest change of velocity that a point alone would still make, as a part
/// of the greatest speed of a contact point before, or of what forces add in a substep.
pub(crate) const TOLERANCE: f64 = 1.0e-6;

/// Rounds after which it gives up; steps of Newton's method in one; halvings of such a step.
const ROUNDS: u32 = 40;

const NEWTON: u32 = 60;

const HALVINGS: u32 = 30;

/// Stiffness ρ of the first round, over the effective mass, and its limits.
const STIFFNESS: f64 = 1.0e4;

const MOST_STIFFNESS: f64 = 1.0e6;

const LEAST_STIFFNESS: f64 = 1.0;

/// Sweeps over the points of a scene that is too large for the direct solve, and before rounds start anew.
const SWEEPS: u32 = 500;

const RESTARTS: [u32; 6] = [100, 100, 300, 300, 3000, 3000];

/// Part of an overlap that is removed in a substep, and overlap that is left alone [m].
const BAUMGARTE: f64 = 0.2;

pub(crate) const SLOP: f64 = 5.0e-3;

/// How it ended.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outcome {
    /// Direct solves, or sweeps.
    pub(crate) sweeps: u32,
    /// Relative residual.
    pub(crate) residual: f64,
    /// There were sweeps only: a direct solve would have been too much work.
    pub(crate) too_large: bool,
}

/// A direction of a point in whitened velocities, y with v = v₁ + W y and W Wᵀ = M⁻¹: its row is also its
/// response. One part a body.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    d: DVec3,
    g: [[f64; SIX]; 2],
    /// Velocity along it for y = 0.
    u: f64,
    impulse: f64,
}

/// A point: normal and two tangents.
#[derive(Clone, Debug)]
struct Point {
    pair: u32,
    index: usize,
    /// Movers less the fixed one; what has no unknowns is out of range.
    bodies: [u32; 2],
    rows: [Row; 3],
    /// K of the normal, and of the tangents.
    normal: f64,
    tangent: [f64; 2],
    friction: [f64; 2],
    /// Relative velocity along the normal that is asked for at least [m/s].
    target: f64,
    /// Coefficient of friction and s in this round.
    mu: f64,
    slip: f64,
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Analytic {
    points: Vec<Point>,
    /// Roots of inverse masses and inertias: v = roots.0 y, w = roots.1 y.
    roots: Vec<(DVec3, [DVec3; 3])>,
    /// Whitened velocities: of now, without impulses, and the step to the next.
    y: Vec<[f64; SIX]>,
    free: Vec<[f64; SIX]>,
    step: Vec<[f64; SIX]>,
    downhill: Vec<[f64; SIX]>,
    trial: Vec<[f64; SIX]>,
    flat: Vec<f64>,
    matrix: Skyline,
    slips: Vec<f64>,
    changes: Vec<f64>,
    mixing: Mixing,
    whole: Whole,
    budget: Budget,
}

impl Analytic {
    /// A step begins in which it is asked so often.
    pub(crate) const fn begin_step(&mut self, solves: u32) {
        self.budget = Budget::of_step(solves);
    }

    /// Solves for the velocities at the end of a substep of `h`. `slop`: overlaps are removed by velocity, down to this [m]; ∞: none.
    pub(crate) fn solve(
        &mut self,
        turns: &Turns,
        h: f32,
        slop: f64,
        movers: &mut [Mover],
        pairs: &mut [Pair],
    ) -> Outcome {
        self.gather(turns, h, slop, movers, pairs);
        self.budget.begin(self.points.len());
        let scale = self.points.iter().map(Point::speed).fold(0.0, f64::max);
        // At rest the impulses of the last step have taken the speed away already.
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

    /// With friction there may be several solutions, and the rounds may circle between two, creep towards one
    /// that is far or be driven away from one: then slips become unknowns too, and where that fails as well,
    /// sweeps choose another neighborhood, from here and from nothing.
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
            // Direct solves are what is counted.
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
        for _ in 0..ROUNDS {
            if !self.budget.allows(POINT_SWEEP, 0.0) {
                break;
            }
            self.set_slips();
            let (solves, left) = self.minimize(stiffness, 0.01 * TOLERANCE * scale);
            outcome.sweeps += solves;
            if !(left <= 0.1 * TOLERANCE * scale) && stiffness > LEAST_STIFFNESS {
                // Rounding, at this stiffness, which would be as many times in the impulses.
                stiffness *= 0.1;
                continue;
            }
            for p in &mut self.points {
                let next = p.projected(&self.y, stiffness);
                for (row, impulse) in p.rows.iter_mut().zip(next) {
                    row.impulse = impulse;
                }
            }
            // Momentum to the last digit, whatever Newton's method left.
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
                stiffness = (10.0 * stiffness).min(MOST_STIFFNESS);
            }
        }
        if outcome.residual.is_infinite() {
            // No round came to its end.
            outcome.residual = self.residual() / scale;
        }
        outcome
    }

    /// s of the next round.
    fn set_slips(&mut self) {
        let Self { points, y, slips, changes, .. } = self;
        slips.clear();
        changes.clear();
        for p in &mut *points {
            // Sticking friction holds what does not slide, kinetic friction what does.
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

    /// Newton's method on the convex function of a round. Returns the number of direct solves, and the
    /// greatest change of a point's velocity [m/s] that was still to be made before the last one.
    fn minimize(&mut self, stiffness: f64, tolerance: f64) -> (u32, f64) {
        let mut left = f64::INFINITY;
        for solves in 0..NEWTON {
            if !self.budget.allows(POINT_SOLVE, self.matrix.work()) {
                return (solves, left);
            }
            let Self { points, y, free, step, downhill, trial, flat, matrix, budget, .. } = self;
            // Downhill: what impulses would do, less what was done.
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

    /// Projected Gauss-Seidel, there and back.
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

    fn gather(&mut self, turns: &Turns, h: f32, slop: f64, movers: &[Mover], pairs: &[Pair]) {
        self.roots.clear();
        self.roots.extend(movers.iter().map(|m| {
            let root = |x: f32| f64::from(x.max(0.0)).sqrt();
            let i = m.inv_mass;
            (DVec3 { x: root(i.x), y: root(i.y), z: root(i.z) }, lower_root(&m.inv_inertia))
        }));
        self.points.clear();
        let h = f64::from(h);
        for row in &turns.pairs {
            let pair = &pairs[*row as usize];
            let sides = [&movers[pair.a as usize], &movers[pair.b as usize]];
            let roots = [&self.roots[pair.a as usize], &self.roots[pair.b as usize]];
            let t1 = pair.normal.any_perpendicular();
            let directions = [pair.normal, t1, t1.cross(pair.normal)];
            for (index, q) in pair.points().iter().enumerate() {
                // What the impulses of the last step are, the velocities have already.
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
            list.resize(n, [0.0; SIX]);
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

/// A lower triangle L with L Lᵀ of this matrix, by columns; zero where that is.
fn lower_root(m: &Sym3) -> [DVec3; 3] {
    let [xx, yy, zz] = [m.xx, m.yy, m.zz].map(f64::from);
    let [xy, xz, yz] = [m.xy, m.xz, m.yz].map(f64::from);
    let pivot = |d: f64, of: f64| if d > 1.0e-9 * of { d.sqrt() } else { 0.0 };
    let over = |x: f64, pivot: f64| if pivot > 0.0 { x / pivot } else { 0.0 };
    let a = pivot(xx, xx);
    let (b, c) = (over(xy, a), over(xz, a));
    let d = pivot(yy - b * b, yy);
    let e = over(yz - b * c, d);
    let f = pivot(zz - c * c - e * e, zz);
    [DVec3 { x: a, y: b, z: c }, DVec3 { x: 0.0, y: d, z: e }, DVec3 { x: 0.0, y: 0.0, z: f }]
}

fn row_of(d: Vec3, arms: [Vec3; 2], roots: [&(DVec3, [DVec3; 3]); 2]) -> Row {
    let d = DVec3::from(d);
    let g = [(0, -1.0), (1, 1.0)].map(|(side, sign)| {
        let (linear, angular) = roots[side];
        let arm = DVec3::from(arms[side]).cross(d);
        let v = each(*linear, d);
        let [a, b, c] = angular.map(|column| column.dot(arm));
        [v.x, v.y, v.z, a, b, c].map(|x| x * sign)
    });
    Row { d, g, u: 0.0, impulse: 0.0 }
}

fn each(a: DVec3, b: DVec3) -> DVec3 {
    DVec3 { x: a.x * b.x, y: a.y * b.y, z: a.z * b.z }
}

fn dot(a: &[f64; SIX], b: &[f64; SIX]) -> f64 {
    let mut sum = 0.0;
    for i in 0..SIX {
        sum += a[i] * b[i];
    }
    sum
}

/// Change of velocity along one row by an impulse of 1 of another of the same point.
fn response(of: &Row, by: &Row) -> f64 {
    dot(&of.g[0], &by.g[0]) + dot(&of.g[1], &by.g[1])
}

/// What a change of whitened velocities is along a row.
fn along(row: &Row, bodies: [u32; 2], y: &[[f64; SIX]]) -> f64 {
    let part = |side: usize| y.get(bodies[side] as usize).map_or(0.0, |y| dot(&row.g[side], y));
    part(0) + part(1)
}

fn inner(a: &[[f64; SIX]], b: &[[f64; SIX]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| dot(a, b)).sum()
}

/// The convex function of a round.
fn height(points: &[Point], y: &[[f64; SIX]], free: &[[f64; SIX]], stiffness: f64) -> f64 {
    let mut sum = 0.0;
    for (y, free) in y.iter().zip(free) {
        for i in 0..SIX {
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

/// The nearest of K.
fn onto_cone(mu: f64, [n, x, z]: [f64; 3]) -> [f64; 3] {
    let size = (x * x + z * z).sqrt();
    if size <= mu * n {
        return [n, x, z];
    }
    if mu * size <= -n {
        return [0.0; 3];
    }
    let n = (n + mu * size) / (1.0 + mu * mu);
    [n, mu * n * x / size, mu * n * z / size]
}

impl Point {
    fn velocities(&self, y: &[[f64; SIX]]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.rows[i].u + along(&self.rows[i], self.bodies, y))
    }

    /// Speed of the point before, in the fastest direction.
    fn speed(&self) -> f64 {
        self.rows.iter().map(|r| r.u.abs()).fold(0.0, f64::max)
    }

    /// What is projected, and the stiffness.
    fn reach(&self, y: &[[f64; SIX]], stiffness: f64) -> ([f64; 3], f64) {
        let rho = stiffness / greater(self.normal, greater(self.tangent[0], self.tangent[1]));
        let [n, t1, t2] = self.velocities(y);
        let i = self.rows.map(|r| r.impulse);
        ([i[0] - rho * (n - self.target + self.slip), i[1] - rho * t1, i[2] - rho * t2], rho)
    }

    /// The impulses of the round for these velocities.
    fn projected(&self, y: &[[f64; SIX]], stiffness: f64) -> [f64; 3] {
        onto_cone(self.mu, self.reach(y, stiffness).0)
    }

    /// Adds what impulses do.
    fn push(&self, impulses: [f64; 3], y: &mut [[f64; SIX]]) {
        for side in 0..2 {
            let Some(y) = y.get_mut(self.bodies[side] as usize) else { continue };
            for (row, impulse) in self.rows.iter().zip(impulses) {
                for (y, g) in y.iter_mut().zip(&row.g[side]) {
                    *y += g * impulse;
                }
            }
        }
    }

    /// Adds the second derivatives of its part of the convex function.
    fn stiffen(&self, y: &[[f64; SIX]], stiffness: f64, matrix: &mut Skyline) {
        let (mu, ([n, x, z], rho)) = (self.mu, self.reach(y, stiffness));
        let size = (x * x + z * z).sqrt();
        if mu * size <= -n {
            return;
        }
        if size <= mu * n {
            self.rows.iter().for_each(|row| matrix.add(rho, self.bodies, &row.g));
            return;
        }
        // Along the edge of the cone that is near, and around the cone.
        let (c, s) = (x / size, z / size);
        matrix.add(rho / (1.0 + mu * mu), self.bodies, &self.combined([1.0, mu * c, mu * s]));
        let around = mu * (n + mu * size) / ((1.0 + mu * mu) * size);
        if around > 0.0 {
            matrix.add(rho * around, self.bodies, &self.combined([0.0, -s, c]));
        }
    }

    fn combined(&self, parts: [f64; 3]) -> [[f64; SIX]; 2] {
        let mut g = [[0.0; SIX]; 2];
        for (row, part) in self.rows.iter().zip(parts) {
            for side in 0..2 {
                for i in 0..SIX {
                    g[side][i] += part * row.g[side][i];
                }
            }
        }
        g
    }

    /// The impulses it would have were all others as they are, by how much that changes its velocity, and the
    /// coefficient of friction that limits it.
    fn alone(&self, y: &[[f64; SIX]]) -> ([f64; 3], f64, f64) {
        let now = self.rows.map(|r| r.impulse);
        let (mut u, [a, d]) = (self.velocities(y), self.tangent);
        let press = (now[0] - (u[0] - self.target) / self.normal).max(0.0);
        let change = (press - now[0]).abs() * self.normal;
        // One stiffness along the whole surface, at least the greatest: with the matrix of both directions
        // friction would not be against the slide where they answer differently.
        let k = a + d;
        if !(k > 0.0) {
            return ([press, now[1], now[2]], change, 0.0);
        }
        for i in 1..3 {
            u[i] += (press - now[0]) * response(&self.rows[i], &self.rows[0]);
        }
        let (mut x, mut z) = (now[1] - u[1] / k, now[2] - u[2] / k);
        let [hold, slide] = self.friction;
        let size = (x * x + z * z).sqrt();
        let slides = size > hold * press;
        if slides {
            (x, z) = (x * (slide * press / size), z * (slide * press / size));
        }
        let change = greater(change, k * greater((x - now[1]).abs(), (z - now[2]).abs()));
        ([press, x, z], change, if slides { slide } else { hold })
    }
}
