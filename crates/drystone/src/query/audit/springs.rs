//! Elastic energy of six-axis joints.

use super::energy::inverse_inertia;
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;
use crate::state::bodies::Bodies;
use crate::state::bodies::body::Body;
use crate::state::def::six_dof::{JointMotion, JointSpring};
use crate::state::joints::Joint;
use crate::state::six_dof::SixDofJoint;

/// Energy in the springs of drives and limits [J]. A drive at its maximum force F pulls with F from
/// there on: F x - F²/(2 k).
pub(super) fn elastic(joint: &Joint, six_dof: &SixDofJoint, bodies: &Bodies) -> f64 {
    if six_dof.def.scalars() == [false; 2] {
        return 0.0;
    }
    let (a, b) = (bodies.at(joint.body_a), bodies.at(joint.body_b));
    let (ra, rb) = (a.rotation.rotate(joint.anchor_a), b.rotation.rotate(joint.anchor_b));
    let gap = (b.center - a.center) + (rb - ra);
    let axes = (a.rotation * six_dof.def.frame_a).to_mat3();
    let turns = six_dof.joint_angles(a.rotation, b.rotation);
    let along = [axes.x, axes.y, axes.z];
    let acting = six_dof.def.acting(turns.swing);
    let x = |i: usize| if i < 3 { along[i].dot(gap) } else { turns.angles[i - 3] };
    let mut rows = Rows::default();
    for i in 0..3 {
        rows.add(i, along[i], [(ra + gap).cross(along[i]), rb.cross(along[i])], [a, b]);
        rows.add(i + 3, Vec3::ZERO, [turns.rows[i]; 2], [a, b]);
    }
    let held = core::array::from_fn(|i| acting[i].locked_at().is_some());
    let stiffness = |i: usize, spring: &JointSpring| {
        let k = f64::from(spring.stiffness);
        if !spring.per_mass {
            return k;
        }
        let give = rows.give(i, held);
        if give > 0.0 { k / give } else { 0.0 }
    };
    let mut sum = 0.0;
    for (i, axis) in acting.iter().enumerate().filter(|(_, axis)| axis.is_scalar()) {
        let x = f64::from(x(i));
        if let Some(drive) = axis.drive {
            let (k, maximum) = (stiffness(i, &drive.spring), f64::from(drive.max_force));
            let off = (x - f64::from(drive.position)).abs();
            sum += if k * off <= maximum {
                0.5 * k * off * off
            } else {
                maximum * (off - 0.5 * maximum / k)
            };
        }
        if let JointMotion::Limited { min, max, spring: Some(spring) } = axis.motion {
            let off = (f64::from(min) - x).max(x - f64::from(max)).max(0.0);
            sum += 0.5 * stiffness(i, &spring) * off * off;
        }
    }
    sum
}

/// Six rows of two bodies: Jacobians, and the velocity response to each row.
#[derive(Default)]
struct Rows {
    /// For each row, n and r × n of both bodies, then the same multiplied by the inverse masses.
    rows: [[[Vec3; 4]; 2]; 6],
}

impl Rows {
    fn add(&mut self, i: usize, n: Vec3, moments: [Vec3; 2], bodies: [&Body; 2]) {
        let respond = |body: &Body, n: Vec3, moment: Vec3| {
            if !body.is_dynamic() {
                return [Vec3::ZERO; 2];
            }
            let inverse: Sym3 = inverse_inertia(body);
            [n * (1.0 / body.inertia.mass), inverse.mul(moment)]
        };
        let [p, q] = moments;
        let ([v, w], [x, y]) = (respond(bodies[0], n, p), respond(bodies[1], n, q));
        self.rows[i] = [[n, p, n, q], [v, w, x, y]];
    }

    fn coupling(&self, i: usize, j: usize) -> f64 {
        let ([n, _], [_, m]) = (&self.rows[i], &self.rows[j]);
        n.iter().zip(m).map(|(n, m)| f64::from(n.dot(*m))).sum()
    }

    /// Inverse effective mass of a row with the held rows at rest, by elimination of the held rows.
    fn give(&self, row: usize, held: [bool; 6]) -> f64 {
        let mut k: [[f64; 6]; 6] =
            core::array::from_fn(|i| core::array::from_fn(|j| self.coupling(i, j)));
        for p in (0..6).filter(|p| held[*p] && *p != row) {
            let pivot = k[p][p];
            if pivot <= 1.0e-9 * self.coupling(p, p) {
                continue;
            }
            let line = k[p];
            for (i, other) in k.iter_mut().enumerate().filter(|(i, _)| *i != p) {
                let part = line[i] / pivot;
                for (value, own) in other.iter_mut().zip(line) {
                    *value -= part * own;
                }
            }
        }
        k[row][row]
    }
}
