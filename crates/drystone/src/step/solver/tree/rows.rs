//! Rows of joint trees, and their elimination.

use crate::base::double::DVec3;
use crate::step::solver::joint::sweep::JointSweep;
use crate::step::solver::vec6::{Jacobian, Vec6, backward, dot, factor, forward, mul};

/// Additional data of a six-axis joint in a tree.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SixDofRow {
    /// Number of drives and limits; their rows follow those of locked axes.
    pub(crate) scalars: usize,
    /// Axis number of each row, and the current direction of that axis.
    pub(crate) axes: [usize; 6],
    pub(crate) along: [DVec3; 6],
    /// Coordinate of each row, and the part of its speed that the solver bodies do not contain.
    pub(crate) place: Vec6,
    pub(crate) speed: Vec6,
    /// Speed at the start of the substep, for each row of a drive or limit.
    pub(crate) start: Vec6,
    /// Impulse of this sweep, for each row of a drive or limit.
    pub(crate) given: Vec6,
    /// Impulses of drive, friction and limit of each axis [N s; N m s].
    pub(crate) acting: [[f32; 3]; 6],
    /// Total impulse on body B: force, and torque about its anchor [N s; N m s, world].
    pub(crate) force: DVec3,
    pub(crate) torque: DVec3,
    /// Compliance of a rotation over that of a translation [1/m²].
    pub(crate) ease: f64,
}

impl SixDofRow {
    /// Scales the impulses by `part`.
    #[expect(clippy::cast_possible_truncation, reason = "a factor")]
    pub(crate) fn restrain(&mut self, part: f64) {
        if !(part > 0.0) {
            (self.acting, self.force, self.torque) = ([[0.0; 3]; 6], DVec3::ZERO, DVec3::ZERO);
            return;
        }
        self.acting.iter_mut().flatten().for_each(|p| *p *= part as f32);
        (self.force, self.torque) = (self.force * part, self.torque * part);
    }

    /// The axis of a row.
    pub(crate) const fn axis(&self, row: usize) -> usize {
        self.axes[row]
    }

    /// Impulses of drive, friction and limit of each axis.
    pub(crate) const fn acting(&self) -> &[[f32; 3]; 6] {
        &self.acting
    }
}

/// Parameters of one sweep over trees: see [`JointSweep`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeSweep {
    pub(crate) h: f64,
    pub(crate) rate: f64,
    pub(crate) compliance: f64,
    pub(crate) elapsed: f64,
    /// Maximum speed at which gaps close [m/s].
    pub(crate) push_speed: f64,
    pub(crate) joints: JointSweep,
}

impl TreeSweep {
    /// Rate [1/s] at which a gap of this size closes: its speed is at most `fastest`, plus
    /// [`beyond`](crate::step::context::caps::Caps::beyond) for large gaps of an axis.
    pub(crate) fn closing_rate(&self, size: f64, fastest: f64, axis: usize) -> f64 {
        let fastest = fastest + self.joints.caps.beyond(size, axis);
        if self.rate * size > fastest { fastest / size } else { self.rate }
    }
}

/// A body of a tree.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TreeBody {
    pub(crate) solver_row: u32,
    pub(crate) alpha: f64,
    pub(crate) s: [DVec3; 3],
    /// Velocity change by the tree's joints (whitened), as the solver body carries it.
    pub(crate) carried: Vec6,
    pub(crate) u: Vec6,
    /// Velocity at the start of the substep (whitened).
    pub(crate) start: Vec6,
    pub(crate) motion: Vec6,
    /// Geometric stiffness, times h² [kg m²].
    pub(crate) turning: f64,
    /// Lower half of the matrix, then its factor with inverse diagonal.
    pub(crate) h: [Vec6; 6],
    pub(crate) x: Vec6,
    /// Sum of several solutions.
    pub(crate) sum: Vec6,
}

/// A joint of a tree.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TreeRow {
    /// Number of active rows.
    pub(crate) count: usize,
    /// Lever arms of child and parent. For a ball joint these and the gap are those of the step's
    /// start, signed as child less parent.
    pub(crate) r_child: DVec3,
    pub(crate) r_parent: DVec3,
    pub(crate) gap: DVec3,
    pub(crate) drift: DVec3,
    /// Impulse of each row, and their total on the child [N s].
    pub(crate) lambda: Vec6,
    pub(crate) impulse: DVec3,
    /// Six-axis joints only.
    pub(crate) six_dof: SixDofRow,
    /// Jacobian rows; rows of drives and limits follow the active ones.
    pub(crate) child: Jacobian,
    pub(crate) parent: Jacobian,
    /// Factor of the joint's matrix with inverse diagonal; the rows through the child's factor; and
    /// the rows through the joint's factor, at the body into which the joint is eliminated.
    pub(crate) k: [Vec6; 6],
    pub(crate) y: Jacobian,
    pub(crate) w: Jacobian,
    /// Right side, then impulses.
    pub(crate) rhs: Vec6,
    /// Maximum speeds at which its translations and rotations close in this sweep [m/s; rad/s].
    pub(crate) closing: [f64; 2],
}

/// Sets the rows of a ball joint: velocity at the lever arm `r`, times `sign`, which is S (r × e).
pub(crate) fn put_ball(rows: &mut Jacobian, sign: f64, body: &TreeBody, r: DVec3) {
    let across = [
        DVec3 { x: 0.0, y: r.z, z: -r.y },
        DVec3 { x: -r.z, y: 0.0, z: r.x },
        DVec3 { x: r.y, y: -r.x, z: 0.0 },
    ];
    for i in 0..3 {
        let a = mul(&body.s, across[i]) * sign;
        rows[i] = [0.0, 0.0, 0.0, a.x, a.y, a.z];
        rows[i][i] = sign * body.alpha;
    }
}

impl TreeBody {
    /// Adds the maximum stiffness of an impulse `p` at the lever arm `r` against rotation, times h.
    pub(crate) fn stiffen(&mut self, h: f64, p: DVec3, r: DVec3) {
        self.turning += 0.5 * h * (p.dot(r) + p.length() * r.length());
    }

    /// Sets H before any elimination into it.
    pub(crate) fn begin(&mut self) {
        self.h = [[0.0; 6]; 6];
        for i in 0..6 {
            self.h[i][i] = 1.0;
        }
        for i in 0..3 {
            for j in 0..=i {
                self.h[3 + i][3 + j] += self.turning * self.s[i].dot(self.s[j]);
            }
        }
        self.x = [0.0; 6];
    }

    /// Eliminates a factored joint into this body.
    #[inline(always)]
    pub(crate) fn take(&mut self, joint: &TreeRow, n: usize) {
        let w = &joint.w;
        for r in 0..6 {
            for c in 0..=r {
                let sum = (0..n).fold(0.0, |sum, i| sum + w[i][r] * w[i][c]);
                self.h[r][c] += sum;
            }
        }
    }
}

impl TreeRow {
    /// Velocity of a ball joint's gap by kinematic bodies.
    pub(crate) const fn drift(&self) -> DVec3 {
        self.drift
    }

    /// Eliminates the body below, if any. Then factors the joint's own matrix, for the body above,
    /// or for the body below if there is none above.
    #[inline(always)]
    pub(crate) fn factor(&mut self, below: Option<&TreeBody>, n: usize) {
        let own = if below.is_some() { &self.parent } else { &self.child };
        self.w[..n].copy_from_slice(&own[..n]);
        if let Some(body) = below {
            for r in 0..n {
                self.y[r] = self.child[r];
                forward(&body.h, &mut self.y[r], 6);
                for c in 0..=r {
                    self.k[r][c] += dot(&self.y[r], &self.y[c]);
                }
            }
        }
        factor(&mut self.k, n);
        // W = K^-1/2 J
        let w = &mut self.w;
        for i in 0..n {
            for k in 0..i {
                for c in 0..6 {
                    w[i][c] -= self.k[i][k] * w[k][c];
                }
            }
            for c in 0..6 {
                w[i][c] *= self.k[i][i];
            }
        }
    }

    /// Reduces the right side by the contribution of the body below.
    #[inline(always)]
    pub(crate) fn reduce(&mut self, below: Option<&Vec6>, n: usize) {
        if let Some(x) = below {
            for r in 0..n {
                self.rhs[r] -= dot(&self.y[r], x);
            }
        }
        forward(&self.k, &mut self.rhs, n);
    }

    /// Computes the impulse of each row, from its rows on the body into which it was eliminated and
    /// that body's velocity change.
    #[inline(always)]
    pub(crate) fn solve(&mut self, is_world: bool, x: &Vec6, n: usize) {
        let rows = if is_world { &self.child } else { &self.parent };
        let mut b = [0.0; 6];
        for i in 0..n {
            b[i] = dot(&rows[i], x);
        }
        forward(&self.k, &mut b, n);
        for i in 0..n {
            self.rhs[i] -= b[i];
        }
        backward(&self.k, &mut self.rhs, n);
    }
}
