//! Forward dynamics by articulated bodies [Featherstone08], chapter 7: linear in the number of
//! links, where the factor of the mass matrix is cubic along a chain.
//!
//! Several degrees of freedom of a link are eliminated one after another. Since all vectors stand
//! in world axes at one point, an elimination is a rank-one change of the link's inertia.

use super::number::Number;
use super::spatial::{Spatial, Symmetric, Vector};
use super::tree::Tree;
use super::work::TreeWork;

/// Articulated inertia: [A B; Bᵀ C], with A and C symmetric.
#[derive(Clone, Copy, Debug)]
struct Articulated<N> {
    a: Symmetric<N>,
    /// Rows of B.
    b: [Vector<N>; 3],
    c: Symmetric<N>,
}

impl<N: Number> Articulated<N> {
    #[inline(always)]
    fn times(&self, m: Spatial<N>) -> Spatial<N> {
        let (w, v) = (m.angular, m.linear);
        let [b0, b1, b2] = self.b;
        let transposed = b0 * w.0[0] + b1 * w.0[1] + b2 * w.0[2];
        Spatial {
            angular: self.a.times(w) + Vector([b0.dot(v), b1.dot(v), b2.dot(v)]),
            linear: transposed + self.c.times(v),
        }
    }

    /// Subtracts `u uᵀ s`.
    #[inline(always)]
    fn reduce(&mut self, u: Spatial<N>, s: N) {
        self.a.add_outer(u.angular, u.angular, -s);
        self.c.add_outer(u.linear, u.linear, -s);
        for k in 0..3 {
            self.b[k] = self.b[k] - u.linear * (u.angular.0[k] * s);
        }
    }

    #[inline(always)]
    fn add(&mut self, o: &Self) {
        for k in 0..6 {
            self.a.0[k] = self.a.0[k] + o.a.0[k];
            self.c.0[k] = self.c.0[k] + o.c.0[k];
        }
        for k in 0..3 {
            self.b[k] = self.b[k] + o.b[k];
        }
    }
}

/// Memory of the algorithm.
#[derive(Clone, Debug)]
pub(crate) struct ArticulatedWork<N> {
    inertia: Vec<Articulated<N>>,
    bias: Vec<Spatial<N>>,
    /// I S of each degree of freedom, 1/(Sᵀ I S), and the force along it.
    response: Vec<Spatial<N>>,
    inverse: Vec<N>,
    rest: Vec<N>,
}

impl<N: Number> ArticulatedWork<N> {
    /// Memory for a tree.
    #[must_use]
    pub(crate) fn new(tree: &Tree<N>) -> Self {
        let none =
            Articulated { a: Symmetric::zero(), b: [Vector::zero(); 3], c: Symmetric::zero() };
        let (links, dofs) = (tree.links.len(), tree.dofs.len());
        Self {
            inertia: vec![none; links],
            bias: vec![Spatial::zero(); links],
            response: vec![Spatial::zero(); dofs],
            inverse: vec![N::zero(); dofs],
            rest: vec![N::zero(); dofs],
        }
    }
}

impl<N: Number> Tree<N> {
    /// The acceleration \[rad/s² or m/s²\] at generalized forces `tau` \[N m or N\], by articulated
    /// bodies; after [`Tree::move_links`]. `extra` is added to each degree of freedom's inertia,
    /// such as h d + h² k of an implicit step; armature is in it already.
    pub(crate) fn accelerate(
        &self,
        tau: &[N],
        extra: &[N],
        work: &mut TreeWork<N>,
        memory: &mut ArticulatedWork<N>,
        out: &mut [N],
    ) {
        for (i, inertia) in work.inertia.iter().enumerate() {
            let [x, y, z] = inertia.moment.0;
            let (m, zero) = (inertia.mass, N::zero());
            memory.inertia[i] = Articulated {
                a: inertia.about,
                b: [Vector([zero, -z, y]), Vector([z, zero, -x]), Vector([-y, x, zero])],
                c: Symmetric([m, m, m, zero, zero, zero]),
            };
            let velocity = work.velocity[i];
            memory.bias[i] = velocity.cross_force(inertia.times(velocity));
        }
        for (i, link) in self.links.iter().enumerate().rev() {
            let mut inertia = memory.inertia[i];
            let mut reduced = Spatial::zero();
            let bias = memory.bias[i];
            for dof in link.dofs.clone().rev() {
                let axis = work.axis[dof];
                let response = inertia.times(axis);
                let sum = axis.dot(response) + self.dofs[dof].armature + extra[dof];
                let inverse = N::one() / sum;
                let rest = tau[dof] - axis.dot(bias + reduced);
                inertia.reduce(response, inverse);
                reduced = reduced + response * (rest * inverse);
                memory.response[dof] = response;
                memory.inverse[dof] = inverse;
                memory.rest[dof] = rest;
            }
            if let Some(parent) = link.parent {
                let force = bias + reduced + inertia.times(work.drift[i]);
                memory.bias[parent] = memory.bias[parent] + force;
                memory.inertia[parent].add(&inertia);
            }
        }
        let gravity = Spatial { angular: Vector::zero(), linear: -self.gravity };
        for (i, link) in self.links.iter().enumerate() {
            let mut acceleration =
                link.parent.map_or(gravity, |p| work.acceleration[p]) + work.drift[i];
            for dof in link.dofs.clone() {
                let rest = memory.rest[dof] - memory.response[dof].dot(acceleration);
                let rate = rest * memory.inverse[dof];
                out[dof] = rate;
                acceleration = acceleration + work.axis[dof] * rate;
            }
            work.acceleration[i] = acceleration;
        }
    }
}
