//! Positions and velocities of links, motion of coordinates, momentum, energy, Jacobians.
//!
//! Symbols: q coordinates, v velocities, S motion of a degree of freedom at rate 1, V motion of a
//! link, I inertia, h momentum. All spatial vectors are about the origin of the first link.

use super::def::{TreeError, TreeJointKind};
use super::number::Number;
use super::spatial::{Inertia, Rotation, Spatial, Vector};
use super::tree::{Joint, Tree};
use super::work::TreeWork;

impl<N: Number> Tree<N> {
    /// Checks the sizes of coordinates and velocities, that they are finite, and that quaternions
    /// have a length.
    ///
    /// # Errors
    /// Names the first number that is wrong.
    pub(crate) fn check_state(&self, q: &[N], v: &[N]) -> Result<(), TreeError> {
        for (name, given, count) in [("q", q, self.q_count), ("v", v, self.dofs.len())] {
            if given.len() != count {
                let allowed = format!("{count} numbers");
                return Err(TreeError::new(name, format!("{} numbers", given.len()), &allowed));
            }
            let maximum = N::splat(1.0e12);
            // A NaN is not less than anything, so it is found by not being less.
            let wrong = |x: &N| x.abs().if_less(maximum, N::zero(), N::one()) != N::zero();
            if let Some(i) = given.iter().position(wrong) {
                let place = format!("{name}[{i}]");
                return Err(TreeError::new(place, given[i].lane(0), "-1e12 to 1e12"));
            }
        }
        for joint in &self.joints {
            let Some(at) = quaternion_of(joint) else { continue };
            let square = q[at..at + 4].iter().fold(N::zero(), |sum, &x| sum + x * x);
            if square.any_less(N::splat(1.0e-12)) {
                let place = format!("q[{at}..{}]", at + 4);
                return Err(TreeError::new(place, "0", "a quaternion with a length above 0"));
            }
        }
        Ok(())
    }

    /// Scales the quaternions in `q` to length 1.
    pub(crate) fn normalize(&self, q: &mut [N]) {
        for at in self.joints.iter().filter_map(quaternion_of) {
            let unit = Rotation([q[at], q[at + 1], q[at + 2], q[at + 3]]).normalized();
            q[at..at + 4].copy_from_slice(&unit.0);
        }
    }

    /// Forward kinematics: poses, axes and inertias of all links at the coordinates `q`.
    pub(crate) fn place(&self, q: &[N], work: &mut TreeWork<N>) {
        // A step begins where the last one ended, which is placed.
        let same = |(&a, &b): (&N, &N)| a.same_bits(b);
        if work.is_placed && work.placed.iter().zip(q).all(same) {
            return;
        }
        work.is_placed = true;
        work.placed.clear();
        work.placed.extend_from_slice(q);
        let floats = self.floats();
        work.origin = if floats { Vector([q[0], q[1], q[2]]) } else { self.links[0].position };
        for (i, link) in self.links.iter().enumerate() {
            let (mut position, mut rotation) = match link.parent {
                None => (Vector::zero(), link.rotation),
                Some(parent) => {
                    let turn = work.rotation[parent];
                    let place = work.position[parent] + turn.rotate(link.position);
                    (place, turn.times(link.rotation))
                }
            };
            for joint in &self.joints[link.joints.clone()] {
                self.place_joint(joint, q, &mut position, &mut rotation, &mut work.axis);
            }
            work.position[i] = position;
            work.rotation[i] = rotation;
            let matrix = rotation.columns();
            let turned =
                |v: Vector<N>| matrix[0] * v.0[0] + matrix[1] * v.0[1] + matrix[2] * v.0[2];
            let center = position + turned(link.center);
            work.inertia[i] = Inertia::new(link.mass, center, link.columns.map(turned));
        }
    }

    #[inline(always)]
    fn place_joint(
        &self,
        joint: &Joint<N>,
        q: &[N],
        position: &mut Vector<N>,
        rotation: &mut Rotation<N>,
        axes: &mut [Spatial<N>],
    ) {
        let at = joint.q;
        let turning = |axis: Vector<N>, through: Vector<N>| Spatial {
            angular: axis,
            linear: through.cross(axis),
        };
        match joint.kind {
            TreeJointKind::Slide => {
                let axis = rotation.rotate(joint.axis);
                axes[joint.dof] = Spatial { angular: Vector::zero(), linear: axis };
                *position = *position + axis * (q[at] - joint.reference);
            }
            TreeJointKind::Hinge => {
                let anchor = *position + rotation.rotate(joint.anchor);
                let axis = rotation.rotate(joint.axis);
                axes[joint.dof] = turning(axis, anchor);
                *rotation = rotation.times(Rotation::about(joint.axis, q[at] - joint.reference));
                *position = anchor - rotation.rotate(joint.anchor);
            }
            TreeJointKind::Ball => {
                let anchor = *position + rotation.rotate(joint.anchor);
                let turn = Rotation([q[at], q[at + 1], q[at + 2], q[at + 3]]);
                *rotation = rotation.times(turn);
                *position = anchor - rotation.rotate(joint.anchor);
                for (k, axis) in rotation.columns().into_iter().enumerate() {
                    axes[joint.dof + k] = turning(axis, anchor);
                }
            }
            TreeJointKind::Free => {
                *position = Vector::zero();
                *rotation = Rotation([q[at + 3], q[at + 4], q[at + 5], q[at + 6]]);
                for (k, axis) in rotation.columns().into_iter().enumerate() {
                    let mut linear = Vector::zero();
                    linear.0[k] = N::one();
                    axes[joint.dof + k] = Spatial { angular: Vector::zero(), linear };
                    axes[joint.dof + 3 + k] = turning(axis, Vector::zero());
                }
            }
        }
    }

    /// Velocities of all links, and their accelerations at constant `v`; after [`Tree::place`].
    pub(crate) fn move_links(&self, v: &[N], work: &mut TreeWork<N>) {
        for (i, link) in self.links.iter().enumerate() {
            let mut velocity = link.parent.map_or_else(Spatial::zero, |p| work.velocity[p]);
            let mut drift = Spatial::zero();
            for group in &self.groups[link.groups.clone()] {
                let mut spin = Spatial::zero();
                for dof in group.clone() {
                    spin = spin + work.axis[dof] * v[dof];
                }
                drift = drift + velocity.cross_motion(spin);
                velocity = velocity + spin;
            }
            work.velocity[i] = velocity;
            work.drift[i] = drift;
        }
    }

    /// Moves the coordinates by the velocities `v` over the time `h` \[s\].
    pub(crate) fn advance(&self, q: &mut [N], v: &[N], h: N) {
        for joint in &self.joints {
            let (at, dof) = (joint.q, joint.dof);
            match joint.kind {
                TreeJointKind::Hinge | TreeJointKind::Slide => q[at] = q[at] + v[dof] * h,
                TreeJointKind::Ball => turn(&mut q[at..at + 4], &v[dof..dof + 3], h),
                TreeJointKind::Free => {
                    for k in 0..3 {
                        q[at + k] = q[at + k] + v[dof + k] * h;
                    }
                    turn(&mut q[at + 3..at + 7], &v[dof + 3..dof + 6], h);
                }
            }
        }
    }

    /// Sum of the inertias of all links, about the reference point.
    pub(super) fn whole(&self, work: &TreeWork<N>) -> Inertia<N> {
        work.inertia.iter().fold(Inertia::zero(), |sum, inertia| sum.plus(inertia))
    }

    /// Mass \[kg\] and center of mass \[m, world\]; after [`Tree::place`]. A tree without mass has
    /// it at the first link's origin.
    #[must_use]
    pub(crate) fn center_of_mass(&self, work: &TreeWork<N>) -> (N, Vector<N>) {
        let whole = self.whole(work);
        let safe = N::zero().if_less(whole.mass, whole.mass, N::one());
        (whole.mass, work.origin + whole.moment * (N::one() / safe))
    }

    /// Momentum about the reference point \[kg m²/s and kg m/s, world\]; after
    /// [`Tree::move_links`].
    #[must_use]
    pub(crate) fn momentum_about_origin(&self, work: &TreeWork<N>) -> Spatial<N> {
        let links = work.inertia.iter().zip(&work.velocity);
        links.fold(Spatial::zero(), |sum, (inertia, &velocity)| sum + inertia.times(velocity))
    }

    /// Angular momentum about the center of mass \[kg m²/s, world\], and linear momentum
    /// \[kg m/s, world\]; after [`Tree::move_links`].
    #[must_use]
    pub(crate) fn momentum(&self, work: &TreeWork<N>) -> Spatial<N> {
        let total = self.momentum_about_origin(work);
        let arm = self.center_of_mass(work).1 - work.origin;
        Spatial { angular: total.angular - arm.cross(total.linear), linear: total.linear }
    }

    /// Kinetic energy \[J\], with that of armatures; after [`Tree::move_links`] with `v`.
    #[must_use]
    pub(crate) fn kinetic_energy(&self, v: &[N], work: &TreeWork<N>) -> N {
        let links = work.inertia.iter().zip(&work.velocity);
        let moving = links.fold(N::zero(), |sum, (inertia, &u)| sum + inertia.times(u).dot(u));
        let rotors = self.dofs.iter().zip(v);
        let all = rotors.fold(moving, |sum, (dof, &rate)| sum + dof.armature * rate * rate);
        all * N::splat(0.5)
    }

    /// Kinetic energy of armatures \[J\].
    pub(crate) fn rotor_energy(&self, v: &[N]) -> N {
        let rotors = self.dofs.iter().zip(v);
        let twice = rotors.fold(N::zero(), |sum, (dof, &rate)| sum + dof.armature * rate * rate);
        twice * N::splat(0.5)
    }

    /// Kinetic energy \[J\] and momentum about the reference point, in one pass.
    pub(super) fn motion_sums(&self, v: &[N], work: &TreeWork<N>) -> (N, Spatial<N>) {
        let (mut twice, mut momentum) = (N::zero(), Spatial::zero());
        for (inertia, &u) in work.inertia.iter().zip(&work.velocity) {
            let part = inertia.times(u);
            twice = twice + part.dot(u);
            momentum = momentum + part;
        }
        for (dof, &rate) in self.dofs.iter().zip(v) {
            twice = twice + dof.armature * rate * rate;
        }
        (twice * N::splat(0.5), momentum)
    }

    /// Potential energy of gravity \[J\], 0 with all mass at the world's origin; after
    /// [`Tree::place`].
    #[must_use]
    pub(crate) fn gravity_energy(&self, work: &TreeWork<N>) -> N {
        let whole = self.whole(work);
        -(self.gravity.dot(work.origin) * whole.mass + self.gravity.dot(whole.moment))
    }

    /// Energy of the joints' springs \[J\].
    #[must_use]
    pub(crate) fn spring_energy(&self, q: &[N]) -> N {
        let mut sum = N::zero();
        for joint in self.joints.iter().filter(|joint| joint.has_spring) {
            let stretch = match joint.kind {
                TreeJointKind::Ball => ball_turn(joint, q).length(),
                _ => q[joint.q] - joint.rest,
            };
            sum = sum + self.dofs[joint.dof].stiffness * stretch * stretch;
        }
        sum * N::splat(0.5)
    }

    /// Pose of a link: its origin \[m, world\] and its rotation, if there is such a link; after
    /// [`Tree::place`].
    #[must_use]
    pub(crate) fn pose(&self, link: usize, work: &TreeWork<N>) -> Option<(Vector<N>, Rotation<N>)> {
        let rotation = *work.rotation.get(link)?;
        Some((work.origin + *work.position.get(link)?, rotation))
    }

    /// Velocity of a point of a link \[m, link\]: angular \[rad/s, world\] and linear
    /// \[m/s, world\]; after [`Tree::move_links`].
    #[must_use]
    pub(crate) fn point_velocity(
        &self,
        link: usize,
        point: Vector<N>,
        work: &TreeWork<N>,
    ) -> Option<Spatial<N>> {
        let velocity = *work.velocity.get(link)?;
        let place = work.position[link] + work.rotation[link].rotate(point);
        Some(Spatial { angular: velocity.angular, linear: velocity.at(place) })
    }

    /// Jacobian of a point of a link \[m, link\]: for each degree of freedom the angular
    /// \[rad/s, world\] and linear velocity \[m/s, world\] of the point at a rate of 1. Writes
    /// zeros where the link does not exist; after [`Tree::place`].
    pub(crate) fn jacobian(
        &self,
        link: usize,
        point: Vector<N>,
        work: &TreeWork<N>,
        out: &mut [Spatial<N>],
    ) {
        out.fill(Spatial::zero());
        if link >= self.links.len() || out.len() != self.dofs.len() {
            return;
        }
        let place = work.position[link] + work.rotation[link].rotate(point);
        for &dof in self.path_of(link) {
            let axis = work.axis[dof];
            out[dof] = Spatial { angular: axis.angular, linear: axis.at(place) };
        }
    }

    /// Degrees of freedom that move a link, from the link upward.
    pub(super) fn path_of(&self, link: usize) -> &[usize] {
        let mut at = Some(link);
        while let Some(link) = at {
            let dofs = &self.links[link].dofs;
            if !dofs.is_empty() {
                let last = dofs.end - 1;
                return &self.path[self.rows[last]..self.rows[last + 1]];
            }
            at = self.links[link].parent;
        }
        &[]
    }
}

/// Where the quaternion of a joint stands in `q`.
fn quaternion_of<N>(joint: &Joint<N>) -> Option<usize> {
    match joint.kind {
        TreeJointKind::Hinge | TreeJointKind::Slide => None,
        TreeJointKind::Ball => Some(joint.q),
        TreeJointKind::Free => Some(joint.q + 3),
    }
}

/// Rotation vector of a ball joint [rad, link].
pub(super) fn ball_turn<N: Number>(joint: &Joint<N>, q: &[N]) -> Vector<N> {
    let at = joint.q;
    Rotation([q[at], q[at + 1], q[at + 2], q[at + 3]]).vector()
}

#[inline(always)]
fn turn<N: Number>(q: &mut [N], w: &[N], h: N) {
    let by = Vector([w[0], w[1], w[2]]) * h;
    let start = Rotation([q[0], q[1], q[2], q[3]]);
    q.copy_from_slice(&start.times(Rotation::from_vector(by)).normalized().0);
}
