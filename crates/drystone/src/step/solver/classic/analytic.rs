//! The contact problem solved to a tolerance: velocities after which nothing approaches, nothing that parts
//! pushes, and friction takes the most energy that its cone allows [Baraff94].
//!
//! Sweeps of projected Gauss-Seidel, in double precision, find which points press, which of them stick, and
//! which way the others slide; with these known the problem is linear, and is solved directly; both take turns
//! until the residual is below the tolerance [Silcowitz10]. Sweeps alone take the fourth power of the height of a
//! column (19,000 a step for ten cubes). Four corners of a face have no unique impulses: the direct solve changes
//! as little as it can. Its matrix is dense: time goes with the cube of the points.

use super::rows::{Mover, Pair};
use super::sweeps::Turns;
use crate::base::double::DVec3;
use crate::base::math::Vec3;

/// Residual at which it ends: the greatest change of velocity that a visit of a row still asks for, as a part
/// of the greatest speed of a contact point before, or of what forces add in a substep.
pub(super) const TOLERANCE: f64 = 1.0e-6;

/// Sweeps between two direct solves, and rounds of both after which it gives up.
const SWEEPS: u32 = 16;
const ROUNDS: u32 = 100;

/// Most unknowns of a direct solve, 500 points that stick: a second. Beyond, there are sweeps only.
const MOST_UNKNOWNS: usize = 1500;

/// Added to the diagonal, as a part of it: without it four corners make the matrix singular, and as their gaps
/// are rounded they never ask for quite the same plane: impulses would grow by that over the ridge.
const RIDGE: f64 = 1.0e-5;

/// Part of an overlap that is removed in a substep, and overlap that is left alone [m].
const BAUMGARTE: f64 = 0.2;
const SLOP: f64 = 5.0e-3;

/// How it ended.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outcome {
    pub(super) sweeps: u32,
    /// Relative residual.
    pub(super) residual: f64,
}

/// A direction of a point: Jacobian and response, by angular parts.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    d: DVec3,
    arm: [DVec3; 2],
    turn: [DVec3; 2],
    impulse: f64,
}

/// A point: normal and two tangents.
#[derive(Clone, Debug)]
struct Point {
    pair: u32,
    index: usize,
    movers: [usize; 2],
    rows: [Row; 3],
    /// K of the normal; of the tangents (11, 12, 22).
    normal: f64,
    tangent: [f64; 3],
    friction: [f64; 2],
    /// Relative velocity along the normal that is asked for at least [m/s], and that of belts.
    target: f64,
    belt: DVec3,
}

/// Velocities in double precision.
#[derive(Clone, Copy, Debug)]
struct Motion {
    v: DVec3,
    w: DVec3,
    inv_mass: DVec3,
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Analytic {
    points: Vec<Point>,
    motions: Vec<Motion>,
    direct: Direct,
}

/// One sweep, forward or back; gives the greatest change of velocity.
fn sweep_once(points: &mut [Point], motions: &mut [Motion], back: bool) -> f64 {
    let mut worst = 0.0_f64;
    let mut visit = |p: &mut Point| worst = worst.max(p.visit(motions));
    if back {
        points.iter_mut().rev().for_each(&mut visit);
    } else {
        points.iter_mut().for_each(&mut visit);
    }
    worst
}

/// An unknown of the direct solve.
#[derive(Clone, Copy, Debug)]
struct Unknown {
    point: usize,
    /// Row of the point that it is an impulse of.
    row: usize,
    /// How an impulse of 1 acts: along the row, and with it the friction of what slides.
    acts: Row,
}

/// The linear problem and its memory.
#[derive(Clone, Debug, Default)]
struct Direct {
    unknowns: Vec<Unknown>,
    /// Row after row.
    matrix: Vec<f64>,
    right: Vec<f64>,
    kept: Vec<[f64; 3]>,
}

impl Direct {
    fn keep(&mut self, points: &[Point]) {
        self.kept.clear();
        self.kept.extend(points.iter().map(|p| p.rows.map(|r| r.impulse)));
    }

    /// Back to the impulses that were kept.
    fn undo(&self, points: &mut [Point], motions: &mut [Motion]) {
        for (p, kept) in points.iter_mut().zip(&self.kept) {
            for (row, impulse) in kept.iter().enumerate() {
                p.push(row, *impulse, motions);
            }
        }
    }

    /// Solves for the impulses of the points that press, given which of them stick.
    fn solve(&mut self, points: &mut [Point], motions: &mut [Motion]) {
        self.unknowns.clear();
        for (point, p) in points.iter().enumerate() {
            let [n, t1, t2] = p.rows;
            if !(n.impulse > 0.0) {
                continue;
            }
            let rub = (t1.impulse * t1.impulse + t2.impulse * t2.impulse).sqrt();
            let sticks = rub < p.friction[0] * n.impulse * (1.0 - 1.0e-9);
            let mut acts = n;
            if !sticks && rub > 0.0 {
                let share = p.friction[1] / rub;
                acts = combined(acts, t1, share * t1.impulse);
                acts = combined(acts, t2, share * t2.impulse);
            }
            self.unknowns.push(Unknown { point, row: 0, acts });
            if sticks {
                self.unknowns.push(Unknown { point, row: 1, acts: t1 });
                self.unknowns.push(Unknown { point, row: 2, acts: t2 });
            }
        }
        let n = self.unknowns.len();
        if n == 0 || n > MOST_UNKNOWNS {
            return;
        }
        self.matrix.clear();
        self.right.clear();
        for of in &self.unknowns {
            let p = &points[of.point];
            let row = &p.rows[of.row];
            for by in &self.unknowns {
                self.matrix.push(coupling(p, row, &points[by.point], &by.acts, motions));
            }
            let target = if of.row == 0 { p.target } else { 0.0 };
            self.right.push(target - p.velocity(row, motions));
        }
        for i in 0..n {
            self.matrix[i * n + i] *= 1.0 + RIDGE;
        }
        if !self.eliminate() {
            return;
        }
        for (unknown, change) in self.unknowns.iter().zip(&self.right) {
            let p = &mut points[unknown.point];
            let slides = unknown.row == 0 && unknown.acts.d != p.rows[0].d;
            let [n, t1, t2] = p.rows.map(|r| r.impulse);
            let impulse = p.rows[unknown.row].impulse + change;
            let impulse = if unknown.row == 0 { impulse.max(0.0) } else { impulse };
            p.push(unknown.row, impulse, motions);
            if slides && n > 0.0 {
                p.push(1, t1 * impulse / n, motions);
                p.push(2, t2 * impulse / n, motions);
            }
        }
    }

    /// Gauss elimination with the greatest pivot of each column; `right` becomes the solution. False if a
    /// pivot is zero or no number.
    fn eliminate(&mut self) -> bool {
        let (n, m, b) = (self.right.len(), &mut self.matrix, &mut self.right);
        for k in 0..n {
            let mut pivot = k;
            for i in k + 1..n {
                if m[i * n + k].abs() > m[pivot * n + k].abs() {
                    pivot = i;
                }
            }
            let top = m[pivot * n + k];
            if !(top.abs() > 0.0 && top.is_finite()) {
                return false;
            }
            if pivot != k {
                for j in k..n {
                    m.swap(k * n + j, pivot * n + j);
                }
                b.swap(k, pivot);
            }
            let (above, below) = m.split_at_mut((k + 1) * n);
            let head = &above[k * n + k..];
            for (i, row) in below.chunks_exact_mut(n).enumerate() {
                let part = row[k] / top;
                if part != 0.0 {
                    for (x, y) in row[k..].iter_mut().zip(head) {
                        *x -= part * y;
                    }
                    b[k + 1 + i] -= part * b[k];
                }
            }
        }
        for k in (0..n).rev() {
            let row = &m[k * n..(k + 1) * n];
            let mut sum = b[k];
            for j in k + 1..n {
                sum -= row[j] * b[j];
            }
            b[k] = sum / row[k];
        }
        b.iter().all(|x| x.is_finite())
    }
}

/// `a + factor b`, of what impulses do.
fn combined(a: Row, b: Row, factor: f64) -> Row {
    Row {
        d: a.d + b.d * factor,
        arm: [a.arm[0] + b.arm[0] * factor, a.arm[1] + b.arm[1] * factor],
        turn: [a.turn[0] + b.turn[0] * factor, a.turn[1] + b.turn[1] * factor],
        impulse: 0.0,
    }
}

/// Change of velocity along a row of point `p` by an impulse of 1 of point `q`.
fn coupling(p: &Point, row: &Row, q: &Point, acts: &Row, motions: &[Motion]) -> f64 {
    let mut sum = 0.0;
    for (i, sign_p) in [(0, -1.0), (1, 1.0)] {
        for (j, sign_q) in [(0, -1.0), (1, 1.0)] {
            if p.movers[i] == q.movers[j] {
                let by_mass = row.d.dot(each(motions[p.movers[i]].inv_mass, acts.d));
                sum += sign_p * sign_q * (by_mass + row.arm[i].dot(acts.turn[j]));
            }
        }
    }
    sum
}

impl Analytic {
    /// Solves for the velocities at the end of a substep of `h`; `bias`: overlaps are removed by velocity.
    pub(super) fn solve(
        &mut self,
        turns: &Turns,
        h: f32,
        bias: bool,
        movers: &mut [Mover],
        pairs: &mut [Pair],
    ) -> Outcome {
        self.gather(turns, h, bias, movers, pairs);
        let Self { points, motions, direct } = self;
        let scale = points.iter().map(|p| p.speed(motions)).fold(0.0, f64::max);
        // At rest the impulses of the last step have taken the speed away already.
        let force = |m: &Mover| DVec3::from(m.add_v).length();
        let scale = movers.iter().map(force).fold(scale, f64::max);
        let mut outcome = Outcome::default();
        if points.is_empty() || !(scale > 0.0 && scale.is_finite()) {
            return outcome;
        }
        let mut before = f64::INFINITY;
        for _ in 0..ROUNDS {
            for sweep in 0..SWEEPS {
                outcome.residual = sweep_once(points, motions, sweep % 2 == 1) / scale;
                outcome.sweeps += 1;
                if outcome.residual <= TOLERANCE {
                    break;
                }
            }
            if !(outcome.residual > TOLERANCE) {
                break;
            }
            // A direct solve that took the wrong points is taken back, and more sweeps find better ones.
            if outcome.residual > 2.0 * before {
                direct.undo(points, motions);
                before = f64::INFINITY;
            } else {
                before = outcome.residual;
                direct.keep(points);
                direct.solve(points, motions);
            }
        }
        for (mover, motion) in movers.iter_mut().zip(&*motions) {
            (mover.v, mover.w) = (motion.v.single(), motion.w.single());
        }
        for p in points {
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
        outcome
    }

    fn gather(
        &mut self,
        turns: &Turns,
        h: f32,
        bias: bool,
        movers: &[Mover],
        pairs: &[Pair],
    ) {
        self.motions.clear();
        self.motions.extend(movers.iter().map(|m| Motion {
            v: m.v.into(),
            w: m.w.into(),
            inv_mass: m.inv_mass.into(),
        }));
        self.points.clear();
        let h = f64::from(h);
        for row in &turns.pairs {
            let pair = &pairs[*row as usize];
            let sides = [&movers[pair.a as usize], &movers[pair.b as usize]];
            let n = pair.normal;
            let t1 = n.any_perpendicular();
            for (index, q) in pair.points().iter().enumerate() {
                let mut rows = [Row::default(); 3];
                for (r, d) in rows.iter_mut().zip([n, t1, t1.cross(n)]) {
                    *r = row_of(d, [q.r_a, q.r_b], sides);
                }
                // What the impulses of the last step are, the velocities have already.
                let rub: DVec3 = q.rub.into();
                rows[0].impulse = f64::from(q.press);
                for r in &mut rows[1..] {
                    r.impulse = rub.dot(r.d);
                }
                let k = |i: usize, j: usize| response(&rows[i], &rows[j], &self.motions, pair);
                let s = f64::from(pair.separation(q, movers));
                let bounce = -f64::from(pair.restitution) * f64::from(q.arrival);
                let target = if bounce > 0.0 {
                    bounce
                } else if s > 0.0 {
                    -s / h
                } else if bias {
                    -BAUMGARTE / h * (s + SLOP).min(0.0)
                } else {
                    0.0
                };
                self.points.push(Point {
                    pair: *row,
                    index,
                    movers: [pair.a as usize, pair.b as usize],
                    normal: k(0, 0),
                    tangent: [k(1, 1), k(1, 2), k(2, 2)],
                    rows,
                    friction: pair.friction.map(f64::from),
                    target,
                    belt: pair.belt.into(),
                });
            }
        }
    }
}

fn row_of(d: Vec3, arms: [Vec3; 2], sides: [&Mover; 2]) -> Row {
    let mut row = Row { d: d.into(), ..Row::default() };
    for side in 0..2 {
        let arm = DVec3::from(arms[side]).cross(d.into());
        row.arm[side] = arm;
        let i = &sides[side].inv_inertia;
        let [xx, yy, zz] = [i.xx, i.yy, i.zz].map(f64::from);
        let [xy, xz, yz] = [i.xy, i.xz, i.yz].map(f64::from);
        row.turn[side] = DVec3 {
            x: xx * arm.x + xy * arm.y + xz * arm.z,
            y: xy * arm.x + yy * arm.y + yz * arm.z,
            z: xz * arm.x + yz * arm.y + zz * arm.z,
        };
    }
    row
}

fn each(a: DVec3, b: DVec3) -> DVec3 {
    DVec3 { x: a.x * b.x, y: a.y * b.y, z: a.z * b.z }
}

/// Change of velocity along one row by an impulse of another of the same point.
fn response(of: &Row, by: &Row, motions: &[Motion], pair: &Pair) -> f64 {
    let (a, b) = (&motions[pair.a as usize], &motions[pair.b as usize]);
    of.d.dot(each(a.inv_mass + b.inv_mass, by.d))
        + of.arm[0].dot(by.turn[0])
        + of.arm[1].dot(by.turn[1])
}

impl Point {
    fn velocity(&self, row: &Row, motions: &[Motion]) -> f64 {
        let [a, b] = self.movers.map(|i| &motions[i]);
        row.d.dot(b.v - a.v + self.belt) + row.arm[1].dot(b.w) - row.arm[0].dot(a.w)
    }

    /// Speed of the point in all directions.
    fn speed(&self, motions: &[Motion]) -> f64 {
        self.rows.iter().map(|r| self.velocity(r, motions).abs()).fold(0.0, f64::max)
    }

    /// Solves the point with all others as they are; gives the greatest change of its velocity.
    fn visit(&mut self, motions: &mut [Motion]) -> f64 {
        if !(self.normal > 0.0) {
            return 0.0;
        }
        let [n, t1, t2] = self.rows;
        let next = (n.impulse - (self.velocity(&n, motions) - self.target) / self.normal).max(0.0);
        let mut change = (next - n.impulse).abs() * self.normal;
        self.push(0, next, motions);
        let [a, b, d] = self.tangent;
        let det = a * d - b * b;
        if !(det > 0.0) {
            return change;
        }
        let (u1, u2) = (self.velocity(&t1, motions), self.velocity(&t2, motions));
        let (mut x, mut y) =
            (t1.impulse + (b * u2 - d * u1) / det, t2.impulse + (b * u1 - a * u2) / det);
        let [hold, slide] = self.friction;
        let size = (x * x + y * y).sqrt();
        if size > hold * next {
            let k = slide * next / size;
            (x, y) = (x * k, y * k);
        }
        change = change.max((x - t1.impulse).abs() * a).max((y - t2.impulse).abs() * d);
        self.push(1, x, motions);
        self.push(2, y, motions);
        change
    }

    /// Sets the impulse of a row.
    fn push(&mut self, row: usize, impulse: f64, motions: &mut [Motion]) {
        let r = &mut self.rows[row];
        let j = impulse - r.impulse;
        r.impulse = impulse;
        for (side, sign) in [(0, -j), (1, j)] {
            let m = &mut motions[self.movers[side]];
            m.v = m.v + each(m.inv_mass, r.d) * sign;
            m.w = m.w + r.turn[side] * sign;
        }
    }
}
