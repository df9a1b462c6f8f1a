//! Polygons and lines clipped by a reference polygon, and the selection of four points.

use smallvec::SmallVec;

use crate::base::math::{Vec3, greater, lesser};
use crate::base::pose::Pose;
use crate::geometry::hull::Hull;
use crate::geometry::manifold::{FeatureId, Manifold, ManifoldPoint};

/// Maximum number of corners of a polygon. Larger faces are thinned out; each cut adds at most one
/// corner.
pub(crate) const MAX_CORNERS: usize = 40;
const MAX_FACE_CORNERS: usize = 32;

/// Outward shift of the reference's side planes, relative to the side's length, or to the length of
/// the incident feature if that is less. Equal faces on top of each other then keep their corners
/// (and feature ids) under rounding.
pub(crate) const SIDE_SLACK: f32 = 2.0e-4;

/// Marks the number of a clipping plane, as opposed to an edge of the incident face.
const PLANE: u32 = 0x800;

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Corner {
    pub(crate) p: Vec3,
    /// Identifies the corner, 24 bits.
    pub(crate) id: u32,
    /// Identifies the edge to the next corner, 12 bits.
    edge: u32,
}

/// A convex polygon, counter-clockwise seen from outside; two corners: a line.
#[derive(Clone, Debug)]
pub(crate) struct Polygon {
    /// At most the inline capacity, so that no memory is cleared before use.
    corners: SmallVec<[Corner; MAX_CORNERS]>,
}

impl Polygon {
    #[inline]
    pub(crate) fn empty() -> Self {
        Self { corners: SmallVec::new() }
    }

    #[inline]
    pub(crate) fn corners(&self) -> &[Corner] {
        &self.corners
    }

    #[inline]
    pub(crate) fn clear(&mut self) {
        self.corners.clear();
    }

    /// Adds corner number `number` of a face; ignored if there is no space.
    #[inline]
    pub(crate) fn add(&mut self, p: Vec3, number: u32) {
        if self.corners.len() < MAX_FACE_CORNERS {
            let edge = number & (PLANE - 1);
            self.corners.push(Corner { p, id: corner_id(number), edge });
        }
    }

    #[inline]
    fn push(&mut self, corner: Corner) {
        if self.corners.len() < MAX_CORNERS {
            self.corners.push(corner);
        }
    }

    /// Stride at which corners of a face of `n` are taken, so that they fit.
    pub(crate) const fn stride(n: usize) -> usize {
        n.div_ceil(MAX_FACE_CORNERS)
    }

    pub(crate) fn transform(&mut self, pose: &Pose) {
        for c in &mut self.corners {
            c.p = pose.point(c.p);
        }
    }

    /// Writes the part below plane `k`, `side · p <= offset`, to `out`.
    fn cut(&self, side: Vec3, offset: f32, k: u32, out: &mut Self) {
        out.clear();
        let Some(last) = self.corners().last() else { return };
        let (mut from, mut from_d) = (*last, side.dot(last.p) - offset);
        let plane = PLANE | k;
        for to in self.corners() {
            let d = side.dot(to.p) - offset;
            if (d <= 0.0) != (from_d <= 0.0) {
                let p = from.p.lerp(to.p, from_d / (from_d - d));
                let id = plane << 12 | from.edge;
                out.push(Corner { p, id, edge: if d <= 0.0 { from.edge } else { plane } });
            }
            if d <= 0.0 {
                out.push(*to);
            }
            (from, from_d) = (*to, d);
        }
    }

    /// Does the same for a line of two corners.
    fn cut_line(&mut self, side: Vec3, offset: f32, k: u32) {
        let [a, b] = [self.corners[0], self.corners[1]];
        let (da, db) = (side.dot(a.p) - offset, side.dot(b.p) - offset);
        if da > 0.0 && db > 0.0 {
            self.clear();
        } else if (da <= 0.0) != (db <= 0.0) {
            let p = a.p.lerp(b.p, da / (da - db));
            let cut = Corner { p, id: (PLANE | k) << 12 | a.edge, edge: a.edge };
            self.corners[usize::from(db > 0.0)] = cut;
        }
    }
}

/// The flat side of a solid that carries a contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference<'a> {
    pub(crate) corners: &'a [Corner],
    /// Unit normal, outward; the normal of the contact.
    pub(crate) normal: Vec3,
    pub(crate) offset: f32,
}

/// Corners of a solid besides those of its incident feature, with their numbers.
pub(crate) type Corners = SmallVec<[(Vec3, u32); MAX_CORNERS]>;

/// Returns the low corners of a hull over a plane, with the hull at `pose` in the plane's frame.
/// They are within `margin` [m], and [`STEEP`] times their height above the lowest corner is at
/// most their distance from it. The lowest corner need not belong to the incident face, and a body
/// that turns next lands on its low neighbors. A box has no such corners beyond the incident
/// face's.
pub(crate) fn low_corners(
    hull: &Hull,
    pose: &Pose,
    normal: Vec3,
    offset: f32,
    margin: f32,
) -> Corners {
    let mut low = Corners::new();
    if hull.cuboid.is_some() {
        return low;
    }
    let (along, offset) = (pose.local_direction(normal), offset - normal.dot(pose.position));
    let mut lowest = (f32::INFINITY, Vec3::ZERO);
    for v in &hull.vertices {
        let height = along.dot(*v) - offset;
        if height < lowest.0 {
            lowest = (height, *v);
        }
    }
    let limit = |v: &Vec3| lesser(margin, lowest.0 + (*v - lowest.1).length() / STEEP);
    for (number, v) in (0..).zip(&hull.vertices) {
        if along.dot(*v) - offset <= limit(v) && low.len() < MAX_CORNERS {
            low.push((pose.point(*v), number));
        }
    }
    low
}

/// Computes the contact of a flat side of A with a polygon or line of B and some corners of B. It
/// clips `incident` to the prism above the reference, and keeps four points within `margin` [m].
pub(crate) fn clip(
    reference: &Reference<'_>,
    incident: &mut Polygon,
    corners_of_b: &Corners,
    margin: f32,
    flag: FeatureId,
) -> Manifold {
    let n = reference.normal;
    let corners = reference.corners;
    let mut spare = Polygon::empty();
    let mut in_spare = false;
    let extent = match incident.corners() {
        [first, second, ..] => (second.p - first.p).length(),
        _ => 0.0,
    };
    if let Some(last) = corners.last() {
        let mut tail = last.p;
        for (k, head) in (0_u32..).zip(corners) {
            let along = head.p - tail;
            let side = along.cross(n);
            let length = along.length();
            let offset = side.dot(tail) + SIDE_SLACK * length * lesser(length, extent);
            let k = k & (PLANE - 1);
            if incident.corners.len() == 2 && !in_spare {
                incident.cut_line(side, offset, k);
            } else if in_spare {
                spare.cut(side, offset, k, incident);
                in_spare = false;
            } else {
                incident.cut(side, offset, k, &mut spare);
                in_spare = true;
            }
            tail = head.p;
        }
    }
    let kept = if in_spare { &spare } else { incident };
    let mut points: SmallVec<[ManifoldPoint; MAX_CORNERS]> = SmallVec::new();
    let mut add = |p: Vec3, id: u32| {
        let separation = n.dot(p) - reference.offset;
        if separation <= margin {
            let position = p - n * (0.5 * separation);
            points.push(ManifoldPoint { position, separation, feature: flag | id });
        }
    };
    for c in kept.corners() {
        add(c.p, c.id);
    }
    for (p, number) in corners_of_b {
        let id = corner_id(*number);
        if kept.corners().iter().all(|c| c.id != id) && reference.is_under(*p) {
            add(*p, id);
        }
    }
    reduce(&points, n)
}

impl Reference<'_> {
    /// Returns true if a point is in the prism over and under the side.
    fn is_under(&self, p: Vec3) -> bool {
        let Some(last) = self.corners.last() else { return false };
        let mut tail = last.p;
        self.corners.iter().all(|head| {
            let side = (head.p - tail).cross(self.normal);
            let inside = side.dot(p - tail) <= 0.0;
            tail = head.p;
            inside
        })
    }
}

/// Id of corner `number` of a face.
const fn corner_id(number: u32) -> u32 {
    0x00ff_f000 | number & (PLANE - 1)
}

/// Weight of a point's height above the deepest one: this multiple of the height is subtracted from
/// its distance. A point above a lower corner never lands beside it, and one steeper than a half
/// does not land within a step.
pub(crate) const STEEP: f32 = 2.0;

/// Reduces many points to four: the deepest, the one farthest from it, and on each side of the line
/// through these two the one of the largest triangle. Distances and areas are reduced by the
/// heights of the points ([`STEEP`]).
pub(crate) fn reduce(points: &[ManifoldPoint], normal: Vec3) -> Manifold {
    let mut m = Manifold { normal, ..Manifold::default() };
    if points.len() <= 4 {
        for p in points {
            m.push(*p);
        }
        return m;
    }
    let size = points.iter().map(|p| (p.position - points[0].position).length_squared());
    // The first of several points with equal depth up to rounding is taken, so that it stays the
    // same from step to step.
    let slack = 2.0e-5 * size.fold(0.0_f32, greater).sqrt();
    let mut deepest = 0;
    for (i, p) in points.iter().enumerate() {
        if p.separation < points[deepest].separation - slack {
            deepest = i;
        }
    }
    let first = points[deepest];
    // Points with equal depth up to rounding count as no higher.
    let higher = |p: &ManifoldPoint| STEEP * greater(p.separation - first.separation - slack, 0.0);
    let (mut farthest, mut maximum) = (deepest, 0.0);
    for (i, p) in points.iter().enumerate() {
        let mut d = (p.position - first.position).length_squared();
        let higher = higher(p);
        if higher > 0.0 {
            let near = greater(d.sqrt() - higher, 0.0);
            d = near * near;
        }
        if d > maximum * 1.001 {
            (farthest, maximum) = (i, d);
        }
    }
    m.push(first);
    if farthest == deepest {
        return m;
    }
    let second = points[farthest];
    m.push(second);
    let side = normal.cross(second.position - first.position);
    let length = side.length();
    let (mut left, mut right) = (None, None);
    let (mut high, mut low) = (1.0e-4 * maximum, -1.0e-4 * maximum);
    for p in points {
        let area = side.dot(p.position - first.position);
        let higher = higher(p) * length;
        let area =
            if area > 0.0 { greater(area - higher, 0.0) } else { lesser(area + higher, 0.0) };
        if area > high {
            (left, high) = (Some(*p), area * 1.001);
        } else if area < low {
            (right, low) = (Some(*p), area * 1.001);
        }
    }
    for p in [left, right].into_iter().flatten() {
        m.push(p);
    }
    m
}

/// Exchanges A and B of a contact: converts it from the frame of the old A, which is the new B, to
/// the frame of the new A. `old_a_in_new` is the pose of the old A in the new one.
pub(crate) fn flip(m: &Manifold, old_a_in_new: &Pose) -> Manifold {
    let mut flipped = *m;
    flipped.normal = -old_a_in_new.direction(m.normal);
    for p in &mut flipped.points[..m.count] {
        p.position = old_a_in_new.point(p.position);
    }
    flipped
}

/// Closest points of two segments.
pub(crate) fn closest_of_segments(a: [Vec3; 2], b: [Vec3; 2]) -> (Vec3, Vec3) {
    let (da, db, r) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (aa, bb, ab) = (da.dot(da), db.dot(db), da.dot(db));
    let (ar, br) = (da.dot(r), db.dot(r));
    let det = aa * bb - ab * ab;
    // Nearly parallel lines: any point works, since the other one follows from it.
    let s = if det > 1.0e-7 * aa * bb { clamp01((ab * br - ar * bb) / det) } else { 0.5 };
    let t = if bb > 0.0 { clamp01((ab * s + br) / bb) } else { 0.0 };
    let s = if aa > 0.0 { clamp01((ab * t - ar) / aa) } else { 0.0 };
    (a[0] + da * s, b[0] + db * t)
}

pub(crate) const fn clamp01(x: f32) -> f32 {
    x.clamp(0.0, 1.0)
}
