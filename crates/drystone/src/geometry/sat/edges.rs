//! A pair of edges as a separating axis, and eight edges at once against one.
//!
//! Symbols: u, v normals of the two faces at an edge, d the edge's direction; R, t rotation and
//! position of one body in the frame of the other.

use crate::base::math::{Mat3, Vec3};
use crate::base::wide::{LANES, Lanes};
use crate::geometry::hull::{HalfEdge, Hull};

/// Squared sine below which two edges count as parallel (0.3°): the axes of faces serve there.
pub(in crate::geometry) const PARALLEL: f32 = 2.5e-5;

/// Rotation and position of the other body in the frame of the one.
#[derive(Clone, Copy)]
pub(super) struct Frames {
    pub(super) r: Mat3,
    pub(super) t: Vec3,
}

impl Frames {
    #[inline]
    pub(super) fn point(&self, p: Vec3) -> Vec3 {
        self.r * p + self.t
    }
}

#[derive(Clone, Copy)]
pub(super) struct EdgeAxis {
    /// Half-edges of A and of B.
    pub(super) a: usize,
    pub(super) b: usize,
    pub(super) separation: f32,
    /// Unit, from A to B [frame of B].
    pub(super) normal: Vec3,
}

fn normal_of(x: &Hull, e: HalfEdge) -> Vec3 {
    x.planes[usize::from(e.face)].normal
}

/// An edge of A with what the test against edges of B needs, in the frame of B.
pub(super) struct EdgeOf {
    edge: usize,
    pub(super) tail: Vec3,
    pub(super) d: Vec3,
    u: Vec3,
    v: Vec3,
}

impl EdgeOf {
    #[inline]
    pub(super) fn new(a: &Hull, a_frames: &Frames, edge: usize) -> Self {
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
    /// and -u' to -v' on the Gauss map cross. With p = u'·d, q = v'·d: as d points along u × v, the
    /// arcs cross iff pq < 0, (u·d')(v·d') < 0 and p (u·d') > 0; then A's outward axis is
    /// sign(u·d') d × d'.
    pub(super) fn against(&self, b: &Hull, edge_b: usize) -> Option<EdgeAxis> {
        let (e, twin) = (b.edges[edge_b], b.edges[edge_b + 1]);
        let p = normal_of(b, e).dot(self.d);
        let q = normal_of(b, twin).dot(self.d);
        if p * q >= 0.0 {
            return None;
        }
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

/// Eight edges of B: normals of both faces and the edge itself.
pub(super) struct EdgeGroup {
    u: [Lanes; 3],
    v: [Lanes; 3],
    d: [Lanes; 3],
}

impl EdgeGroup {
    pub(super) const fn new() -> Self {
        let none = [[0.0; LANES]; 3];
        Self { u: none, v: none, d: none }
    }

    #[inline]
    pub(super) fn put(&mut self, lane: usize, b: &Hull, edge: usize) {
        let (e, twin) = (b.edges[edge], b.edges[edge + 1]);
        let (u, v) = (normal_of(b, e), normal_of(b, twin));
        let d = b.vertices[usize::from(twin.origin)] - b.vertices[usize::from(e.origin)];
        for k in 0..3 {
            (self.u[k][lane], self.v[k][lane], self.d[k][lane]) = (u[k], v[k], d[k]);
        }
    }

    /// Which of the arcs are crossed by that of `edge`: the first test of [`EdgeOf::against`].
    #[inline]
    pub(super) fn crossed_by(&self, edge: &EdgeOf) -> [bool; LANES] {
        let dot = |a: &[Lanes; 3], v: Vec3| {
            let mut sum = [0.0; LANES];
            for i in 0..LANES {
                sum[i] = a[0][i] * v.x + a[1][i] * v.y + a[2][i] * v.z;
            }
            sum
        };
        let (p, q) = (dot(&self.u, edge.d), dot(&self.v, edge.d));
        let (r, s) = (dot(&self.d, edge.u), dot(&self.d, edge.v));
        let mut crossed = [false; LANES];
        for i in 0..LANES {
            crossed[i] = (p[i] * q[i] < 0.0) & (r[i] * s[i] < 0.0) & (p[i] * r[i] > 0.0);
        }
        crossed
    }
}
