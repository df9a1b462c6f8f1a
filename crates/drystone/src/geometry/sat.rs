//! Two polytopes to a manifold: separating axes, then clipping [Gregorius13].
//!
//! Symbols: u, v normals of the two faces at an edge, d the edge's direction; R, t rotation and
//! position of B in the frame of A.

use super::clip::{Polygon, Reference, clip, closest_of_segments, flip};
use super::gjk;
use super::hull::{HalfEdge, Polytope};
use super::manifold::Manifold;
use super::manifold::PairCache;
use crate::base::math::{Mat3, Vec3, greater, lesser};
use crate::base::pose::Pose;

const FACE_A: u8 = 1;
const FACE_B: u8 = 2;
const EDGES: u8 = 3;

/// Feature ids begin with what the reference is.
const REFERENCE_B: u32 = 0x8000_0000;
const EDGE_PAIR: u32 = 0x4000_0000;

/// Squared sine below which two edges count as parallel (0.3°): the axes of faces serve there.
const PARALLEL: f32 = 2.5e-5;

/// Part of the size by which a later kind of axis must be better than an earlier one: without it
/// rounding would choose, and feature ids would flicker.
const PREFERENCE: f32 = 1.0e-3;

/// Rotation and position of B in the frame of A.
#[derive(Clone, Copy)]
struct Frames {
    r: Mat3,
    t: Vec3,
}

#[derive(Clone, Copy)]
struct FaceAxis {
    face: usize,
    separation: f32,
}

#[derive(Clone, Copy)]
struct EdgeAxis {
    /// Half-edges of A and of B.
    a: usize,
    b: usize,
    separation: f32,
    /// Unit, from A to B [frame of B].
    normal: Vec3,
}

/// The manifold of two polytopes in the frame of A. Points farther apart than `margin` [m] are left
/// out.
pub(crate) fn collide_polytopes(
    a: Polytope<'_>,
    b: Polytope<'_>,
    b_in_a: &Pose,
    margin: f32,
    cache: &mut PairCache,
) -> Manifold {
    let r = b_in_a.rotation.to_mat3();
    let b_frames = Frames { r, t: b_in_a.position };
    let rt = r.transpose();
    let a_frames = Frames { r: rt, t: -(rt * b_in_a.position) };
    if cached_axis_separates(a, b, &b_frames, &a_frames, margin, *cache) {
        return Manifold::default();
    }
    let face_a = best_face(a, b, &b_frames, margin);
    if face_a.separation > margin {
        remember(cache, FACE_A, face_a.face, 0);
        return Manifold::default();
    }
    let face_b = best_face(b, a, &a_frames, margin);
    if face_b.separation > margin {
        remember(cache, FACE_B, 0, face_b.face);
        return Manifold::default();
    }
    let slack = PREFERENCE * thinness(a, b);
    let edges = best_edges(a, b, &a_frames, margin);
    let of_faces = greater(face_a.separation, face_b.separation);
    if let Some(e) = edges
        && e.separation > of_faces + slack
    {
        remember(cache, EDGES, e.a, e.b);
        return if e.separation > margin {
            Manifold::default()
        } else {
            edge_contact(a, b, b_in_a, &e)
        };
    }
    let m = if face_b.separation > face_a.separation + slack {
        remember(cache, FACE_B, 0, face_b.face);
        let a_in_b = Pose { position: a_frames.t, rotation: b_in_a.rotation.conjugate() };
        flip(&face_contact(b, a, &a_in_b, face_b.face, margin, REFERENCE_B), b_in_a)
    } else {
        remember(cache, FACE_A, face_a.face, 0);
        face_contact(a, b, b_in_a, face_a.face, margin, 0)
    };
    if m.count > 0 { m } else { beside_the_face(a, b, b_in_a, margin, m.normal, of_faces) }
}

#[expect(clippy::cast_possible_truncation, reason = "hulls have fewer than 2^16 features")]
fn remember(cache: &mut PairCache, kind: u8, a: usize, b: usize) {
    (cache.kind, cache.a, cache.b) = (kind, a as u16, b as u16);
}

/// Exactly one of the tests that the full search would make, so that the answer is the same.
fn cached_axis_separates(
    a: Polytope<'_>,
    b: Polytope<'_>,
    b_frames: &Frames,
    a_frames: &Frames,
    margin: f32,
    cache: PairCache,
) -> bool {
    let (i, j) = (usize::from(cache.a), usize::from(cache.b));
    match cache.kind {
        FACE_A if i < a.planes.len() => face_separation(a, b, b_frames, i) > margin,
        FACE_B if j < b.planes.len() => face_separation(b, a, a_frames, j) > margin,
        EDGES if (i | 1) < a.edges.len() && (j | 1) < b.edges.len() => {
            let edge = EdgeOf::new(a, a_frames, i & !1);
            let (e, twin) = (b.edges[j & !1], b.edges[j | 1]);
            let p = normal_of(b, e).dot(edge.d);
            let q = normal_of(b, twin).dot(edge.d);
            edge.against(b, j & !1, p, q).is_some_and(|x| x.separation > margin)
        }
        _ => false,
    }
}

#[inline]
fn face_separation(a: Polytope<'_>, b: Polytope<'_>, frames: &Frames, face: usize) -> f32 {
    let plane = a.planes[face];
    let n = frames.r.transpose_mul(plane.normal);
    let mut least = f32::INFINITY;
    for v in b.vertices {
        least = lesser(n.dot(*v), least);
    }
    least + plane.normal.dot(frames.t) - plane.offset
}

/// The face of `a` that separates most; the search ends at the first beyond `margin`.
fn best_face(a: Polytope<'_>, b: Polytope<'_>, frames: &Frames, margin: f32) -> FaceAxis {
    let mut best = FaceAxis { face: 0, separation: f32::NEG_INFINITY };
    for face in 0..a.planes.len() {
        let separation = face_separation(a, b, frames, face);
        if separation > best.separation {
            best = FaceAxis { face, separation };
            if separation > margin {
                break;
            }
        }
    }
    best
}

/// Half the least width of the thinner polytope, seen from its center; triangles do not count.
fn thinness(a: Polytope<'_>, b: Polytope<'_>) -> f32 {
    let of = |x: Polytope<'_>| {
        x.planes.iter().map(|p| -p.distance(x.center)).fold(f32::INFINITY, lesser)
    };
    let (in_a, in_b) = (of(a), of(b));
    let (thin, thick) = if in_a < in_b { (in_a, in_b) } else { (in_b, in_a) };
    greater(if thin > 1.0e-3 * thick { thin } else { thick }, 0.0)
}

fn normal_of(x: Polytope<'_>, e: HalfEdge) -> Vec3 {
    x.planes[usize::from(e.face)].normal
}

/// An edge of A with what the test against edges of B needs, in the frame of B.
struct EdgeOf {
    edge: usize,
    tail: Vec3,
    d: Vec3,
    u: Vec3,
    v: Vec3,
}

impl EdgeOf {
    #[inline]
    fn new(a: Polytope<'_>, a_frames: &Frames, edge: usize) -> Self {
        let (e, twin) = (a.edges[edge], a.edges[edge + 1]);
        let tail = a.vertices[usize::from(e.origin)];
        let head = a.vertices[usize::from(twin.origin)];
        Self {
            edge,
            tail: a_frames.r * tail + a_frames.t,
            d: a_frames.r * (head - tail),
            u: a_frames.r * normal_of(a, e),
            v: a_frames.r * normal_of(a, twin),
        }
    }

    /// The axis of a pair of edges if they build a face of the Minkowski difference: the arcs u to v
    /// and -u' to -v' on the Gauss map cross. p = u'·d, q = v'·d. As d points along u × v, the arcs
    /// cross iff pq < 0, (u·d')(v·d') < 0 and p (u·d') > 0; then A's outward axis is
    /// sign(u·d') d × d'.
    #[inline]
    fn against(&self, b: Polytope<'_>, edge_b: usize, p: f32, q: f32) -> Option<EdgeAxis> {
        if p * q >= 0.0 {
            return None;
        }
        let (e, twin) = (b.edges[edge_b], b.edges[edge_b + 1]);
        let tail = b.vertices[usize::from(e.origin)];
        let d = b.vertices[usize::from(twin.origin)] - tail;
        let (r, s) = (self.u.dot(d), self.v.dot(d));
        if !(r * s < 0.0 && p * r > 0.0) {
            return None;
        }
        let axis = self.d.cross(d);
        let square = axis.length_squared();
        if square <= PARALLEL * self.d.length_squared() * d.length_squared() {
            return None;
        }
        let k = 1.0 / square.sqrt();
        let normal = axis * if r > 0.0 { k } else { -k };
        let separation = normal.dot(tail - self.tail);
        Some(EdgeAxis { a: self.edge, b: edge_b, separation, normal })
    }
}

/// The pair of edges that separates most; the search ends at the first beyond `margin`.
fn best_edges(
    a: Polytope<'_>,
    b: Polytope<'_>,
    a_frames: &Frames,
    margin: f32,
) -> Option<EdgeAxis> {
    // u'·d for the faces of B: three dot products fewer for each pair of edges.
    const TABLE: usize = 64;
    let mut row = [0.0_f32; TABLE];
    let tabled = b.planes.len() <= TABLE;
    let mut best: Option<EdgeAxis> = None;
    for i in (0..a.edges.len() & !1).step_by(2) {
        let edge = EdgeOf::new(a, a_frames, i);
        if tabled {
            for (x, plane) in row.iter_mut().zip(b.planes) {
                *x = plane.normal.dot(edge.d);
            }
        }
        for (k, pair) in b.edges.chunks_exact(2).enumerate() {
            let (f, g) = (usize::from(pair[0].face), usize::from(pair[1].face));
            let (p, q) = if tabled {
                (row[f & (TABLE - 1)], row[g & (TABLE - 1)])
            } else {
                (b.planes[f].normal.dot(edge.d), b.planes[g].normal.dot(edge.d))
            };
            let Some(axis) = edge.against(b, 2 * k, p, q) else { continue };
            if best.is_none_or(|x| axis.separation > x.separation) {
                best = Some(axis);
                if axis.separation > margin {
                    return best;
                }
            }
        }
    }
    best
}

/// The corners of a face; every k-th of a very large one.
pub(crate) fn face_polygon(x: Polytope<'_>, face: usize, out: &mut Polygon) {
    out.clear();
    let Some(&first) = x.face_edges.get(face) else { return };
    let mut count = 0;
    let mut e = first;
    while count < x.edges.len() {
        count += 1;
        e = x.edges[usize::from(e)].next;
        if e == first {
            break;
        }
    }
    let stride = Polygon::stride(count);
    for k in 0..count {
        let edge = x.edges[usize::from(e)];
        if k % stride == 0 {
            out.add(x.vertices[usize::from(edge.origin)], u32::from(edge.origin));
        }
        e = edge.next;
    }
}

/// The face whose normal is most along `direction`.
pub(crate) fn face_along(x: Polytope<'_>, direction: Vec3) -> usize {
    let (mut best, mut most) = (0, f32::NEG_INFINITY);
    for (i, plane) in x.planes.iter().enumerate() {
        let d = plane.normal.dot(direction);
        if d > most {
            (best, most) = (i, d);
        }
    }
    best
}

/// Contact of face `face` of A with the face of B that looks at it most.
fn face_contact(
    a: Polytope<'_>,
    b: Polytope<'_>,
    b_in_a: &Pose,
    face: usize,
    margin: f32,
    flag: u32,
) -> Manifold {
    let plane = a.planes[face];
    let n = plane.normal;
    let incident_face = face_along(b, -b_in_a.local_direction(n));
    let (mut reference, mut incident) = (Polygon::empty(), Polygon::empty());
    face_polygon(a, face, &mut reference);
    face_polygon(b, incident_face, &mut incident);
    incident.transform(b_in_a);
    let reference = Reference { corners: reference.corners(), normal: n, offset: plane.offset };
    clip(&reference, &mut incident, margin, flag)
}

fn edge_contact(a: Polytope<'_>, b: Polytope<'_>, b_in_a: &Pose, e: &EdgeAxis) -> Manifold {
    let ends = |x: Polytope<'_>, k: usize| {
        [x.edges[k], x.edges[k + 1]].map(|h| x.vertices[usize::from(h.origin)])
    };
    let edge_b = ends(b, e.b).map(|p| b_in_a.point(p));
    let (on_a, on_b) = closest_of_segments(ends(a, e.a), edge_b);
    let normal = b_in_a.direction(e.normal);
    #[expect(clippy::cast_possible_truncation, reason = "fewer than 2^15 edges")]
    let feature = EDGE_PAIR | (e.a as u32 & 0x7fff) << 15 | (e.b as u32 & 0x7fff);
    Manifold::single(normal, (on_a + on_b) * 0.5, e.separation, feature)
}

/// No axis separates by more than the margin and yet nothing lies above the face: corners or edges
/// pass beside it. The true closest points decide; where the polytopes overlap after all, the corner
/// of B that is deepest along the face normal `n` does, at the separation of the faces.
fn beside_the_face(
    a: Polytope<'_>,
    b: Polytope<'_>,
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
        Some(c) if c.distance <= margin => {
            Manifold::single(c.normal, (c.point_a + c.point_b) * 0.5, c.distance, EDGE_PAIR)
        }
        None if of_faces <= 0.0 => {
            let corner = b_in_a.point(support(b, -b_in_a.local_direction(n)));
            Manifold::single(n, corner - n * (0.5 * of_faces), of_faces, EDGE_PAIR)
        }
        _ => Manifold::default(),
    }
}

/// The vertex farthest along `direction`.
#[inline]
pub(crate) fn support(x: Polytope<'_>, direction: Vec3) -> Vec3 {
    let (mut best, mut most) = (Vec3::ZERO, f32::NEG_INFINITY);
    for v in x.vertices {
        let d = v.dot(direction);
        if d > most {
            (best, most) = (*v, d);
        }
    }
    best
}
