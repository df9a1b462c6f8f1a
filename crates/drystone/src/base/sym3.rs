//! Symmetric 3 × 3 matrices: inertia tensors and their square roots.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::math::{Mat3, Vec3, vec3};
use super::quat::Quat;

/// A symmetric matrix of six numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C)]
pub struct Sym3 {
    /// Row 1, column 1.
    pub xx: f32,
    /// Row 2, column 2.
    pub yy: f32,
    /// Row 3, column 3.
    pub zz: f32,
    /// Row 1, column 2.
    pub xy: f32,
    /// Row 1, column 3.
    pub xz: f32,
    /// Row 2, column 3.
    pub yz: f32,
}

impl Sym3 {
    /// All zero.
    pub const ZERO: Self = Self { xx: 0.0, yy: 0.0, zz: 0.0, xy: 0.0, xz: 0.0, yz: 0.0 };

    /// A diagonal matrix.
    #[must_use]
    pub const fn diagonal(d: Vec3) -> Self {
        Self { xx: d.x, yy: d.y, zz: d.z, xy: 0.0, xz: 0.0, yz: 0.0 }
    }

    /// `R diag(d) Rᵀ` with the rotation `r`.
    #[must_use]
    #[inline]
    pub fn rotated_diagonal(r: Quat, d: Vec3) -> Self {
        let m = r.to_mat3();
        let (a, b, c) = (m.x * d.x, m.y * d.y, m.z * d.z);
        Self {
            xx: a.x * m.x.x + b.x * m.y.x + c.x * m.z.x,
            yy: a.y * m.x.y + b.y * m.y.y + c.y * m.z.y,
            zz: a.z * m.x.z + b.z * m.y.z + c.z * m.z.z,
            xy: a.x * m.x.y + b.x * m.y.y + c.x * m.z.y,
            xz: a.x * m.x.z + b.x * m.y.z + c.x * m.z.z,
            yz: a.y * m.x.z + b.y * m.y.z + c.y * m.z.z,
        }
    }

    /// Converts a symmetric `m`; reads its upper half.
    #[must_use]
    pub const fn from_mat3(m: Mat3) -> Self {
        Self { xx: m.x.x, yy: m.y.y, zz: m.z.z, xy: m.y.x, xz: m.z.x, yz: m.z.y }
    }

    /// Converts to a full matrix.
    #[must_use]
    pub const fn to_mat3(self) -> Mat3 {
        Mat3 {
            x: vec3(self.xx, self.xy, self.xz),
            y: vec3(self.xy, self.yy, self.yz),
            z: vec3(self.xz, self.yz, self.zz),
        }
    }

    /// Matrix times vector.
    #[expect(clippy::should_implement_trait, reason = "one product, called by name")]
    #[must_use]
    #[inline]
    pub fn mul(self, v: Vec3) -> Vec3 {
        vec3(
            self.xx * v.x + self.xy * v.y + self.xz * v.z,
            self.xy * v.x + self.yy * v.y + self.yz * v.z,
            self.xz * v.x + self.yz * v.y + self.zz * v.z,
        )
    }

    /// The inverse, or `None` if the matrix is singular.
    #[must_use]
    pub fn inverse(self) -> Option<Self> {
        let (cx, cy, cz) = (
            self.yy * self.zz - self.yz * self.yz,
            self.xz * self.yz - self.xy * self.zz,
            self.xy * self.yz - self.xz * self.yy,
        );
        let det = self.xx * cx + self.xy * cy + self.xz * cz;
        if !(det.abs() > 0.0 && det.is_finite()) {
            return None;
        }
        let k = 1.0 / det;
        Some(Self {
            xx: cx * k,
            xy: cy * k,
            xz: cz * k,
            yy: (self.xx * self.zz - self.xz * self.xz) * k,
            yz: (self.xy * self.xz - self.xx * self.yz) * k,
            zz: (self.xx * self.yy - self.xy * self.xy) * k,
        })
    }

    /// Sum of two matrices.
    #[must_use]
    pub fn plus(self, o: Self) -> Self {
        Self {
            xx: self.xx + o.xx,
            yy: self.yy + o.yy,
            zz: self.zz + o.zz,
            xy: self.xy + o.xy,
            xz: self.xz + o.xz,
            yz: self.yz + o.yz,
        }
    }

    /// All entries multiplied by `s`.
    #[must_use]
    pub fn scaled(self, s: f32) -> Self {
        Self {
            xx: self.xx * s,
            yy: self.yy * s,
            zz: self.zz * s,
            xy: self.xy * s,
            xz: self.xz * s,
            yz: self.yz * s,
        }
    }

    /// True if no entry is infinite or NaN.
    #[must_use]
    pub fn is_finite(self) -> bool {
        [self.xx, self.yy, self.zz, self.xy, self.xz, self.yz].iter().all(|v| v.is_finite())
    }

    /// Returns the eigenvalues and the rotation whose columns are the eigenvectors:
    /// `self = R diag(d) Rᵀ`.
    ///
    /// Uses cyclic Jacobi rotations in double precision with a fixed number of sweeps:
    /// deterministic.
    #[must_use]
    pub fn eigen(self) -> (Vec3, Quat) {
        let mut a = [
            [f64::from(self.xx), f64::from(self.xy), f64::from(self.xz)],
            [f64::from(self.xy), f64::from(self.yy), f64::from(self.yz)],
            [f64::from(self.xz), f64::from(self.yz), f64::from(self.zz)],
        ];
        let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f64]];
        let scale = (a[0][0].abs() + a[1][1].abs() + a[2][2].abs()) * 1e-7;
        for _ in 0..12 {
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                // Rounding noise of f32 input is no reason to rotate: a box keeps its own axes.
                if a[p][q].abs() <= scale {
                    continue;
                }
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let sign = if theta < 0.0 { -1.0 } else { 1.0 };
                let t = sign / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for row in &mut a {
                    let (x, y) = (row[p], row[q]);
                    row[p] = c * x - s * y;
                    row[q] = s * x + c * y;
                }
                let (rp, rq) = (a[p], a[q]);
                for k in 0..3 {
                    a[p][k] = c * rp[k] - s * rq[k];
                    a[q][k] = s * rp[k] + c * rq[k];
                }
                for row in &mut v {
                    let (x, y) = (row[p], row[q]);
                    row[p] = c * x - s * y;
                    row[q] = s * x + c * y;
                }
            }
        }
        #[expect(clippy::cast_possible_truncation, reason = "results are wanted in f32")]
        let column = |j: usize| vec3(v[0][j] as f32, v[1][j] as f32, v[2][j] as f32);
        #[expect(clippy::cast_possible_truncation, reason = "results are wanted in f32")]
        let d = vec3(a[0][0] as f32, a[1][1] as f32, a[2][2] as f32);
        let (x, y) = (column(0), column(1));
        (d, Quat::from_mat3(Mat3 { x, y, z: x.cross(y) }))
    }
}

#[cfg(test)]
mod tests {
    use super::{Quat, Sym3, Vec3, vec3};

    #[test]
    fn eigen_of_a_rotated_diagonal_gives_it_back() {
        let d = vec3(1.0, 2.0, 5.0);
        let m = Sym3::rotated_diagonal(Quat::from_axis_angle(vec3(1.0, 2.0, 3.0), 0.7), d);
        let (e, r) = m.eigen();
        let back = Sym3::rotated_diagonal(r, e);
        for v in [Vec3::X, Vec3::Y, Vec3::Z] {
            assert!((back.mul(v) - m.mul(v)).length() < 1e-5);
        }
        let i = m.inverse().unwrap();
        assert!((i.mul(m.mul(d)) - d).length() < 1e-5);
    }
}
