//! Rows of joint trees.

use crate::base::double::DVec3;
use crate::step::solver::joint::sweep::JointSweep;
use crate::step::solver::vec6::{Jacobian, Six, backward, dot, factor, forward, mul};

/// What a joint of six axes has in a tree besides its rows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SixRow {
    /// How many drives and limits it has; their rows follow those that it holds.
    pub(crate) scalars: usize,
    /// Which axis each row is of, and that axis now.
    pub(crate) axes: [usize; 6],
    pub(crate) along: [DVec3; 6],
    /// Of each row, its coordinate and the part of its speed that the bodies' lines do not have.
    pub(crate) place: Six,
    pub(crate) speed: Six,
    /// Of each row of a drive or limit, its speed when the substep began.
    pub(crate) start: Six,
    /// And its impulse of this sweep.
    pub(crate) given: Six,
    /// Of each axis, the impulses of its drive, friction and limit [N s; N m s].
    pub(crate) acting: [[f32; 3]; 6],
    /// Impulse of all rows on body B: force, and torque about its anchor [N s; N m s, world].
    pub(crate) force: DVec3,
    pub(crate) torque: DVec3,
    /// Compliance of a turn over that of a motion [1/m²].
    pub(crate) ease: f64,
}

impl SixRow {
    /// Takes the impulses down to a part.
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

    /// Of each axis, the impulses of its drive, friction and limit.
    pub(crate) const fn acting(&self) -> &[[f32; 3]; 6] {
        &self.acting
    }
}

/// What the tree's joints have in common in one sweep: see [`JointSweep`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeSweep {
    pub(crate) h: f64,
    pub(crate) rate: f64,
    pub(crate) compliance: f64,
    pub(crate) elapsed: f64,
    /// Gaps are closed no faster than this [m/s].
    pub(crate) push_speed: f64,
    pub(crate) joints: JointSweep,
}

impl TreeSweep {
    /// By which rate [1/s] a gap of this size closes: no faster than at `fastest`, and wide ones of an axis by
    /// what is [`beyond`](crate::step::context::caps::Caps::beyond) it.
    pub(crate) fn closing_rate(&self, size: f64, fastest: f64, axis: usize) -> f64 {
        let fastest = fastest + self.joints.caps.beyond(size, axis);
        if self.rate * size > fastest { fastest / size } else { self.rate }
    }
}

/// A body of a tree.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TreeBody {
    pub(crate) line: u32,
    pub(crate) alpha: f64,
    pub(crate) s: [DVec3; 3],
    /// What the joints of the tree made of its velocity (whitened), as the line carries it.
    pub(crate) carried: Six,
    pub(crate) u: Six,
    /// Its velocity when the substep began (whitened).
    pub(crate) start: Six,
    pub(crate) motion: Six,
    /// Geometric stiffness, times h² [kg m²].
    pub(crate) turning: f64,
    /// Lower half of the matrix, then its factor with inverse diagonal.
    pub(crate) h: [Six; 6],
    pub(crate) x: Six,
    /// Of several solutions, their sum.
    pub(crate) sum: Six,
}

/// A joint of a tree.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TreeRow {
    /// Rows that count.
    pub(crate) count: usize,
    /// Arms of child and parent; those of a ball, and its gap, at the step's start, signed as child less parent.
    pub(crate) r_child: DVec3,
    pub(crate) r_parent: DVec3,
    pub(crate) gap: DVec3,
    pub(crate) drift: DVec3,
    /// Impulse of each row, and what that is on the child [N s].
    pub(crate) lambda: Six,
    pub(crate) impulse: DVec3,
    /// Of a joint of six axes.
    pub(crate) six: SixRow,
    /// After the rows that count those of drives and limits.
    pub(crate) child: Jacobian,
    pub(crate) parent: Jacobian,
    /// Factor of the joint's matrix with inverse diagonal; the rows through the child's factor, and through the
    /// joint's at the body that it is eliminated into.
    pub(crate) k: [Six; 6],
    pub(crate) y: Jacobian,
    pub(crate) w: Jacobian,
    /// Right side, then impulses.
    pub(crate) rhs: Six,
    /// Greatest speeds at which its motions and turns close in this sweep [m/s; rad/s].
    pub(crate) closing: [f64; 2],
}

/// The rows of a ball: velocity at the arm `r`, times `sign`, which is S (r × e).
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
    /// The greatest stiffness of an impulse `p` at the arm `r` against turning, times h.
    pub(crate) fn stiffen(&mut self, h: f64, p: DVec3, r: DVec3) {
        self.turning += 0.5 * h * (p.dot(r) + p.length() * r.length());
    }

    /// H before anything is eliminated into it.
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

    /// Eliminates a joint that is factored.
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
    /// Velocity of the gap by kinematic bodies, of a ball.
    pub(crate) const fn drift(&self) -> DVec3 {
        self.drift
    }

    /// Eliminates the body below, if any; then factors its own matrix, for the body above, or that below
    /// if there is none.
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

    /// The right side after what the body below takes of it.
    #[inline(always)]
    pub(crate) fn reduce(&mut self, below: Option<&Six>, n: usize) {
        if let Some(x) = below {
            for r in 0..n {
                self.rhs[r] -= dot(&self.y[r], x);
            }
        }
        forward(&self.k, &mut self.rhs, n);
    }

    /// The impulse of each row, given its rows on the body that it was eliminated into and what that body's
    /// velocity changes by.
    #[inline(always)]
    pub(crate) fn solve(&mut self, is_world: bool, x: &Six, n: usize) {
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
