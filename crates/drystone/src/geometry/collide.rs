//! Computes the manifold of two solids at given poses: the dispatch table.

mod boxes;
pub(crate) mod convex;
pub(crate) mod frustum;
mod general;
mod half_space;
pub(crate) mod mesh;
mod round;
#[cfg(test)]
mod rest_tests;
#[cfg(test)]
pub(super) mod tests;

use fearless_simd::Level;

use self::convex::Convex;
pub(crate) use self::mesh::{MeshScratch, Reach, collide_mesh};
use super::convex::clip::flip;
use super::convex::sat;
use super::manifold::{Manifold, PairCache};
use super::solid::{Core, Solid};
use crate::base::math::{Vec3, greater};
use crate::base::pose::Pose;

/// Maximum number of manifolds of one pair with a mesh.
pub(crate) const MAX_PARTS: usize = 4;

/// Computes the manifold of two convex solids (half-spaces included, meshes not), in the frame of
/// A. Points farther apart than `margin` [m] are left out; a manifold without points means no
/// contact.
pub(crate) fn collide(
    level: Level,
    a: &Solid,
    b: &Solid,
    b_in_a: &Pose,
    margin: f32,
    cache: &mut PairCache,
) -> Manifold {
    if !b_in_a.is_finite() {
        return Manifold::default();
    }
    // Radii move the surfaces along the normal, so the cores may be farther apart by the radii.
    let reach = margin + a.radius + b.radius;
    let m = match (&a.core, &b.core) {
        (Core::HalfSpace { normal, offset }, other) => match Convex::of(other) {
            Some(other) => half_space::collide(*normal, *offset, &other, b_in_a, reach),
            None => Manifold::default(),
        },
        (other, Core::HalfSpace { normal, offset }) => match Convex::of(other) {
            Some(other) => {
                let m = half_space::collide(*normal, *offset, &other, &b_in_a.inverse(), reach);
                flip(&m, b_in_a)
            }
            None => Manifold::default(),
        },
        (core_a, core_b) => match (Convex::of(core_a), Convex::of(core_b)) {
            (Some(x), Some(y)) => {
                collide_convex(level, &x, &y, b_in_a, reach, reach > margin, cache)
            }
            _ => Manifold::default(),
        },
    };
    rounded(m, a.radius, b.radius)
}

/// Collides two bounded convex cores. Each pair of kinds has one order; the other order is flipped.
/// Rounded hulls touch with their corners and edges too, so they need the true distance.
pub(crate) fn collide_convex(
    level: Level,
    a: &Convex<'_>,
    b: &Convex<'_>,
    b_in_a: &Pose,
    margin: f32,
    is_rounded: bool,
    cache: &mut PairCache,
) -> Manifold {
    if kind_order(a) > kind_order(b) {
        // The cache stores features of hulls: only pairs of hulls read it, and these keep their
        // order.
        let m = collide_convex(level, b, a, &b_in_a.inverse(), margin, is_rounded, cache);
        return flip(&m, b_in_a);
    }
    match (a, b) {
        (Convex::Point, Convex::Point) => round::points(b_in_a.position, margin),
        (Convex::Point, Convex::Segment { half_height }) => {
            round::point_segment(*half_height, b_in_a, margin)
        }
        (Convex::Segment { half_height: x }, Convex::Segment { half_height: y }) => {
            round::segments(*x, *y, b_in_a, margin)
        }
        (Convex::Point, Convex::Frustum(frustum)) => {
            // In the frame of the frustum.
            let m = frustum.against_point(b_in_a.local_point(Vec3::ZERO), margin);
            flip(&m, b_in_a)
        }
        (Convex::Point, Convex::Hull(x)) => round::point_face(x, b_in_a, margin)
            .unwrap_or_else(|| general::collide(a, b, b_in_a, margin)),
        (Convex::Hull(x), Convex::Hull(y)) => {
            if is_rounded && let Some(m) = general::collide_apart(a, b, b_in_a, margin) {
                return m;
            }
            if let (Some(g), Some(h)) = (x.cuboid, y.cuboid)
                && let Some(m) = boxes::collide(g, h, b_in_a, margin)
            {
                return m;
            }
            sat::collide_hulls(level, x, y, b_in_a, margin, cache)
        }
        _ => general::collide(a, b, b_in_a, margin),
    }
}

const fn kind_order(x: &Convex<'_>) -> u8 {
    match x {
        Convex::Point => 0,
        Convex::Segment { .. } => 1,
        Convex::Hull(_) => 2,
        Convex::Frustum(_) => 3,
    }
}

/// Adds the radii to the manifold of the cores.
fn rounded(mut m: Manifold, radius_a: f32, radius_b: f32) -> Manifold {
    if radius_a + radius_b <= 0.0 {
        return m;
    }
    let middle = m.normal * (0.5 * (radius_a - radius_b));
    for p in &mut m.points[..m.count] {
        p.separation -= radius_a + radius_b;
        p.position += middle;
    }
    m.gap = greater(m.gap - (radius_a + radius_b), 0.0);
    m
}
