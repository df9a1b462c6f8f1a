//! Algebra of trees: 6-vectors, rows of them, and Cholesky factors of up to six rows.

use crate::base::double::{DVec3, lesser};

pub(super) type Vec6 = [f64; 6];

/// Jacobian rows of a joint, which map a body's velocity to the joint's locked axes; only the first
/// rows count.
pub(super) type Jacobian = [Vec6; 6];

pub(super) fn halves(a: &Vec6) -> (DVec3, DVec3) {
    (DVec3 { x: a[0], y: a[1], z: a[2] }, DVec3 { x: a[3], y: a[4], z: a[5] })
}

pub(super) fn dot(a: &Vec6, b: &Vec6) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]
}

pub(super) fn wide(v: [f32; 4], w: [f32; 4]) -> Vec6 {
    [v[0], v[1], v[2], w[0], w[1], w[2]].map(f64::from)
}

pub(super) fn mul(s: &[DVec3; 3], v: DVec3) -> DVec3 {
    DVec3 { x: s[0].dot(v), y: s[1].dot(v), z: s[2].dot(v) }
}

/// Replaces the first `n` rows by their lower Cholesky factor, with the diagonal inverted. The
/// matrix is positive definite.
#[inline(always)]
pub(super) fn factor(m: &mut [Vec6; 6], n: usize) {
    for i in 0..n {
        for j in 0..=i {
            let mut sum = m[i][j];
            for k in 0..j {
                sum -= m[i][k] * m[j][k];
            }
            m[i][j] = if i == j { 1.0 / sum.sqrt() } else { sum * m[j][j] };
        }
    }
}

#[inline(always)]
pub(super) fn forward(m: &[Vec6; 6], b: &mut Vec6, n: usize) {
    for i in 0..n {
        let mut sum = b[i];
        for k in 0..i {
            sum -= m[i][k] * b[k];
        }
        b[i] = sum * m[i][i];
    }
}

#[inline(always)]
pub(super) fn backward(m: &[Vec6; 6], b: &mut Vec6, n: usize) {
    for i in (0..n).rev() {
        let mut sum = b[i];
        for k in i + 1..n {
            sum -= m[k][i] * b[k];
        }
        b[i] = sum * m[i][i];
    }
}

/// Adds the impulses `p` of rows.
#[inline(always)]
pub(super) fn push(x: &mut Vec6, rows: &Jacobian, p: &Vec6, n: usize) {
    for c in 0..6 {
        let sum = (0..n).fold(0.0, |sum, i| sum + rows[i][c] * p[i]);
        x[c] += sum;
    }
}

/// Displacement of `r` by the rotation vector `t`, up to 2.8 rad. See
/// [`super::joint::sweep::Turn`].
pub(super) fn shift(t: DVec3, r: DVec3) -> DVec3 {
    let y = t * 0.5;
    let q = lesser(y.dot(y), 2.0);
    let half = y * ((945.0 - (105.0 - q) * q) / (945.0 - (420.0 - 15.0 * q) * q));
    (half * (2.0 / (1.0 + half.dot(half)))).cross(r + half.cross(r))
}

/// Distance of an arm's end from its tangent after a substep, over the substep: see
/// `joint/ball_distance.rs`.
pub(super) fn curve(w: DVec3, r: DVec3, h: f64) -> DVec3 {
    let half = 0.5 * h;
    w.cross(w.cross(r)) * (half / (1.0 + half * half * w.dot(w)))
}
