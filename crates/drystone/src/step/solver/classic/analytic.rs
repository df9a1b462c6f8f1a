//! The contact problem solved to a tolerance: velocities after which nothing approaches, nothing that parts
//! pushes, and friction takes the most energy that its cone allows [Baraff94].
//!
//! The survey's "analytic" method pivots, which is direct and takes the cube of the contacts. Here projected
//! Gauss-Seidel goes on, in double precision, until the residual is below the tolerance: it gives the same
//! velocities (they are unique but for friction; impulses of four corners never are), keeps no matrix, and has no
//! case in which a pivot fails. It takes long where loads have a long way to the ground.

use super::rows::{Mover, Pair};
use super::sweeps::Turns;
use crate::base::double::DVec3;
use crate::base::math::Vec3;

/// Residual at which it ends: the greatest change of velocity that a visit of a row still asks for, as a part
/// of the greatest speed of a contact point before.
pub(super) const TOLERANCE: f64 = 1.0e-6;

/// Visits of points in a substep after which it gives up: some seconds.
const MOST_VISITS: u64 = 40_000_000;

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
        let Self { points, motions } = self;
        let scale = points.iter().map(|p| p.speed(motions)).fold(0.0, f64::max);
        let mut outcome = Outcome::default();
        let visits = points.len() as u64;
        if visits == 0 || !(scale > 0.0 && scale.is_finite()) {
            return outcome;
        }
        let mut spent = 0;
        loop {
            let mut worst = 0.0_f64;
            // Up and down again: loads go the way to the ground and back in one round.
            if outcome.sweeps.is_multiple_of(2) {
                for p in points.iter_mut() {
                    worst = worst.max(p.visit(motions));
                }
            } else {
                for p in points.iter_mut().rev() {
                    worst = worst.max(p.visit(motions));
                }
            }
            outcome.sweeps += 1;
            outcome.residual = worst / scale;
            spent += visits;
            if !(outcome.residual > TOLERANCE) || spent >= MOST_VISITS {
                break;
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
