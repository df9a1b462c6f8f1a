//! A mesh against a convex solid.
//!
//! Each triangle near the solid is tested alone, seen from the side of the solid's center. Its
//! normal may deviate from the face normal only as far as the neighbor behind the edge allows. A
//! surface cut into triangles therefore pushes as if it were not cut. Contacts with nearly equal
//! normals then share a manifold. Triangles are processed in the order of their numbers: the tree's
//! order never matters.
//!
//! The functions for a triangle against a polytope are inlined into a single dispatch per test. All
//! of them are then compiled for the machine's lanes, and no call spills registers.

mod clip;
mod contacts;
mod frustum;
mod hull;
mod near;
mod placed;
mod round;
mod select;
mod triangle;

#[cfg(test)]
#[path = "mesh_tests.rs"]
mod tests;

use fearless_simd::{Level, Simd, dispatch};

use super::MAX_PARTS;
use crate::base::math::{Vec3, greater, lesser, vec3};
use crate::base::pose::Pose;
use crate::geometry::manifold::Manifold;
use crate::geometry::mesh::Mesh;
use crate::geometry::solid::{Core, Solid};
use clip::Clipper;
use contacts::{Contacts, Limits};
use frustum::PlacedFrustum;
pub(crate) use near::Reach;
use near::{Discs, Near, Outline};
use placed::{PlacedHull, Row, Space};
use triangle::Triangle;

/// The convex solid in the frame of the mesh.
#[derive(Debug)]
enum Placed<'a> {
    Sphere(Vec3),
    Capsule([Vec3; 2]),
    Hull(PlacedHull<'a>),
    Frustum(PlacedFrustum),
}

/// Scratch memory, reused from test to test; its content is valid within one test only.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshScratch {
    stack: Vec<u32>,
    packs: Vec<u32>,
    near: Vec<Near>,
    space: Space,
    contacts: Contacts,
    clipper: Clipper,
}

/// Computes the manifolds of a mesh A and a convex solid B (no half-space, no mesh), in the frame
/// of A. There are at most [`MAX_PARTS`], each with its own normal, the deepest first. Returns the
/// number of manifolds written to `out`. The first one has the [`Manifold::gap`].
pub(crate) fn collide_mesh(
    level: Level,
    mesh: &Mesh,
    b: &Solid,
    b_in_mesh: &Pose,
    reach: &Reach,
    scratch: &mut MeshScratch,
    out: &mut [Manifold; MAX_PARTS],
) -> usize {
    dispatch!(level, simd => {
        let [gap, unseen] = collect(simd, mesh, b, b_in_mesh, reach, scratch);
        let count = if scratch.near.is_empty() { 0 } else { scratch.contacts.reduce(simd, out) };
        if count == 0 {
            out[0] = Manifold::apart(greater(gap, 0.0));
        } else {
            out[0].gap = unseen;
        }
        count
    })
}

/// Collects the contacts of the triangles near the solid. Returns lower bounds on its distance from
/// all triangles, and from all parts without points [m].
#[inline(always)]
fn collect<S: Simd>(
    simd: S,
    mesh: &Mesh,
    b: &Solid,
    b_in_mesh: &Pose,
    reach: &Reach,
    scratch: &mut MeshScratch,
) -> [f32; 2] {
    let MeshScratch { stack, packs, near, space, contacts, clipper } = scratch;
    let (radius, at) = (b.radius, b_in_mesh.position);
    near.clear();
    let mut placed = match &b.core {
        Core::Point => Placed::Sphere(at),
        Core::Segment { half_height } => {
            let tip = b_in_mesh.direction(vec3(0.0, *half_height, 0.0));
            Placed::Capsule([at - tip, at + tip])
        }
        Core::Hull(core) => Placed::Hull(PlacedHull::new(simd, core, b_in_mesh, radius, space)),
        Core::Frustum { half_height, radius_bottom, radius_top } => {
            let radii = [*radius_bottom, *radius_top];
            Placed::Frustum(PlacedFrustum::new(b_in_mesh, *half_height, radii, radius))
        }
        Core::HalfSpace { .. } | Core::Mesh(_) => return [0.0; 2],
    };
    let bounds = match &placed {
        Placed::Hull(hull) if !hull.is_cuboid() => hull.bounds(simd),
        _ => b.aabb(b_in_mesh),
    };
    let core = b.core_box();
    let turn = b_in_mesh.rotation.to_mat3();
    let core = (b_in_mesh.point(core.center()), [turn.x, turn.y, turn.z], core.half_extents());
    let (ends, caps);
    let (center, points, discs, planes): (Vec3, &[Row], Option<Discs>, &[Row]) = match &placed {
        Placed::Sphere(_) => {
            ends = [row(Vec3::ZERO, 0.0); 2];
            (at, &ends[..1], None, &[])
        }
        Placed::Capsule([a, b]) => {
            ends = [row(*a - at, 0.0), row(*b - at, 0.0)];
            (at, &ends, None, &[])
        }
        Placed::Hull(hull) => (hull.center, hull.arms(), None, hull.planes()),
        Placed::Frustum(frustum) => {
            let ([a, b], discs, [c, d]) = frustum.outline();
            ends = [row(a - at, 0.0), row(b - at, 0.0)];
            caps = [row(c.normal, c.offset), row(d.normal, d.offset)];
            (at, &ends, Some(discs), &caps)
        }
    };
    let outline = Outline { bounds, core, center, points, discs, planes, radius };
    let mut gap = near::find(simd, mesh, &outline, reach, [stack, packs], near);
    if near.is_empty() {
        return [gap; 2];
    }
    contacts.restart(limits(b, reach));
    let mut unseen = gap;
    for near in near.iter() {
        let triangle = Triangle::new(mesh, *near, center);
        let apart = match &mut placed {
            Placed::Sphere(at) => round::sphere(&triangle, *at, radius, contacts),
            Placed::Capsule(ends) => round::capsule(&triangle, *ends, radius, contacts, clipper),
            Placed::Hull(body) => hull::hull(simd, &triangle, body, contacts, clipper),
            Placed::Frustum(body) => frustum::frustum(&triangle, body, contacts, clipper),
        };
        let known = greater(near.apart, apart.unwrap_or(0.0));
        gap = lesser(gap, known);
        let next = match (apart, &placed) {
            (None, Placed::Hull(body)) => body.next_above(simd, &triangle, reach.margin),
            (None, _) => reach.margin,
            (Some(_), _) => known,
        };
        unseen = lesser(unseen, next);
    }
    [gap, unseen]
}

fn row(v: Vec3, w: f32) -> Row {
    [v.x, v.y, v.z, w]
}

fn limits(b: &Solid, reach: &Reach) -> Limits {
    let margin = reach.margin;
    let (minimum, maximum) = match &b.core {
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
    // A long solid has a large size, but the thinnest side limits it.
    let size = lesser(maximum, 20.0 * minimum);
    Limits {
        margin,
        displacement: reach.displacement,
        straight: if reach.is_straight { reach.displacement } else { Vec3::ZERO },
        corners: reach.corners,
        merge: 1.0e-3 * size + reach.grain,
        bias: 5.0e-4 * size,
        // The gap over an edge that counts as flat is that angle times the height of the core.
        doubt: 2.0e-2 * size,
        slack: 1.0e-4 * size + 5.0e-3 * (b.radius + margin),
    }
}
