//! Two solids at given poses to a manifold: the dispatch table.

pub(crate) mod mesh;

pub(crate) use mesh::collide_mesh;

use super::manifold::Manifold;
use super::solid::Solid;
use crate::base::math::Vec3;
use crate::base::pose::Pose;

/// What a pair remembers from its last test, to begin the next one there. Any value is valid: it
/// only changes how long the test takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PairCache {
    /// Which kind of axis separated the pair or carried the contact; 0 = nothing known.
    pub(crate) kind: u8,
    /// Feature numbers of A and B of that axis.
    pub(crate) a: u16,
    pub(crate) b: u16,
    /// For axes that are not features: the axis [frame of A].
    pub(crate) axis: Vec3,
}

/// Most manifolds of one pair with a mesh.
pub(crate) const MAX_PARTS: usize = 4;

/// The manifold of two convex solids (half-spaces included, meshes not), in the frame of A. Points
/// farther apart than `margin` [m] are left out; no points: no contact.
pub(crate) fn collide(
    a: &Solid,
    b: &Solid,
    b_in_a: &Pose,
    margin: f32,
    cache: &mut PairCache,
) -> Manifold {
    use super::solid::Core;
    match (&a.core, &b.core) {
        (Core::Hull(x), Core::Hull(y)) => {
            super::sat::collide_polytopes(x.polytope(), y.polytope(), b_in_a, margin, cache)
        }
        _ => Manifold::default(),
    }
}
