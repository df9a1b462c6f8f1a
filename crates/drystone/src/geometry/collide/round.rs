//! Closed forms for pairs of spheres and capsules. Cores only: the caller adds the radii.

use crate::base::math::{Vec3, lesser, vec3};
use crate::base::pose::Pose;
use crate::geometry::convex::clip::{clamp01, closest_of_segments};
use crate::geometry::hull::Hull;
use crate::geometry::manifold::{Manifold, ManifoldPoint};

/// Feature ids of the two points of parallel segments; 0 is the single point.
const FIRST: u32 = 1;
const SECOND: u32 = 2;

/// Squared sine below which segments may touch along a line.
const PARALLEL: f32 = 1.0e-3;
/// Maximum sideways distance of parallel segments at the ends of the common line, relative to their
/// distance: the distance there is then the minimum within 0.1 %.
const SIDEWAYS: f32 = 0.05;

fn between(a: Vec3, b: Vec3, margin: f32, otherwise: Vec3) -> Manifold {
    let apart = b - a;
    let distance = apart.length();
    if distance <= margin {
        Manifold::single(apart.normalize_or(otherwise), (a + b) * 0.5, distance, 0)
    } else {
        Manifold::apart(distance)
    }
}

pub(super) fn points(b: Vec3, margin: f32) -> Manifold {
    between(Vec3::ZERO, b, margin, Vec3::Y)
}

/// A point (A) and a segment (B).
pub(super) fn point_segment(half_height: f32, b_in_a: &Pose, margin: f32) -> Manifold {
    let end = b_in_a.direction(vec3(0.0, half_height, 0.0));
    let tail = b_in_a.position - end;
    let along = end * 2.0;
    let square = along.length_squared();
    let t = if square > 0.0 { clamp01(-tail.dot(along) / square) } else { 0.0 };
    let across = b_in_a.direction(Vec3::X);
    between(Vec3::ZERO, tail + along * t, margin, across)
}

/// A point (A) and a hull (B), where a single face decides: the point is inside, above the inner
/// part of the face, or too far away. `None` leaves edges and corners to the general case.
pub(super) fn point_face(hull: &Hull, b_in_a: &Pose, margin: f32) -> Option<Manifold> {
    let p = b_in_a.local_point(Vec3::ZERO);
    let (mut face, mut distance) = (0, f32::NEG_INFINITY);
    for (i, plane) in hull.planes.iter().enumerate() {
        let d = plane.distance(p);
        if d > distance {
            (face, distance) = (i, d);
        }
    }
    if distance > margin {
        return Some(Manifold::apart(distance));
    }
    let n = hull.planes.get(face)?.normal;
    if distance > 0.0 {
        let first = *hull.face_edges.get(face)?;
        let mut e = first;
        loop {
            let edge = hull.edges[usize::from(e)];
            let tail = hull.vertices[usize::from(edge.origin)];
            let head = hull.vertices[usize::from(hull.edges[usize::from(edge.next)].origin)];
            if (head - tail).cross(n).dot(p - tail) > 0.0 {
                return None;
            }
            e = edge.next;
            if e == first {
                break;
            }
        }
    }
    let normal = -b_in_a.direction(n);
    Some(Manifold::single(normal, normal * (0.5 * distance), distance, 0))
}

pub(super) fn segments(half_a: f32, half_b: f32, b_in_a: &Pose, margin: f32) -> Manifold {
    let end_a = vec3(0.0, half_a, 0.0);
    let end_b = b_in_a.direction(vec3(0.0, half_b, 0.0));
    let a = [-end_a, end_a];
    let b = [b_in_a.position - end_b, b_in_a.position + end_b];
    let (on_a, on_b) = closest_of_segments(a, b);
    // Crossing or touching segments have no closest direction: uses the one perpendicular to both.
    let across = end_a.cross(end_b).normalize_or(Vec3::X);
    let one = between(on_a, on_b, margin, across);
    if one.count == 0 {
        return one;
    }
    let distance = one.points[0].separation;
    along_a_line(a, b, one.normal, SIDEWAYS * distance, margin).unwrap_or(one)
}

/// Returns the two ends of the line along which nearly parallel segments touch along `normal`.
/// Returns `None` if they are not parallel, overlap lengthwise only at a point, or are farther
/// apart than `sideways` [m] across the normal somewhere on the line.
pub(super) fn along_a_line(
    a: [Vec3; 2],
    b: [Vec3; 2],
    normal: Vec3,
    sideways: f32,
    margin: f32,
) -> Option<Manifold> {
    let (da, db) = (a[1] - a[0], b[1] - b[0]);
    let (aa, bb) = (da.length_squared(), db.length_squared());
    if !(aa > 0.0 && bb > 0.0 && da.cross(db).length_squared() < PARALLEL * aa * bb) {
        return None;
    }
    let place = |p: Vec3| (p - a[0]).dot(da) / aa;
    let (s0, s1) = (place(b[0]), place(b[1]));
    let (low, high) = if s0 < s1 { (s0, s1) } else { (s1, s0) };
    let (low, high) = (clamp01(low), clamp01(high));
    if (high - low) * (high - low) * aa <= 1.0e-4 * lesser(aa, bb) {
        return None;
    }
    let mut m = Manifold { normal, ..Manifold::default() };
    for (s, feature) in [(low, FIRST), (high, SECOND)] {
        let on_a = a[0] + da * s;
        let on_b = b[0] + db * ((s - s0) / (s1 - s0));
        let apart = on_b - on_a;
        let separation = apart.dot(normal);
        if (apart - normal * separation).length_squared() > sideways * sideways {
            return None;
        }
        if separation <= margin {
            m.push(ManifoldPoint { position: (on_a + on_b) * 0.5, separation, feature });
        }
    }
    (m.count > 0).then_some(m)
}
