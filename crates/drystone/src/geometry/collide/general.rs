//! Collides any two convex cores: finds a normal from distance or overlap, then a manifold from the
//! features that face along it.
//!
//! The overlap of round bodies is found as a distance too. Once [`epa`] has found a direction, B is
//! moved out along it, and the closest points of the separated bodies give a better direction. The
//! exact direction is the fixed point of this iteration. Each round reduces its error by about the
//! depth over the radius of curvature; where a flat side touches, one round is exact.

use super::convex::Convex;
use super::round::along_a_line;
use crate::base::math::{Vec3, greater, lesser, vec3};
use crate::base::pose::Pose;
use crate::geometry::convex::clip::{Corners, Polygon, Reference, clip, flip, low_corners};
use crate::geometry::convex::epa;
use crate::geometry::convex::gjk;
use crate::geometry::convex::gjk::Closest;
use crate::geometry::hull::Hull;
use crate::geometry::manifold::{Manifold, REFERENCE_B};

/// Cosine of 0.02 rad: a normal this close to that of a flat side snaps to it, if that costs no
/// depth.
const SNAP: f32 = 1.0 - 2.0e-4;
/// Cosine of 0.002 rad: lines this close to a right angle with the normal may carry the contact.
const STRAIGHT: f32 = 1.0 - 2.0e-6;

/// Fractions of the size. Below NEAR, closest points give no good normal. APART is the shift that
/// separates bodies to find one. TIED is a negligible difference of depth, in addition to the
/// rounding of coordinates.
const NEAR: f32 = 0.01;
const APART: f32 = 0.02;
const TIED: f32 = 1.0e-3;
const ROUNDING: f32 = 5.0e-7;
const EPA_TOLERANCE: f32 = 5.0e-4;
const REFINEMENTS: usize = 4;

/// Feature id of a single point.
const SINGLE: u32 = 0x2000_0000;

/// The solid whose flat side carries a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Flat {
    A,
    B,
    Neither,
}

struct Pair<'a> {
    a: &'a Convex<'a>,
    b: &'a Convex<'a>,
    b_in_a: &'a Pose,
    /// Extent of the smaller one [m].
    size: f32,
    /// Negligible difference of depth [m].
    tied: f32,
}

/// Computes the manifold in the frame of A. `sat` handles pairs of hulls that overlap.
pub(super) fn collide(a: &Convex<'_>, b: &Convex<'_>, b_in_a: &Pose, margin: f32) -> Manifold {
    let pair = Pair::new(a, b, b_in_a);
    let Some(closest) = pair.closest(margin) else { return Manifold::default() };
    if closest.distance > margin {
        return Manifold::apart(closest.distance);
    }
    pair.manifold(&closest, margin)
}

/// Does the same for two cores that are clearly apart; returns `None` if they are not.
pub(super) fn collide_apart(
    a: &Convex<'_>,
    b: &Convex<'_>,
    b_in_a: &Pose,
    margin: f32,
) -> Option<Manifold> {
    let pair = Pair::new(a, b, b_in_a);
    let c = gjk::distance(|d| a.support(d), |d| pair.support_b(d), pair.start())?;
    if c.distance > margin {
        return Some(Manifold::apart(c.distance));
    }
    (c.distance > NEAR * pair.size).then(|| pair.manifold(&c, margin))
}

impl<'a> Pair<'a> {
    fn new(a: &'a Convex<'a>, b: &'a Convex<'a>, b_in_a: &'a Pose) -> Self {
        let (size_a, size_b) = (a.size(), b.size());
        let (small, large) = (lesser(size_a, size_b), greater(size_a, size_b));
        // A point, or a capsule that is a sphere, has no extent.
        let size = if small > 1.0e-5 * large { small } else { large };
        let tied = TIED * size + ROUNDING * (large + b_in_a.position.length());
        Self { a, b, b_in_a, size, tied }
    }

    /// Vector from the middle of A to that of B: a first guess of the direction.
    fn start(&self) -> Vec3 {
        self.b_in_a.point(self.b.center()) - self.a.center()
    }

    fn support_b(&self, d: Vec3) -> Vec3 {
        self.b_in_a.point(self.b.support(self.b_in_a.local_direction(d)))
    }

    /// Signed distance along a unit direction [m].
    fn separation(&self, n: Vec3) -> f32 {
        n.dot(self.support_b(-n) - self.a.support(n))
    }

    /// Returns the closest or deepest points; `distance` is signed.
    fn closest(&self, margin: f32) -> Option<Closest> {
        let apart = gjk::distance(|d| self.a.support(d), |d| self.support_b(d), self.start());
        if let Some(c) = apart
            && (c.distance > NEAR * self.size || c.distance > margin)
        {
            return apart;
        }
        let mut n = match apart {
            Some(c) => c.normal,
            None => self.overlap_direction()?,
        };
        let mut best: Option<Closest> = None;
        for _ in 0..REFINEMENTS {
            let Some(c) = self.moved_apart(n) else { break };
            let turned = (c.normal - n).length_squared();
            let better = best.is_none_or(|b| c.distance > b.distance);
            if better {
                best = Some(c);
            }
            n = c.normal;
            if !better || turned < 1.0e-10 {
                break;
            }
        }
        best
    }

    /// Moves B along `n` until it is clear of A, and returns the closest points, moved back again.
    fn moved_apart(&self, n: Vec3) -> Option<Closest> {
        let before = self.separation(n);
        let shift = n * (APART * self.size - before);
        let c = gjk::distance(|d| self.a.support(d), |d| self.support_b(d) + shift, n)?;
        let (mut distance, mut normal) = (self.separation(c.normal), c.normal);
        if before > distance {
            (distance, normal) = (before, n);
        }
        let point_b = c.point_b - shift;
        // The shift was along n, the result is along the new normal: each point takes half the
        // difference.
        let off = (point_b - c.point_a) - normal * distance;
        Some(Closest {
            distance,
            point_a: c.point_a + off * 0.5,
            point_b: point_b - off * 0.5,
            normal,
        })
    }

    fn overlap_direction(&self) -> Option<Vec3> {
        match (self.a, self.b) {
            (Convex::Segment { half_height }, Convex::Hull(hull)) => {
                let ends =
                    [-1.0, 1.0].map(|s| self.b_in_a.local_point(vec3(0.0, s * half_height, 0.0)));
                Some(-self.b_in_a.direction(segment_in_hull(hull, ends)))
            }
            _ => epa::min_overlap(
                |d| self.a.support(d),
                |d| self.support_b(d),
                EPA_TOLERANCE * self.size,
            ),
        }
    }

    /// Returns the flat side that carries the contact, if its normal is as good as the one found,
    /// and the contact with that exact normal.
    fn snapped(&self, closest: &Closest) -> (Closest, Flat) {
        let n = closest.normal;
        let of_a = self.a.face_normal(n);
        let of_b = self.b.face_normal(-self.b_in_a.local_direction(n));
        let of_b = of_b.map(|m| -self.b_in_a.direction(m));
        for (m, flat) in [(of_a, Flat::A), (of_b, Flat::B)] {
            let Some(m) = m else { continue };
            if m.dot(n) > SNAP {
                let distance = self.separation(m);
                if distance >= closest.distance - self.tied {
                    return (Closest { distance, normal: m, ..*closest }, flat);
                }
            }
        }
        (*closest, Flat::Neither)
    }

    /// Returns up to four points of the features that face along the normal.
    fn manifold(&self, closest: &Closest, margin: f32) -> Manifold {
        let (c, flat) = self.snapped(closest);
        let (a, b, pose, n) = (self.a, self.b, self.b_in_a, c.normal);
        let n_in_b = -pose.local_direction(n);
        let m = match flat {
            Flat::A => against_face(a, n, b, n_in_b, pose, margin, 0),
            Flat::B => {
                let m = against_face(b, n_in_b, a, n, &pose.inverse(), margin, REFERENCE_B);
                flip(&m, pose)
            }
            Flat::Neither => self.along_lines(&c, margin),
        };
        if m.count > 0 {
            return m;
        }
        // Points beside the flat side do not belong to it; their normal is the one found.
        let middle = (closest.point_a + closest.point_b) * 0.5;
        Manifold::single(closest.normal, middle, closest.distance, SINGLE)
    }

    /// Returns two points where a line on A lies along a line on B.
    fn along_lines(&self, c: &Closest, margin: f32) -> Manifold {
        let line_a = self.a.line(c.normal);
        let line_b = self.b.line(-self.b_in_a.local_direction(c.normal));
        let Some(((line_a, cos_a), (line_b, cos_b))) = line_a.zip(line_b) else {
            return Manifold::default();
        };
        if !(cos_a > STRAIGHT && cos_b > STRAIGHT) {
            return Manifold::default();
        }
        let sideways = 0.05 * (c.distance.abs() + 0.1 * self.size);
        let line_b = line_b.map(|p| self.b_in_a.point(p));
        along_a_line(line_a, line_b, c.normal, sideways, margin).unwrap_or_default()
    }
}

/// Collides A's flat side along `n` with the feature of B that faces it; in the frame of A.
fn against_face(
    a: &Convex<'_>,
    n: Vec3,
    b: &Convex<'_>,
    n_in_b: Vec3,
    b_in_a: &Pose,
    margin: f32,
    flag: u32,
) -> Manifold {
    let (mut face, mut incident) = (Polygon::empty(), Polygon::empty());
    a.face(n, &mut face);
    b.incident(n_in_b, &mut incident);
    incident.transform(b_in_a);
    let normal = a.face_normal(n).unwrap_or(n);
    let Some(corner) = face.corners().first() else { return Manifold::default() };
    let offset = normal.dot(corner.p);
    let low = match b {
        Convex::Hull(hull) => low_corners(hull, b_in_a, normal, offset, margin),
        _ => Corners::new(),
    };
    let reference = Reference { corners: face.corners(), normal, offset };
    clip(&reference, &mut incident, &low, margin, flag)
}

/// Returns the outward direction along which a segment that intersects a hull has the shortest way
/// out. Candidates are normals of faces, and cross products of edges with the segment where the
/// segment's circle on the Gauss map crosses the edge's arc.
fn segment_in_hull(hull: &Hull, ends: [Vec3; 2]) -> Vec3 {
    let mut best = (Vec3::Y, f32::NEG_INFINITY);
    for plane in &hull.planes {
        let d = lesser(plane.distance(ends[0]), plane.distance(ends[1]));
        if d > best.1 {
            best = (plane.normal, d);
        }
    }
    let along = ends[1] - ends[0];
    for pair in hull.edges.chunks_exact(2) {
        let [u, v] = [pair[0], pair[1]].map(|e| hull.planes[usize::from(e.face)].normal);
        let (p, q) = (u.dot(along), v.dot(along));
        if p * q >= 0.0 {
            continue;
        }
        let [tail, head] = [pair[0], pair[1]].map(|e| hull.vertices[usize::from(e.origin)]);
        let axis = (head - tail).cross(along);
        // The point of the arc perpendicular to the segment.
        let outward = u * q.abs() + v * p.abs();
        let axis = if axis.dot(outward) < 0.0 { -axis } else { axis };
        let Some(n) = axis.try_normalize() else { continue };
        let d = n.dot(ends[0] - tail);
        if d > best.1 {
            best = (n, d);
        }
    }
    best.0
}
