//! Collides two boxes: fifteen axes in closed form, then a rectangle clipped by a rectangle
//! [Gottschalk96], [Gregorius13].
//!
//! Symbols: R, t rotation and position of B in the frame of A; r[j] is axis j of B, so r[j][i] =
//! R_ij; g, h half extents of A and B.

use crate::base::math::{Mat3, Vec3, greater, lesser};
use crate::base::pose::Pose;
use crate::geometry::convex::clip::{SIDE_SLACK, closest_of_segments, flip, reduce};
use crate::geometry::convex::sat::{PARALLEL, PREFERENCE};
use crate::geometry::manifold::{EDGE_PAIR, Manifold, ManifoldPoint, REFERENCE_B};

/// Marks a corner made by a clipping side.
const CUT: u32 = 0x100;

/// One box in the frame of another: `axes` are its unit axes, `t` its center.
#[derive(Clone, Copy)]
struct Placed {
    axes: [Vec3; 3],
    t: Vec3,
}

impl Placed {
    fn new(m: Mat3, t: Vec3) -> Self {
        Self { axes: [m.x, m.y, m.z], t }
    }
}

/// Computes the manifold of boxes with half extents `g` and `h` in the frame of A. Returns `None`
/// where neither a face nor a pair of edges carries the contact, though no axis separates by more
/// than `margin` [m].
pub(super) fn collide(g: Vec3, h: Vec3, b_in_a: &Pose, margin: f32) -> Option<Manifold> {
    let r = b_in_a.rotation.to_mat3();
    let b = Placed::new(r, b_in_a.position);
    let rt = r.transpose();
    let a = Placed::new(rt, -(rt * b_in_a.position));
    let (axis_a, of_a) = best_face(g, h, &b);
    let (axis_b, of_b) = best_face(h, g, &a);
    let of_faces = greater(of_a, of_b);
    if of_faces > margin {
        return Some(Manifold::apart(of_faces));
    }
    let slack = PREFERENCE * lesser(g.min_element(), h.min_element());
    if let Some(edges) = best_edges(g, h, &b, of_faces + slack) {
        return Some(if edges.separation > margin {
            Manifold::apart(edges.separation)
        } else {
            edge_contact(g, h, &b, &edges)
        });
    }
    let m = if of_b > of_a + slack {
        flip(&face_contact(h, g, &a, axis_b, margin, REFERENCE_B), b_in_a)
    } else {
        face_contact(g, h, &b, axis_a, margin, 0)
    };
    (m.count > 0).then_some(m)
}

/// Returns the axis of the box at the origin (half extents `g`) with the largest separation, and
/// that separation [m].
fn best_face(g: Vec3, h: Vec3, other: &Placed) -> (usize, f32) {
    let [x, y, z] = other.axes;
    let reach = x.abs() * h.x + y.abs() * h.y + z.abs() * h.z;
    let s = other.t.abs() - g - reach;
    let mut best = (0, s.x);
    if s.y > best.1 {
        best = (1, s.y);
    }
    if s.z > best.1 {
        best = (2, s.z);
    }
    best
}

struct EdgeAxis {
    /// Axes of A and of B that the edges are parallel to.
    i: usize,
    j: usize,
    separation: f32,
    /// Unit normal, from A to B [frame of A].
    normal: Vec3,
}

/// Returns the pair of edges with the largest separation, if it is more than `floor` [m].
fn best_edges(g: Vec3, h: Vec3, b: &Placed, floor: f32) -> Option<EdgeAxis> {
    let mut best: Option<EdgeAxis> = None;
    let mut maximum = floor;
    for j in 0..3 {
        let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
        for i in 0..3 {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            // The axis e_i × r_j has no component along i.
            let (p, q) = (-b.axes[j][i2], b.axes[j][i1]);
            let square = p * p + q * q;
            let along = p * b.t[i1] + q * b.t[i2];
            let separation = along.abs()
                - (g[i1] * p.abs() + g[i2] * q.abs())
                - (h[j1] * b.axes[j2][i].abs() + h[j2] * b.axes[j1][i].abs());
            // The axis is no longer than 1: a separation below a negative floor stays below it.
            if separation <= lesser(maximum, 0.0) || square <= PARALLEL {
                continue;
            }
            let k = 1.0 / square.sqrt();
            if separation * k > maximum {
                maximum = separation * k;
                let mut normal = Vec3::ZERO;
                let sign = if along < 0.0 { -k } else { k };
                (normal[i1], normal[i2]) = (p * sign, q * sign);
                best = Some(EdgeAxis { i, j, separation: maximum, normal });
            }
        }
    }
    best
}

/// Collides the edge of each box that is farthest towards the other one along the normal.
fn edge_contact(g: Vec3, h: Vec3, b: &Placed, e: &EdgeAxis) -> Manifold {
    let mut feature = EDGE_PAIR;
    let mut on_a = Vec3::ZERO;
    let mut on_b = b.t;
    for k in 0..3 {
        if k != e.i {
            let up = e.normal[k] > 0.0;
            on_a[k] = if up { g[k] } else { -g[k] };
            feature |= u32::from(up) << k;
        }
        if k != e.j {
            let up = e.normal.dot(b.axes[k]) < 0.0;
            on_b += b.axes[k] * if up { h[k] } else { -h[k] };
            feature |= u32::from(up) << (3 + k);
        }
    }
    #[expect(clippy::cast_possible_truncation, reason = "axes are 0, 1 and 2")]
    let pair = (e.i * 3 + e.j) as u32;
    feature |= pair << 6;
    let mut along_a = Vec3::ZERO;
    along_a[e.i] = g[e.i];
    let along_b = b.axes[e.j] * h[e.j];
    let (p, q) =
        closest_of_segments([on_a - along_a, on_a + along_a], [on_b - along_b, on_b + along_b]);
    Manifold::single(e.normal, (p + q) * 0.5, e.separation, feature)
}

#[derive(Clone, Copy, Default)]
struct Corner {
    p: Vec3,
    id: u32,
    /// Identifies the edge to the next corner: 0 to 3 for the incident face, above 3 for the sides.
    edge: u32,
}

/// A quadrilateral cut by four sides has at most eight corners.
#[derive(Clone, Copy)]
struct Outline {
    corners: [Corner; 8],
    count: usize,
}

impl Outline {
    fn push(&mut self, corner: Corner) {
        if let Some(place) = self.corners.get_mut(self.count) {
            *place = corner;
            self.count += 1;
        }
    }

    /// Keeps the part with `sign` · p[k] <= limit.
    fn cut(&mut self, k: usize, sign: f32, limit: f32, side: u32) {
        let corners = &self.corners[..self.count];
        if corners.iter().all(|c| sign * c.p[k] <= limit) {
            return;
        }
        let mut kept = Self { corners: [Corner::default(); 8], count: 0 };
        let Some(mut from) = corners.last() else { return };
        let mut from_d = sign * from.p[k] - limit;
        for to in corners {
            let d = sign * to.p[k] - limit;
            if (d <= 0.0) != (from_d <= 0.0) {
                let p = from.p.lerp(to.p, from_d / (from_d - d));
                let id = CUT | side << 4 | from.edge;
                kept.push(Corner { p, id, edge: if d <= 0.0 { from.edge } else { 4 + side } });
            }
            if d <= 0.0 {
                kept.push(*to);
            }
            (from, from_d) = (to, d);
        }
        *self = kept;
    }
}

/// Collides the face of the box at the origin (half extents `g`) that faces the other box along
/// `axis` with the other box's face that is most opposite to it.
fn face_contact(g: Vec3, h: Vec3, other: &Placed, axis: usize, margin: f32, flag: u32) -> Manifold {
    let up = other.t[axis] >= 0.0;
    let sign = if up { 1.0 } else { -1.0 };
    let mut normal = Vec3::ZERO;
    normal[axis] = sign;
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut j = 0;
    for k in 1..3 {
        if other.axes[k][axis].abs() > other.axes[j][axis].abs() {
            j = k;
        }
    }
    // The incident face is opposite to the normal.
    let back = if (other.axes[j][axis] > 0.0) == up { -h[j] } else { h[j] };
    let middle = other.t + other.axes[j] * back;
    let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
    let (e, f) = (other.axes[j1] * h[j1], other.axes[j2] * h[j2]);
    #[expect(clippy::cast_possible_truncation, reason = "axes are 0, 1 and 2")]
    let face = (((axis * 3 + j) as u32) << 10) | u32::from(up) << 14 | u32::from(back > 0.0) << 15;
    let at = |p: Vec3, n: u32| Corner { p, id: n, edge: n };
    let none = Corner::default();
    let mut outline = Outline {
        corners: [
            at(middle - e - f, 0),
            at(middle + e - f, 1),
            at(middle + e + f, 2),
            at(middle - e + f, 3),
            none,
            none,
            none,
            none,
        ],
        count: 4,
    };
    let size = lesser(h[j1], h[j2]);
    for (k, side) in [(u, 0), (v, 2)] {
        let limit = g[k] + SIDE_SLACK * lesser(g[k], size);
        outline.cut(k, 1.0, limit, side);
        outline.cut(k, -1.0, limit, side + 1);
    }
    let mut points = [ManifoldPoint::default(); 8];
    let mut count = 0;
    for c in &outline.corners[..outline.count] {
        let separation = sign * c.p[axis] - g[axis];
        if separation <= margin {
            let mut position = c.p;
            position[axis] -= sign * (0.5 * separation);
            points[count] = ManifoldPoint { position, separation, feature: flag | face | c.id };
            count += 1;
        }
    }
    reduce(&points[..count], normal)
}
