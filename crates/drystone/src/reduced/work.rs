//! Memory of one tree's computation: poses, velocities, the mass matrix and its factor. It is made
//! once; nothing in it outlives a call as state.

use super::number::Number;
use super::row::Rows;
use super::spatial::{Inertia, Rotation, Spatial, Vector};
use super::tree::Tree;

/// Results and scratch memory of one tree.
///
/// Positions are kept from a reference point, the origin of the first link. So precision does not
/// depend on the distance from the world's origin.
#[derive(Clone, Debug)]
pub(crate) struct TreeWork<N> {
    /// Whether links are placed, and the coordinates at which.
    pub(super) is_placed: bool,
    pub(super) placed: Vec<N>,
    /// Reference point [m, world].
    pub(super) origin: Vector<N>,
    /// Origins of links [m, world axes, from the reference point].
    pub(super) position: Vec<Vector<N>>,
    pub(super) rotation: Vec<Rotation<N>>,
    pub(super) inertia: Vec<Inertia<N>>,
    /// Inertia of each link with all its descendants, after `fill_mass_matrix`.
    pub(super) composite: Vec<Inertia<N>>,
    /// Motion by each degree of freedom at a rate of 1.
    pub(super) axis: Vec<Spatial<N>>,
    pub(super) velocity: Vec<Spatial<N>>,
    /// Acceleration of each link relative to its parent at constant rates.
    pub(super) drift: Vec<Spatial<N>>,
    pub(super) acceleration: Vec<Spatial<N>>,
    pub(super) force: Vec<Spatial<N>>,
    /// Rows of the mass matrix's lower triangle along `Tree::path`; after `factor` its factor.
    pub(super) matrix: Vec<N>,
    /// Diagonal D of the factor, with armature and implicit terms.
    pub(super) pivots: Vec<N>,
    /// √D and 1/√D.
    pub(super) root: Vec<N>,
    pub(super) root_inverse: Vec<N>,
    /// Weight of the step's end in damping and springs: 1/2 to 1.
    pub(super) theta: Vec<N>,
    /// Generalized forces of the last computation.
    pub(super) tau: Vec<N>,
    /// Least pivots of the next factor.
    pub(super) floor: Vec<N>,
    pub(super) rows: Rows<N>,
    /// Whether contacts acted in this substep, and their impulses in whitened velocities: Σ w λ.
    pub(crate) has_contacts: bool,
    pub(crate) contact_impulse: Vec<N>,
    pub(super) buffers: Buffers<N>,
}

/// Vectors over the degrees of freedom or coordinates that a step needs.
#[derive(Clone, Debug)]
pub(super) struct Buffers<N> {
    pub(super) q: Vec<N>,
    pub(super) q_start: Vec<N>,
    pub(super) v: Vec<N>,
    pub(super) v_middle: Vec<N>,
    pub(super) change: Vec<N>,
    pub(super) impulse: Vec<N>,
    pub(super) whitened: Vec<N>,
    pub(super) spring: Vec<N>,
    pub(super) row: Vec<N>,
    pub(super) v_start: Vec<N>,
}

impl<N: Number> TreeWork<N> {
    /// Memory for a tree.
    #[must_use]
    pub(crate) fn new(tree: &Tree<N>) -> Self {
        let (links, dofs, zero) = (tree.links.len(), tree.dofs.len(), N::zero());
        let rates = || vec![zero; dofs];
        let coordinates = || vec![zero; tree.q_count];
        Self {
            is_placed: false,
            placed: Vec::with_capacity(tree.q_count),
            origin: Vector::zero(),
            position: vec![Vector::zero(); links],
            rotation: vec![Rotation::identity(); links],
            inertia: vec![Inertia::zero(); links],
            composite: vec![Inertia::zero(); links],
            axis: vec![Spatial::zero(); dofs],
            velocity: vec![Spatial::zero(); links],
            drift: vec![Spatial::zero(); links],
            acceleration: vec![Spatial::zero(); links],
            force: vec![Spatial::zero(); links],
            matrix: vec![zero; tree.path.len()],
            pivots: rates(),
            root: rates(),
            root_inverse: rates(),
            theta: rates(),
            tau: rates(),
            floor: rates(),
            rows: Rows::new(),
            has_contacts: false,
            contact_impulse: rates(),
            buffers: Buffers {
                q: coordinates(),
                q_start: coordinates(),
                v: rates(),
                v_middle: rates(),
                change: rates(),
                impulse: rates(),
                whitened: rates(),
                spring: rates(),
                row: rates(),
                v_start: rates(),
            },
        }
    }
}

impl<N> Buffers<N> {
    /// No memory: it stands in while a step has the buffers.
    pub(super) const fn empty() -> Self {
        Self {
            q: Vec::new(),
            q_start: Vec::new(),
            v: Vec::new(),
            v_middle: Vec::new(),
            change: Vec::new(),
            impulse: Vec::new(),
            whitened: Vec::new(),
            spring: Vec::new(),
            row: Vec::new(),
            v_start: Vec::new(),
        }
    }
}
