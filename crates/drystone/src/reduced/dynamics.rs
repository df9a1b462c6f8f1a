//! Inverse dynamics, the mass matrix, its factor, and forward dynamics without constraints.
//!
//! Recursive Newton-Euler, composite rigid bodies, and the factor LᵀDL along branches, after
//! [Featherstone08], chapters 5, 6 and 8.

use super::def::TreeJointKind;
use super::kinematics::ball_turn;
use super::number::Number;
use super::spatial::{Spatial, Vector};
use super::tree::Tree;
use super::work::TreeWork;

impl<N: Number> Tree<N> {
    /// Forces of gravity and of velocities that the joints must bear at no acceleration
    /// \[N m or N\], into `work`; after [`Tree::move_links`]. Armature adds nothing.
    pub(crate) fn bias(&self, work: &mut TreeWork<N>) {
        let gravity = Spatial { angular: Vector::zero(), linear: -self.gravity };
        for (i, link) in self.links.iter().enumerate() {
            let above = link.parent.map_or(gravity, |p| work.acceleration[p]);
            let acceleration = above + work.drift[i];
            work.acceleration[i] = acceleration;
            work.force[i] = self.link_force(i, acceleration, work);
        }
        self.project_forces(work);
    }

    #[inline(always)]
    fn link_force(&self, link: usize, acceleration: Spatial<N>, work: &TreeWork<N>) -> Spatial<N> {
        let (inertia, velocity) = (&work.inertia[link], work.velocity[link]);
        inertia.times(acceleration) + velocity.cross_force(inertia.times(velocity))
    }

    /// Sums link forces from the leaves to the root, and takes their parts along the axes.
    fn project_forces(&self, work: &mut TreeWork<N>) {
        for (i, link) in self.links.iter().enumerate().rev() {
            let force = work.force[i];
            for dof in link.dofs.clone() {
                work.tau[dof] = work.axis[dof].dot(force);
            }
            if let Some(parent) = link.parent {
                work.force[parent] = work.force[parent] + force;
            }
        }
    }

    /// Inverse dynamics: the generalized forces \[N m or N\] that give the acceleration `a` at
    /// coordinates `q` and velocities `v`. Springs, damping and friction of joints are not in it.
    /// The result stands in the returned slice.
    pub(crate) fn inverse_dynamics<'a>(
        &self,
        q: &[N],
        v: &[N],
        a: &[N],
        work: &'a mut TreeWork<N>,
    ) -> &'a [N] {
        self.place(q, work);
        self.move_links(v, work);
        let gravity = Spatial { angular: Vector::zero(), linear: -self.gravity };
        for (i, link) in self.links.iter().enumerate() {
            let mut acceleration =
                link.parent.map_or(gravity, |p| work.acceleration[p]) + work.drift[i];
            for dof in link.dofs.clone() {
                acceleration = acceleration + work.axis[dof] * a[dof];
            }
            work.acceleration[i] = acceleration;
            work.force[i] = self.link_force(i, acceleration, work);
        }
        self.project_forces(work);
        for (dof, (tau, &rate)) in self.dofs.iter().zip(work.tau.iter_mut().zip(a)) {
            *tau = *tau + dof.armature * rate;
        }
        &work.tau
    }

    /// Forces that hold the tree still against gravity at coordinates `q` \[N m or N\].
    pub(crate) fn gravity_compensation<'a>(&self, q: &[N], work: &'a mut TreeWork<N>) -> &'a [N] {
        self.place(q, work);
        work.velocity.fill(Spatial::zero());
        work.drift.fill(Spatial::zero());
        self.bias(work);
        &work.tau
    }

    /// Adds the generalized forces of a force \[N, world\] at a point of a link \[m, link\] and a
    /// moment \[N m, world\] on the link; after [`Tree::place`].
    pub(crate) fn add_wrench(
        &self,
        link: usize,
        point: Vector<N>,
        wrench: Spatial<N>,
        work: &TreeWork<N>,
        tau: &mut [N],
    ) {
        if link >= self.links.len() || tau.len() != self.dofs.len() {
            return;
        }
        let place = work.position[link] + work.rotation[link].rotate(point);
        let moved =
            Spatial { angular: wrench.angular + place.cross(wrench.linear), linear: wrench.linear };
        for &dof in self.path_of(link) {
            tau[dof] = tau[dof] + work.axis[dof].dot(moved);
        }
    }

    /// The mass matrix, with armature, as rows along `path`; after [`Tree::place`]. Its
    /// diagonal bounds the rounding errors of pivots, so it sets their floor.
    pub(super) fn fill_mass_matrix(&self, work: &mut TreeWork<N>) {
        let minimum = Self::least_pivot();
        work.composite.copy_from_slice(&work.inertia);
        for (i, link) in self.links.iter().enumerate().rev() {
            let composite = work.composite[i];
            if let Some(parent) = link.parent {
                work.composite[parent] = work.composite[parent].plus(&composite);
            }
            for dof in link.dofs.clone() {
                let force = composite.times(work.axis[dof]);
                let row = self.rows[dof]..self.rows[dof + 1];
                for (entry, &other) in work.matrix[row.clone()].iter_mut().zip(&self.path[row]) {
                    *entry = work.axis[other].dot(force);
                }
                let at = self.rows[dof];
                work.matrix[at] = work.matrix[at] + self.dofs[dof].armature;
                work.floor[dof] = work.matrix[at] * minimum + N::splat(1.0e-36);
            }
        }
    }

    /// The mass matrix \[kg, kg m, kg m²\] in full, row by row, with armature; after
    /// [`Tree::place`].
    #[must_use]
    pub(crate) fn mass_matrix(&self, work: &mut TreeWork<N>) -> Vec<N> {
        self.fill_mass_matrix(work);
        let count = self.dofs.len();
        let mut full = vec![N::zero(); count * count];
        for dof in 0..count {
            for at in self.rows[dof]..self.rows[dof + 1] {
                let other = self.path[at];
                full[dof * count + other] = work.matrix[at];
                full[other * count + dof] = work.matrix[at];
            }
        }
        full
    }

    /// Factors the mass matrix M, with the implicit terms of damping d and springs k of a step of
    /// `h` \[s\], as LᵀDL: the diagonal has also θ h d + θ² h² k.
    ///
    /// θ = (1 + z)/(2 + z) with z = (h d + h² k/4)/D weighs the step's end. It is 1/2, the midpoint
    /// rule, where a joint's damping is slow; and near 1 where damping would stop the joint within
    /// the step. The factor of decay is then 1/(1 + z + z²/2): positive, of second order, and 0 for
    /// infinite damping. D is the inertia that moves with the joint's children free, known when
    /// the elimination arrives.
    pub(super) fn factor(&self, work: &mut TreeWork<N>, h: f64) {
        let (one, two) = (N::one(), N::splat(2.0));
        let (step, square) = (N::splat(h), N::splat(0.25 * h * h));
        self.factor_with(work, |dof, pivot| {
            let dof = &self.dofs[dof];
            let z = (step * dof.damping + square * dof.stiffness) / pivot;
            let theta = (one + z) / (two + z);
            let far = theta * step;
            (theta, far * (dof.damping + far * dof.stiffness))
        });
    }

    /// Factors with a function of degree of freedom and pivot that gives θ and the implicit term.
    #[inline(always)]
    pub(super) fn factor_with(
        &self,
        work: &mut TreeWork<N>,
        implicit: impl Fn(usize, N) -> (N, N),
    ) {
        let matrix = &mut work.matrix;
        for dof in (0..self.dofs.len()).rev() {
            let (start, end) = (self.rows[dof], self.rows[dof + 1]);
            let pivot = matrix[start].greater(work.floor[dof]);
            let (theta, extra) = implicit(dof, pivot);
            let pivot = pivot + extra;
            work.theta[dof] = theta;
            work.pivots[dof] = pivot;
            let inverse = N::one() / pivot;
            // Ancestors have lower indices, so their rows lie before this one.
            let (above, row) = matrix.split_at_mut(start);
            let row = &mut row[1..end - start];
            let path = &self.path[start + 1..end];
            for (at, &other) in path.iter().enumerate() {
                let factor = row[at] * inverse;
                let first = self.rows[other];
                let mine = &mut above[first..first + row.len() - at];
                for (entry, &value) in mine.iter_mut().zip(&row[at..]) {
                    *entry = *entry - factor * value;
                }
            }
            for entry in row {
                *entry = *entry * inverse;
            }
            let root = pivot.sqrt();
            work.root[dof] = root;
            work.root_inverse[dof] = N::one() / root;
        }
    }

    /// x ← L⁻ᵀ x.
    #[inline(always)]
    pub(super) fn solve_upper(&self, work: &TreeWork<N>, x: &mut [N]) {
        for dof in (0..x.len()).rev() {
            let value = x[dof];
            let row = self.rows[dof] + 1..self.rows[dof + 1];
            for (&other, &factor) in self.path[row.clone()].iter().zip(&work.matrix[row]) {
                x[other] = x[other] - factor * value;
            }
        }
    }

    /// x ← L⁻¹ x.
    #[inline(always)]
    pub(super) fn solve_lower(&self, work: &TreeWork<N>, x: &mut [N]) {
        for dof in 0..x.len() {
            let mut value = x[dof];
            let row = self.rows[dof] + 1..self.rows[dof + 1];
            for (&other, &factor) in self.path[row.clone()].iter().zip(&work.matrix[row]) {
                value = value - factor * x[other];
            }
            x[dof] = value;
        }
    }

    /// x ← A⁻¹ x with the factored matrix.
    pub(super) fn solve(&self, work: &TreeWork<N>, x: &mut [N]) {
        self.solve_upper(work, x);
        for (value, &root) in x.iter_mut().zip(&work.root_inverse) {
            *value = *value * root * root;
        }
        self.solve_lower(work, x);
    }

    /// Whitened velocity √D L v of a velocity.
    pub(super) fn whiten_velocity(&self, work: &TreeWork<N>, v: &[N], out: &mut [N]) {
        for dof in 0..v.len() {
            let mut value = v[dof];
            for at in self.rows[dof] + 1..self.rows[dof + 1] {
                value = value + work.matrix[at] * v[self.path[at]];
            }
            out[dof] = value * work.root[dof];
        }
    }

    /// The velocity of a whitened velocity.
    pub(super) fn color_velocity(&self, work: &TreeWork<N>, whitened: &[N], out: &mut [N]) {
        for dof in 0..out.len() {
            out[dof] = whitened[dof] * work.root_inverse[dof];
        }
        self.solve_lower(work, out);
    }

    /// Forces of the joints' springs at coordinates `q` \[N m or N\].
    pub(super) fn spring_forces(&self, q: &[N], out: &mut [N]) {
        out.fill(N::zero());
        for joint in self.joints.iter().filter(|joint| joint.has_spring) {
            let stiffness = self.dofs[joint.dof].stiffness;
            match joint.kind {
                TreeJointKind::Ball => {
                    let turn = ball_turn(joint, q);
                    for k in 0..3 {
                        out[joint.dof + k] = -(stiffness * turn.0[k]);
                    }
                }
                _ => out[joint.dof] = -(stiffness * (q[joint.q] - joint.rest)),
            }
        }
    }

    /// Forward dynamics: the acceleration \[rad/s² or m/s²\] at coordinates `q`, velocities `v` and
    /// generalized forces `tau` \[N m or N\], with springs and damping, without limits, friction
    /// and other rows.
    pub(crate) fn forward_dynamics(
        &self,
        q: &[N],
        v: &[N],
        tau: &[N],
        work: &mut TreeWork<N>,
        out: &mut [N],
    ) {
        self.place(q, work);
        self.move_links(v, work);
        self.bias(work);
        self.spring_forces(q, out);
        for dof in 0..self.dofs.len() {
            out[dof] = out[dof] + tau[dof] - work.tau[dof] - self.dofs[dof].damping * v[dof];
        }
        self.fill_mass_matrix(work);
        self.factor(work, 0.0);
        self.solve(work, out);
    }
}
