//! A pair of edges as a separating axis, and eight edges at once against one.
//!
//! Symbols: u, v normals of the two faces at an edge, d the edge's direction; R, t rotation and
//! position of one body in the frame of the other.

use fearless_simd::Simd;

use crate::base::math::{Mat3, Vec3};
use crate::base::simd::wide::{
    LANES, Lanes, Vec3w, above, at, bits, put, reduce_max, select, splat, sqrt,
};
use crate::geometry::hull::Hull;
use crate::geometry::hull::lanes::Edge;

/// Squared sine below which two edges count as parallel (0.3°): the axes of faces cover these.
pub(crate) const PARALLEL: f32 = 2.5e-5;

/// Rotation and position of the other body in the frame of the first.
#[derive(Clone, Copy)]
pub(crate) struct Frames {
    pub(crate) r: Mat3,
    pub(crate) t: Vec3,
}

impl Frames {
    #[inline]
    pub(crate) fn point(&self, p: Vec3) -> Vec3 {
        self.r * p + self.t
    }
}

#[derive(Clone, Copy)]
pub(crate) struct EdgeAxis {
    /// Half-edges of A and of B.
    pub(crate) a: usize,
    pub(crate) b: usize,
    pub(crate) separation: f32,
    /// Unit normal, from A to B [frame of B].
    pub(crate) normal: Vec3,
}

/// An edge of A, prepared for the test against edges of B, in the frame of B.
pub(crate) struct EdgeOf {
    edge: usize,
    pub(crate) tail: Vec3,
    pub(crate) d: Vec3,
    u: Vec3,
    v: Vec3,
}

impl EdgeOf {
    #[inline]
    pub(crate) fn new(a: &Hull, a_frames: &Frames, edge: usize) -> Self {
        let Edge { tail, d, normals: [u, v] } = a.lanes.edge(edge / 2);
        Self {
            edge,
            tail: a_frames.point(tail),
            d: a_frames.r * d,
            u: a_frames.r * u,
            v: a_frames.r * v,
        }
    }

    /// Returns the axis of a pair of edges if they form a face of the Minkowski difference. They do
    /// if the arcs u to v and -u' to -v' cross on the Gauss map. Let p = u'·d, q = v'·d. Since d
    /// points along u × v, the arcs cross if and only if pq < 0, (u·d')(v·d') < 0 and p (u·d') > 0.
    /// A's outward axis is then sign(u·d') d × d'.
    pub(crate) fn against(&self, b: &Hull, edge_b: usize) -> Option<EdgeAxis> {
        let Edge { tail, d, normals: [u, v] } = b.lanes.edge(edge_b / 2);
        let (p, q) = (u.dot(self.d), v.dot(self.d));
        if p * q >= 0.0 {
            return None;
        }
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

/// Up to eight edges of one hull, in the frame of B. Empty lanes hold zeros, which cross nothing.
pub(crate) struct EdgeGroup {
    numbers: [usize; LANES],
    count: usize,
    tail: [Lanes; 3],
    d: [Lanes; 3],
    /// Normals of the two faces.
    u: [Lanes; 3],
    v: [Lanes; 3],
}

impl EdgeGroup {
    /// Loads edges from index `first` on, of the half-edges in `list`, or of all edges.
    #[inline(always)]
    pub(crate) fn of(hull: &Hull, list: Option<&[u16]>, first: usize) -> Self {
        let none = [[0.0; LANES]; 3];
        let mut group =
            Self { numbers: [0; LANES], count: 0, tail: none, d: none, u: none, v: none };
        let all = list.map_or(hull.edges.len() / 2, <[u16]>::len);
        group.count = LANES.min(all - first);
        for lane in 0..group.count {
            let number = list.map_or(2 * (first + lane), |l| usize::from(l[first + lane]));
            let edge = hull.lanes.edge(number / 2);
            group.numbers[lane] = number;
            put(&mut group.tail, lane, edge.tail);
            put(&mut group.d, lane, edge.d);
            put(&mut group.u, lane, edge.normals[0]);
            put(&mut group.v, lane, edge.normals[1]);
        }
        group
    }

    /// Moves edges of A into the frame of B.
    #[inline(always)]
    pub(crate) fn place<S: Simd>(&mut self, simd: S, frames: &Frames) {
        let x = Vec3w::splat(simd, frames.r.x);
        let y = Vec3w::splat(simd, frames.r.y);
        let z = Vec3w::splat(simd, frames.r.z);
        let tail = Vec3w::load(simd, &self.tail);
        let t = Vec3w::splat(simd, frames.t);
        (x * tail.x + y * tail.y + z * tail.z + t).store(&mut self.tail);
        for v in [&mut self.d, &mut self.u, &mut self.v] {
            let w = Vec3w::load(simd, v);
            (x * w.x + y * w.y + z * w.z).store(v);
        }
    }

    pub(crate) const fn len(&self) -> usize {
        self.count
    }

    /// Returns the best axis of edge `i` of A with these edges of B, if it separates more than
    /// `floor`: the result of [`EdgeOf::against`], the first of equal ones.
    #[inline(always)]
    pub(crate) fn against<S: Simd>(
        &self,
        simd: S,
        a: &Self,
        i: usize,
        floor: f32,
    ) -> Option<EdgeAxis> {
        let d = Vec3w::splat(simd, at(&a.d, i));
        let zero = splat(simd, 0.0);
        let theirs = Vec3w::load(simd, &self.d);
        let p = Vec3w::load(simd, &self.u).dot(d);
        let q = Vec3w::load(simd, &self.v).dot(d);
        let r = Vec3w::splat(simd, at(&a.u, i)).dot(theirs);
        let s = Vec3w::splat(simd, at(&a.v, i)).dot(theirs);
        let crossed = above(zero, p * q) & above(zero, r * s) & above(p * r, zero);
        if bits(crossed) == 0 {
            return None;
        }
        let axis = d.cross(theirs);
        let square = axis.dot(axis);
        let parallel = splat(simd, PARALLEL) * d.dot(d) * theirs.dot(theirs);
        let k = splat(simd, 1.0) / sqrt(square);
        let normal = axis * select(above(r, zero), k, -k);
        let from = Vec3w::splat(simd, at(&a.tail, i));
        let separation = normal.dot(Vec3w::load(simd, &self.tail) - from);
        let better = crossed & above(square, parallel) & above(separation, splat(simd, floor));
        if bits(better) == 0 {
            return None;
        }
        let values = select(better, separation, splat(simd, f32::NEG_INFINITY));
        let separation = reduce_max(values);
        let lane = bits(!above(splat(simd, separation), values)).trailing_zeros() as usize;
        let mut lanes = [[0.0; LANES]; 3];
        normal.store(&mut lanes);
        let normal = at(&lanes, lane);
        Some(EdgeAxis { a: a.numbers[i], b: self.numbers[lane], separation, normal })
    }
}
