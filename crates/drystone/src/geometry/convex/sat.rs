//! Collides two polytopes: separating axes, then clipping [Gregorius13].

mod edges;
mod search;

use fearless_simd::{Level, dispatch};

use self::edges::EdgeAxis;
pub(crate) use self::edges::PARALLEL;
use self::search::{Pair, Verdict};
use super::clip::{Polygon, Reference, clip, closest_of_segments, flip, low_corners};
use super::gjk;
use crate::base::math::{Vec3, greater};
use crate::base::pose::Pose;
use crate::geometry::hull::Hull;
use crate::geometry::manifold::{EDGE_PAIR, Manifold, PairCache, REFERENCE_B};

/// Amount by which a later kind of axis must be better than an earlier one, relative to the size.
/// Without it rounding would choose, and feature ids would flicker.
pub(crate) const PREFERENCE: f32 = 1.0e-3;

/// Computes the manifold of two hulls in the frame of A. Points farther apart than `margin` [m] are
/// left out.
pub(crate) fn collide_hulls(
    level: Level,
    a: &Hull,
    b: &Hull,
    b_in_a: &Pose,
    margin: f32,
    cache: &mut PairCache,
) -> Manifold {
    let slack = PREFERENCE * thinness(a, b);
    let found =
        dispatch!(level, simd => Pair::new(a, b, b_in_a).search(simd, margin, slack, cache));
    let axes = match found {
        Verdict::Apart(gap) => return Manifold::apart(gap),
        Verdict::Axes(axes) => axes,
    };
    if let Some(e) = axes.edges {
        return edge_contact(a, b, b_in_a, &e);
    }
    let of_faces = greater(axes.face_a.separation, axes.face_b.separation);
    let m = if axes.face_b.separation > axes.face_a.separation + slack {
        let a_in_b = b_in_a.inverse();
        flip(&face_contact(level, b, a, &a_in_b, axes.face_b.face, margin, REFERENCE_B), b_in_a)
    } else {
        face_contact(level, a, b, b_in_a, axes.face_a.face, margin, 0)
    };
    if m.count > 0 { m } else { beside_the_face(a, b, b_in_a, margin, m.normal, of_faces) }
}

/// Half the minimum width of the thinner hull, measured from its center; flat hulls do not count.
fn thinness(a: &Hull, b: &Hull) -> f32 {
    let (thin, thick) = if a.inner < b.inner { (a.inner, b.inner) } else { (b.inner, a.inner) };
    if thin > 1.0e-3 * thick { thin } else { thick }
}

/// Writes the corners of a face; every k-th corner of a very large one.
pub(crate) fn face_polygon(x: &Hull, face: usize, out: &mut Polygon) {
    out.clear();
    let Some(&first) = x.face_edges.get(face) else { return };
    let mut count = x.longest_face;
    let mut stride = Polygon::stride(count);
    if stride > 1 {
        count = x.corners_of(face);
        stride = Polygon::stride(count);
    }
    let mut e = first;
    for k in 0..count {
        let edge = x.edges[usize::from(e)];
        if k % stride == 0 {
            out.add(x.vertices[usize::from(edge.origin)], u32::from(edge.origin));
        }
        e = edge.next;
        if e == first {
            break;
        }
    }
}

/// Returns the face whose normal is farthest along `direction`.
#[inline]
pub(crate) fn face_along(x: &Hull, direction: Vec3) -> usize {
    x.lanes.face_along(direction)
}

/// Contact of face `face` of A with the face of B that is most opposite to it.
fn face_contact(
    level: Level,
    a: &Hull,
    b: &Hull,
    b_in_a: &Pose,
    face: usize,
    margin: f32,
    flag: u32,
) -> Manifold {
    let plane = a.planes[face];
    let n = plane.normal;
    let seen = b_in_a.local_direction(n);
    let incident_face = dispatch!(level, simd => b.lanes.face_against(simd, seen));
    let (mut reference, mut incident) = (Polygon::empty(), Polygon::empty());
    face_polygon(a, face, &mut reference);
    face_polygon(b, incident_face, &mut incident);
    incident.transform(b_in_a);
    let low = low_corners(b, b_in_a, n, plane.offset, margin);
    let reference = Reference { corners: reference.corners(), normal: n, offset: plane.offset };
    clip(&reference, &mut incident, &low, margin, flag)
}

fn edge_contact(a: &Hull, b: &Hull, b_in_a: &Pose, e: &EdgeAxis) -> Manifold {
    let ends = |x: &Hull, k: usize| {
        [x.edges[k], x.edges[k + 1]].map(|h| x.vertices[usize::from(h.origin)])
    };
    let edge_b = ends(b, e.b).map(|p| b_in_a.point(p));
    let (on_a, on_b) = closest_of_segments(ends(a, e.a), edge_b);
    let normal = b_in_a.direction(e.normal);
    #[expect(clippy::cast_possible_truncation, reason = "fewer than 2^15 edges")]
    let feature = EDGE_PAIR | (e.a as u32 & 0x7fff) << 15 | (e.b as u32 & 0x7fff);
    Manifold::single(normal, (on_a + on_b) * 0.5, e.separation, feature)
}

/// Contact where no axis separates by more than the margin and yet nothing is above the face:
/// corners or edges pass beside it. The true closest points decide. If the polytopes overlap after
/// all, the corner of B that is deepest along the face normal `n` decides, at the separation of the
/// faces.
fn beside_the_face(
    a: &Hull,
    b: &Hull,
    b_in_a: &Pose,
    margin: f32,
    n: Vec3,
    of_faces: f32,
) -> Manifold {
    let closest = gjk::distance(
        |d| support(a, d),
        |d| b_in_a.point(support(b, b_in_a.local_direction(d))),
        b_in_a.point(b.center) - a.center,
    );
    match closest {
        Some(c) if c.distance > margin => Manifold::apart(c.distance),
        Some(c) => Manifold::single(c.normal, (c.point_a + c.point_b) * 0.5, c.distance, EDGE_PAIR),
        None if of_faces <= 0.0 => {
            let corner = b_in_a.point(support(b, -b_in_a.local_direction(n)));
            Manifold::single(n, corner - n * (0.5 * of_faces), of_faces, EDGE_PAIR)
        }
        _ => Manifold::default(),
    }
}

/// Returns the vertex farthest along `direction`.
#[inline]
pub(crate) fn support(x: &Hull, direction: Vec3) -> Vec3 {
    x.vertices[x.lanes.farthest_along(direction)]
}
