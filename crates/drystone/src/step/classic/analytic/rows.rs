//! Rows of the analytic method: contact points and the responses of bodies to them.

use crate::base::double::{DVec3, greater};
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;
use crate::step::classic::analytic::skyline::{SIX_DOF, Skyline};

/// A direction of a point in whitened velocities, y with v = v₁ + W y and W Wᵀ = M⁻¹. Its row is
/// also its response, with one part for each body.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    pub(crate) d: DVec3,
    pub(crate) g: [[f64; SIX_DOF]; 2],
    /// Velocity along the direction for y = 0.
    pub(crate) u: f64,
    pub(crate) impulse: f64,
}

/// A contact point: normal and two tangents.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub(crate) pair: u32,
    pub(crate) index: usize,
    /// Movers without the fixed one; a body without unknowns is out of range.
    pub(crate) bodies: [u32; 2],
    pub(crate) rows: [Row; 3],
    /// K of the normal, and of the tangents.
    pub(crate) normal: f64,
    pub(crate) tangent: [f64; 2],
    pub(crate) friction: [f64; 2],
    /// Minimum relative velocity along the normal [m/s].
    pub(crate) target: f64,
    /// Coefficient of friction, and s in this round.
    pub(crate) mu: f64,
    pub(crate) slip: f64,
}

/// A lower triangle L with L Lᵀ equal to this matrix, by columns; zero in singular directions.
pub(super) fn lower_root(m: &Sym3) -> [DVec3; 3] {
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

pub(super) fn row_of(d: Vec3, arms: [Vec3; 2], roots: [&(DVec3, [DVec3; 3]); 2]) -> Row {
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

pub(super) fn each(a: DVec3, b: DVec3) -> DVec3 {
    DVec3 { x: a.x * b.x, y: a.y * b.y, z: a.z * b.z }
}

pub(super) fn dot(a: &[f64; SIX_DOF], b: &[f64; SIX_DOF]) -> f64 {
    let mut sum = 0.0;
    for i in 0..SIX_DOF {
        sum += a[i] * b[i];
    }
    sum
}

/// Velocity change along one row by a unit impulse of another row of the same point.
pub(super) fn response(of: &Row, by: &Row) -> f64 {
    dot(&of.g[0], &by.g[0]) + dot(&of.g[1], &by.g[1])
}

/// Component of a change of whitened velocities along a row.
pub(super) fn along(row: &Row, bodies: [u32; 2], y: &[[f64; SIX_DOF]]) -> f64 {
    let part = |side: usize| y.get(bodies[side] as usize).map_or(0.0, |y| dot(&row.g[side], y));
    part(0) + part(1)
}

pub(super) fn inner(a: &[[f64; SIX_DOF]], b: &[[f64; SIX_DOF]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| dot(a, b)).sum()
}

/// The nearest point of K.
pub(super) fn onto_cone(mu: f64, [n, x, z]: [f64; 3]) -> [f64; 3] {
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
    pub(crate) fn velocities(&self, y: &[[f64; SIX_DOF]]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.rows[i].u + along(&self.rows[i], self.bodies, y))
    }

    /// Initial speed of the point, in its fastest direction.
    pub(crate) fn speed(&self) -> f64 {
        self.rows.iter().map(|r| r.u.abs()).fold(0.0, f64::max)
    }

    /// Argument of the projection, and the stiffness.
    pub(crate) fn reach(&self, y: &[[f64; SIX_DOF]], stiffness: f64) -> ([f64; 3], f64) {
        let rho = stiffness / greater(self.normal, greater(self.tangent[0], self.tangent[1]));
        let [n, t1, t2] = self.velocities(y);
        let i = self.rows.map(|r| r.impulse);
        ([i[0] - rho * (n - self.target + self.slip), i[1] - rho * t1, i[2] - rho * t2], rho)
    }

    /// The impulses of the round for these velocities.
    pub(crate) fn projected(&self, y: &[[f64; SIX_DOF]], stiffness: f64) -> [f64; 3] {
        onto_cone(self.mu, self.reach(y, stiffness).0)
    }

    /// Adds the effect of impulses to the velocities.
    pub(crate) fn push(&self, impulses: [f64; 3], y: &mut [[f64; SIX_DOF]]) {
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
    pub(crate) fn stiffen(&self, y: &[[f64; SIX_DOF]], stiffness: f64, matrix: &mut Skyline) {
        let (mu, ([n, x, z], rho)) = (self.mu, self.reach(y, stiffness));
        let size = (x * x + z * z).sqrt();
        if mu * size <= -n {
            return;
        }
        if size <= mu * n {
            self.rows.iter().for_each(|row| matrix.add(rho, self.bodies, &row.g));
            return;
        }
        // Along the nearest edge of the cone, and around the cone.
        let (c, s) = (x / size, z / size);
        matrix.add(rho / (1.0 + mu * mu), self.bodies, &self.combined([1.0, mu * c, mu * s]));
        let around = mu * (n + mu * size) / ((1.0 + mu * mu) * size);
        if around > 0.0 {
            matrix.add(rho * around, self.bodies, &self.combined([0.0, -s, c]));
        }
    }

    fn combined(&self, parts: [f64; 3]) -> [[f64; SIX_DOF]; 2] {
        let mut g = [[0.0; SIX_DOF]; 2];
        for (row, part) in self.rows.iter().zip(parts) {
            for side in 0..2 {
                for i in 0..SIX_DOF {
                    g[side][i] += part * row.g[side][i];
                }
            }
        }
        g
    }

    /// The impulses of this point if all others stayed unchanged, the resulting change of its
    /// velocity, and the coefficient of friction that limits it.
    pub(crate) fn alone(&self, y: &[[f64; SIX_DOF]]) -> ([f64; 3], f64, f64) {
        let now = self.rows.map(|r| r.impulse);
        let (mut u, [a, d]) = (self.velocities(y), self.tangent);
        let press = (now[0] - (u[0] - self.target) / self.normal).max(0.0);
        let change = (press - now[0]).abs() * self.normal;
        // One stiffness for the whole surface, at least the maximum. With the matrix of both
        // directions, friction would not oppose the slip where their responses differ.
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
