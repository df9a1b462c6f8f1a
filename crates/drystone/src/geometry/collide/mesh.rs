//! A mesh against a convex solid.
//!
//! Each triangle near the solid is tested alone, seen from the side where the solid's center is. Its
//! normal may leave the face's only as far as the neighbor behind the edge allows, so a surface cut
//! into triangles pushes as if it were not cut. Contacts with nearly equal normals then share a
//! manifold. Triangles are taken in the order of their numbers: the tree's order never matters.

mod clip;
mod contacts;
mod frustum;
mod hull;
mod round;
mod triangle;

#[cfg(test)]
#[path = "mesh_tests.rs"]
mod tests;

use super::MAX_PARTS;
use crate::base::math::{Vec3, greater, lesser, vec3};
use crate::base::pose::Pose;
use crate::geometry::manifold::Manifold;
use crate::geometry::mesh::Mesh;
use crate::geometry::solid::{Core, Solid};
use clip::Clipper;
use contacts::{Contacts, Limits};
use frustum::PlacedFrustum;
use hull::PlacedHull;
use triangle::Triangle;

/// The convex solid in the frame of the mesh.
#[derive(Debug)]
enum Placed<'a> {
    Sphere(Vec3),
    Capsule([Vec3; 2]),
    Hull(PlacedHull<'a>),
    Frustum(PlacedFrustum),
}

/// The manifolds of a mesh A and a convex solid B (no half-space, no mesh), in the frame of A: at most
/// [`MAX_PARTS`], each with a normal of its own, the deepest first. Returns how many were written to
/// `out`.
pub(crate) fn collide_mesh(
    mesh: &Mesh,
    b: &Solid,
    b_in_mesh: &Pose,
    margin: f32,
    out: &mut [Manifold; MAX_PARTS],
) -> usize {
    let bounds = b.aabb(b_in_mesh).grown(margin);
    let mut near: Vec<u32> = Vec::new();
    mesh.bvh().query(&bounds, |triangle| {
        near.push(triangle);
        true
    });
    if near.is_empty() {
        return 0;
    }
    near.sort_unstable();

    let radius = b.radius;
    let (placed, center) = match &b.core {
        Core::Point => (Placed::Sphere(b_in_mesh.position), b_in_mesh.position),
        Core::Segment { half_height } => {
            let tip = b_in_mesh.direction(vec3(0.0, *half_height, 0.0));
            let at = b_in_mesh.position;
            (Placed::Capsule([at - tip, at + tip]), at)
        }
        Core::Hull(core) => {
            let placed = PlacedHull::new(core, b_in_mesh, radius);
            let center = placed.center;
            (Placed::Hull(placed), center)
        }
        Core::Frustum { half_height, radius_bottom, radius_top } => {
            let radii = [*radius_bottom, *radius_top];
            let placed = PlacedFrustum::new(b_in_mesh, *half_height, radii, radius);
            (Placed::Frustum(placed), b_in_mesh.position)
        }
        Core::HalfSpace { .. } | Core::Mesh(_) => return 0,
    };
    let mut contacts = Contacts::new(limits(b, margin));
    let mut clipper = Clipper::default();
    for number in near {
        let triangle = Triangle::new(mesh, number, center);
        match &placed {
            Placed::Sphere(at) => round::sphere(&triangle, *at, radius, &mut contacts),
            Placed::Capsule(ends) => {
                round::capsule(&triangle, *ends, radius, &mut contacts, &mut clipper);
            }
            Placed::Hull(body) => hull::hull(&triangle, body, &mut contacts, &mut clipper),
            Placed::Frustum(body) => {
                frustum::frustum(&triangle, body, &mut contacts, &mut clipper);
            }
        }
    }
    contacts.reduce(out)
}

fn limits(b: &Solid, margin: f32) -> Limits {
    let (least, most) = match &b.core {
        Core::Hull(hull) => {
            let half = hull.bounds().half_extents();
            (half.min_element(), half.max_element())
        }
        Core::Frustum { half_height, radius_bottom, radius_top } => {
            let wide = greater(*radius_bottom, *radius_top);
            (lesser(*half_height, wide), greater(*half_height, wide))
        }
        _ => (b.radius, b.radius),
    };
    // Long for its size, but never coarse for the thinnest side.
    let size = lesser(most, 20.0 * least);
    Limits {
        margin,
        merge: 1.0e-3 * size + 1.0e-6,
        bias: 5.0e-4 * size,
        // The gap over an edge that counts as flat is that turn times the height of the core.
        doubt: 2.0e-2 * size,
        slack: 1.0e-4 * size + 5.0e-3 * (b.radius + margin),
    }
}
