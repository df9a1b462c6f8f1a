//! Geometric stiffness: how the forces that links bear change their moments as joints turn.
//!
//! A heavy load on light links makes stiff motions that no spring shows: the links are pulled
//! straight as a string is, at thousands of radians a second. With the force φ = m (g − a) of each
//! link held, the residual of the equations of motion changes with the coordinates by
//!
//! ```text
//! K_ij = −Σ φ_l · (w_i × (S_j at c_l)),   i an ancestor of j or j itself, l a descendant of j
//! ```
//!
//! the second derivative of −Σ φ·c [Andrews17]. It has the branches of the mass matrix, so
//! M + h²/4 K is factored like M; the step then is implicit in these motions.

use super::number::Number;
use super::spatial::{Spatial, Vector};
use super::tree::Tree;
use super::work::TreeWork;

/// Sum of forces φ, and of φ cᵀ, of a link with its descendants.
#[derive(Clone, Copy, Debug)]
pub(super) struct Load<N> {
    force: Vector<N>,
    /// Columns: Σ φ c_x, Σ φ c_y, Σ φ c_z.
    moment: [Vector<N>; 3],
}

impl<N: Number> Load<N> {
    pub(super) fn zero() -> Self {
        Self { force: Vector::zero(), moment: [Vector::zero(); 3] }
    }

    #[inline(always)]
    fn add(&mut self, o: &Self) {
        self.force = self.force + o.force;
        for k in 0..3 {
            self.moment[k] = self.moment[k] + o.moment[k];
        }
    }

    /// Σ (S at c) × φ.
    #[inline(always)]
    fn turning(&self, s: Spatial<N>) -> Vector<N> {
        // (w × c) × φ = c (w·φ) − w (c·φ)
        let [x, y, z] = self.moment;
        let w = s.angular;
        let trace = x.0[0] + y.0[1] + z.0[2];
        let along = Vector([w.dot(x), w.dot(y), w.dot(z)]);
        s.linear.cross(self.force) + along - w * trace
    }
}

impl<N: Number> Tree<N> {
    /// Adds `scale` times the geometric stiffness to the mass matrix, at the accelerations `a`;
    /// after [`Tree::bias`] and `fill_mass_matrix`.
    pub(super) fn add_geometric(
        &self,
        a: &[N],
        scale: N,
        loads: &mut [Load<N>],
        work: &mut TreeWork<N>,
    ) {
        let gravity = Spatial { angular: Vector::zero(), linear: -self.gravity };
        for (i, link) in self.links.iter().enumerate() {
            let mut acceleration =
                link.parent.map_or(gravity, |p| work.acceleration[p]) + work.drift[i];
            for dof in link.dofs.clone() {
                acceleration = acceleration + work.axis[dof] * a[dof];
            }
            work.acceleration[i] = acceleration;
            let inertia = &work.inertia[i];
            let safe = N::zero().if_less(inertia.mass, inertia.mass, N::one());
            let center = inertia.moment * (N::one() / safe);
            // m (g − a): minus the rate of the link's linear momentum, less gravity.
            let velocity = work.velocity[i];
            let force = -(acceleration.at(center) * inertia.mass
                + velocity.angular.cross(velocity.at(center) * inertia.mass));
            loads[i] = Load { force, moment: center.0.map(|c| force * c) };
        }
        for (i, link) in self.links.iter().enumerate().rev() {
            let load = loads[i];
            if let Some(parent) = link.parent {
                loads[parent].add(&load);
            }
            for dof in link.dofs.clone() {
                let turning = load.turning(work.axis[dof]) * (-scale);
                for at in self.rows[dof]..self.rows[dof + 1] {
                    let w = work.axis[self.path[at]].angular;
                    work.matrix[at] = work.matrix[at] + w.dot(turning);
                }
            }
        }
    }
}
