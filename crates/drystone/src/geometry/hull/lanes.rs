//! A hull's vertices, planes and edges in groups of eight, for the search for separating axes.
//!
//! Functions outside a kernel use plain arrays. A lane never depends on its neighbour, so the
//! compiler turns each loop into the target's vector instructions, and the result is the same
//! everywhere.

use fearless_simd::Simd;

use super::{HalfEdge, Plane};
use crate::base::math::{Mat3, Vec3, greater, lesser, vec3};
use crate::base::simd::wide::{
    ALL, LANES, Lanes, Vec3w, above, bits, lanes_in_use, load, max, min, reduce_max, reduce_min,
    splat,
};

/// Eight vectors, one array per coordinate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vectors {
    x: Lanes,
    y: Lanes,
    z: Lanes,
}

impl Vectors {
    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S) -> Vec3w<S> {
        Vec3w { x: load(simd, &self.x), y: load(simd, &self.y), z: load(simd, &self.z) }
    }

    #[inline(always)]
    fn at(&self, lane: usize) -> Vec3 {
        vec3(self.x[lane], self.y[lane], self.z[lane])
    }

    #[inline]
    fn dot(&self, n: Vec3) -> Lanes {
        let mut along = [0.0; LANES];
        for i in 0..LANES {
            along[i] = n.x * self.x[i] + n.y * self.y[i] + n.z * self.z[i];
        }
        along
    }
}

/// Eight edges: their ends [m, local] and the normals of their two faces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeLanes {
    pub(crate) ends: [Vectors; 2],
    pub(crate) normals: [Vectors; 2],
}

/// Bounds on the separation along eight edges: the offsets of their two faces [m], and the cosine
/// of half the angle between the normals of these faces.
#[derive(Clone, Copy, Debug)]
struct EdgeBounds {
    offsets: [Lanes; 2],
    cos: Lanes,
}

/// An edge: its start and direction vector [m], and the normals of its two faces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub(crate) tail: Vec3,
    pub(crate) d: Vec3,
    pub(crate) normals: [Vec3; 2],
}

/// Maximum number of edges in an [`EdgeList`].
const LISTED: usize = 64;

/// Some edges of a hull, by their first half-edges; a list that is too long counts as all edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeList {
    numbers: [u16; LISTED],
    count: usize,
}

impl EdgeList {
    pub(crate) const EMPTY: Self = Self { numbers: [0; LISTED], count: 0 };

    #[inline(always)]
    fn add(&mut self, number: u16) {
        if let Some(to) = self.numbers.get_mut(self.count) {
            *to = number;
        }
        self.count += 1;
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the half-edges in the list; `None` means all edges.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> Option<&[u16]> {
        self.numbers.get(..self.count)
    }
}

/// A hull's data in lanes, see the module.
#[derive(Clone, Debug)]
pub(crate) struct HullLanes {
    /// Vertices; the last group is padded with the last vertex.
    vertices: Vec<Vectors>,
    /// Normals and offsets of the faces; the last group is padded with the last plane.
    normals: Vec<Vectors>,
    offsets: Vec<Lanes>,
    /// Edges; the last group is padded with the last edge.
    edges: Vec<EdgeLanes>,
    edge_bounds: Vec<EdgeBounds>,
    edge_count: usize,
}

impl HullLanes {
    pub(crate) fn new(vertices: &[Vec3], planes: &[Plane], half_edges: &[HalfEdge]) -> Self {
        let half_angle = |pair: &[HalfEdge]| {
            let [m, n] = [pair[0], pair[1]].map(|e| planes[usize::from(e.face)].normal);
            greater(0.5 + 0.5 * m.dot(n), 0.0).sqrt()
        };
        let group = |chunk: &[Plane]| {
            let mut offsets = [chunk[chunk.len() - 1].offset; LANES];
            for (to, plane) in offsets.iter_mut().zip(chunk) {
                *to = plane.offset;
            }
            offsets
        };
        let normals: Vec<Vec3> = planes.iter().map(|p| p.normal).collect();
        let offset = |e: HalfEdge| planes[usize::from(e.face)].offset;
        let bounds = |pairs: &[HalfEdge]| {
            // The last edge pads its group.
            let pair = |lane: usize| &pairs[2 * lane.min(pairs.len() / 2 - 1)..][..2];
            let side = |k: usize| core::array::from_fn(|lane| offset(pair(lane)[k]));
            let cos = core::array::from_fn(|lane| half_angle(pair(lane)));
            EdgeBounds { offsets: [side(0), side(1)], cos }
        };
        let one_by_one = |side: usize| half_edges.iter().skip(side).step_by(2);
        let ends = |side| {
            let ends: Vec<Vec3> =
                one_by_one(side).map(|e| vertices[usize::from(e.origin)]).collect();
            groups(&ends)
        };
        let faces = |side| {
            let faces: Vec<Vec3> = one_by_one(side).map(|e| normals[usize::from(e.face)]).collect();
            groups(&faces)
        };
        let (ends, faces) = (ends(0).into_iter().zip(ends(1)), faces(0).into_iter().zip(faces(1)));
        let edges = ends
            .zip(faces)
            .map(|((p, q), (u, v))| EdgeLanes { ends: [p, q], normals: [u, v] })
            .collect();
        Self {
            edges,
            vertices: groups(vertices),
            normals: groups(&normals),
            offsets: planes.chunks(LANES).map(group).collect(),
            edge_bounds: half_edges.chunks(2 * LANES).map(bounds).collect(),
            edge_count: half_edges.len() / 2,
        }
    }

    /// The vertices [m, local]; the last group is padded with the last vertex.
    #[inline]
    pub(crate) fn vertices(&self) -> &[Vectors] {
        &self.vertices
    }

    /// Normals and offsets of the faces; the last group is padded with the last face.
    #[inline]
    pub(crate) fn planes(&self) -> impl Iterator<Item = (&Vectors, &Lanes)> {
        self.normals.iter().zip(&self.offsets)
    }

    /// The edges, in the order of their numbers.
    #[inline]
    pub(crate) fn edges(&self) -> &[EdgeLanes] {
        &self.edges
    }

    /// Corners of the bounding box of the rotated vertices.
    #[inline(always)]
    pub(crate) fn turned_bounds<S: Simd>(&self, simd: S, turn: &Mat3) -> (Vec3, Vec3) {
        let x = Vec3w::splat(simd, turn.x);
        let y = Vec3w::splat(simd, turn.y);
        let z = Vec3w::splat(simd, turn.z);
        let (low, high) = (splat(simd, f32::INFINITY), splat(simd, f32::NEG_INFINITY));
        let mut low = Vec3w { x: low, y: low, z: low };
        let mut high = Vec3w { x: high, y: high, z: high };
        for v in &self.vertices {
            let v = v.load(simd);
            let v = x * v.x + y * v.y + z * v.z;
            low = Vec3w { x: min(v.x, low.x), y: min(v.y, low.y), z: min(v.z, low.z) };
            high = Vec3w { x: max(v.x, high.x), y: max(v.y, high.y), z: max(v.z, high.z) };
        }
        let low = vec3(reduce_min(low.x), reduce_min(low.y), reduce_min(low.z));
        (low, vec3(reduce_max(high.x), reduce_max(high.y), reduce_max(high.z)))
    }

    /// Edge number `k`.
    #[inline(always)]
    pub(crate) fn edge(&self, k: usize) -> Edge {
        let (group, i) = (&self.edges[k / LANES], k % LANES);
        let tail = group.ends[0].at(i);
        let normals = [group.normals[0].at(i), group.normals[1].at(i)];
        Edge { tail, d: group.ends[1].at(i) - tail, normals }
    }

    /// Minimum of `n` · v over the vertices.
    #[inline(always)]
    pub(crate) fn min_along<S: Simd>(&self, simd: S, n: Vec3) -> f32 {
        min_along(simd, &self.vertices, n)
    }

    /// Returns the first vertex whose `n` · v equals `minimum`, the result of [`Self::min_along`].
    #[inline(always)]
    pub(crate) fn lowest_at<S: Simd>(&self, simd: S, n: Vec3, minimum: f32) -> usize {
        lowest_at(simd, &self.vertices, n, minimum)
    }

    /// Returns the vertex with the minimum of `n` · v, the first of several.
    #[inline(always)]
    pub(crate) fn lowest_vertex<S: Simd>(&self, simd: S, n: Vec3) -> usize {
        self.lowest_at(simd, n, self.min_along(simd, n))
    }

    /// Returns the face whose normal is most opposite to `n`, the first of several.
    #[inline(always)]
    pub(crate) fn face_against<S: Simd>(&self, simd: S, n: Vec3) -> usize {
        lowest_at(simd, &self.normals, n, min_along(simd, &self.normals, n))
    }

    /// Returns the face with the largest distance to `p` [local], the first of several.
    #[inline(always)]
    pub(crate) fn farthest_face<S: Simd>(&self, simd: S, p: Vec3) -> usize {
        let reach = splat(simd, self.outside(simd, p));
        let p = Vec3w::splat(simd, p);
        for (group, (n, offset)) in self.planes().enumerate() {
            let d = n.load(simd).dot(p) - load(simd, offset);
            let first = ALL & !bits(above(reach, d));
            if first != 0 {
                return group * LANES + first.trailing_zeros() as usize;
            }
        }
        0
    }

    /// Maximum signed distance of `p` from the faces [m]; negative inside.
    #[inline(always)]
    pub(crate) fn outside<S: Simd>(&self, simd: S, p: Vec3) -> f32 {
        let p = Vec3w::splat(simd, p);
        let mut far = splat(simd, f32::NEG_INFINITY);
        for (n, offset) in self.planes() {
            far = max(n.load(simd).dot(p) - load(simd, offset), far);
        }
        reduce_max(far)
    }

    /// Lists the edges, by their first half-edges, along which a body that contains `p` may be
    /// separated by at least `floor`, up to `rounding` [m].
    ///
    /// Let f(n) = n · p − max over the hull of n · v, for directions n between the normals of
    /// the two faces at an edge. Along that arc f is a cosine. Where f is above zero it is
    /// therefore at most the nearer face's distance divided by the cosine of half the arc;
    /// elsewhere it is at most that distance.
    #[inline(always)]
    pub(crate) fn find_edges<S: Simd>(
        &self,
        simd: S,
        p: Vec3,
        (floor, rounding): (f32, f32),
        out: &mut EdgeList,
    ) {
        let positive = splat(simd, greater(floor, 0.0));
        let rest = splat(simd, lesser(floor, 0.0) - rounding);
        let p = Vec3w::splat(simd, p);
        out.count = 0;
        for (group, (edges, bounds)) in self.edges.iter().zip(&self.edge_bounds).enumerate() {
            let d = edges.normals[0].load(simd).dot(p) - load(simd, &bounds.offsets[0]);
            let e = edges.normals[1].load(simd).dot(p) - load(simd, &bounds.offsets[1]);
            let minimum = positive * load(simd, &bounds.cos) + rest;
            let mut found = !bits(above(minimum, max(d, e))) & lanes_in_use(self.edge_count, group);
            while found != 0 {
                let edge = group * LANES + found.trailing_zeros() as usize;
                found &= found - 1;
                #[expect(clippy::cast_possible_truncation, reason = "half-edges have u16 numbers")]
                let half_edge = (2 * edge) as u16;
                out.add(half_edge);
            }
        }
    }

    /// Minimum and maximum of `n` · v over the vertices.
    #[inline]
    pub(crate) fn reach_along(&self, n: Vec3) -> (f32, f32) {
        let (mut minimum, mut maximum) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        for v in &self.vertices {
            let along = v.dot(n);
            for i in 0..LANES {
                minimum[i] = lesser(along[i], minimum[i]);
                maximum[i] = greater(along[i], maximum[i]);
            }
        }
        (smallest(&minimum), greatest(&maximum))
    }

    /// Number of the vertex farthest along `n`, the first of several.
    #[inline]
    pub(crate) fn farthest_along(&self, n: Vec3) -> usize {
        max_along(&self.vertices, n)
    }

    /// Number of the face whose normal is farthest along `n`, the first of several.
    #[inline]
    pub(crate) fn face_along(&self, n: Vec3) -> usize {
        max_along(&self.normals, n)
    }
}

/// Minimum of `n` · v.
#[inline(always)]
fn min_along<S: Simd>(simd: S, vectors: &[Vectors], n: Vec3) -> f32 {
    let n = Vec3w::splat(simd, n);
    let mut low = splat(simd, f32::INFINITY);
    for v in vectors {
        low = min(n.dot(v.load(simd)), low);
    }
    reduce_min(low)
}

/// Returns the first vector whose `n` · v equals `minimum`, the result of [`min_along`].
#[inline(always)]
fn lowest_at<S: Simd>(simd: S, vectors: &[Vectors], n: Vec3, minimum: f32) -> usize {
    let (n, minimum) = (Vec3w::splat(simd, n), splat(simd, minimum));
    for (group, v) in vectors.iter().enumerate() {
        let lowest = ALL & !bits(above(n.dot(v.load(simd)), minimum));
        if lowest != 0 {
            return group * LANES + lowest.trailing_zeros() as usize;
        }
    }
    0
}

fn groups(vectors: &[Vec3]) -> Vec<Vectors> {
    let group = |chunk: &[Vec3]| {
        let last = chunk[chunk.len() - 1];
        let mut v = Vectors { x: [last.x; LANES], y: [last.y; LANES], z: [last.z; LANES] };
        for (i, p) in chunk.iter().enumerate() {
            (v.x[i], v.y[i], v.z[i]) = (p.x, p.y, p.z);
        }
        v
    };
    vectors.chunks(LANES).map(group).collect()
}

/// Number of the vector farthest along `n`, the first of several; 0 if nothing compares.
fn max_along(vectors: &[Vectors], n: Vec3) -> usize {
    let mut maximum = [f32::NEG_INFINITY; LANES];
    for v in vectors {
        let along = v.dot(n);
        for i in 0..LANES {
            maximum[i] = greater(along[i], maximum[i]);
        }
    }
    let maximum = greatest(&maximum);
    // A second pass instead of carrying the numbers along, for which compilers make poor code.
    for (g, v) in vectors.iter().enumerate() {
        if let Some(i) = first_reaching(&v.dot(n), maximum) {
            return g * LANES + i;
        }
    }
    0
}

/// Returns the first lane that is at least `minimum`.
#[inline]
fn first_reaching(group: &Lanes, minimum: f32) -> Option<usize> {
    let mut any = false;
    for d in group {
        any |= *d >= minimum;
    }
    any.then(|| group.iter().position(|d| *d >= minimum)).flatten()
}

/// The largest lane. Not inlined: otherwise the compiler lays out the preceding loops for it.
#[inline(never)]
fn greatest(group: &Lanes) -> f32 {
    let [a, b, c, d, e, f, g, h] = *group;
    greater(greater(greater(a, b), greater(c, d)), greater(greater(e, f), greater(g, h)))
}

/// The smallest lane.
#[inline(never)]
fn smallest(group: &Lanes) -> f32 {
    let [a, b, c, d, e, f, g, h] = *group;
    lesser(lesser(lesser(a, b), lesser(c, d)), lesser(lesser(e, f), lesser(g, h)))
}
