//! A hull's vertices, planes and edges laid out for the search of separating axes: eight at a time.
//!
//! Plain arrays, not the wide vocabulary: a lane never depends on its neighbour, so the compiler makes
//! of each loop what the target has, and the result is the same everywhere.

use fearless_simd::Simd;

use super::{HalfEdge, Plane};
use crate::base::math::{Mat3, Vec3, greater, lesser, vec3};
use crate::base::wide::{LANES, Lanes, Vec3w, least, load, max, min, most, splat};

/// Three coordinates, eight of each.
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

/// See the module.
#[derive(Clone, Debug)]
pub(crate) struct HullLanes {
    /// Vertices; the last group is filled up with the last vertex.
    vertices: Vec<Vectors>,
    /// Normals and offsets of the faces; the last group is filled up with the last plane.
    normals: Vec<Vectors>,
    offsets: Vec<Lanes>,
    /// Edges; the last group is filled up with the last edge.
    edges: Vec<EdgeLanes>,
    /// Per edge, 1 / cos of half the angle between the normals of its two faces.
    bulges: Vec<f32>,
    widest_bulge: f32,
}

impl HullLanes {
    pub(crate) fn new(vertices: &[Vec3], planes: &[Plane], edges: &[HalfEdge]) -> Self {
        let bulge = |pair: &[HalfEdge]| {
            let [m, n] = [pair[0], pair[1]].map(|e| planes[usize::from(e.face)].normal);
            // cos² of half the angle; opposite normals (a flat body) bulge without bound.
            let square = 0.5 + 0.5 * m.dot(n);
            if square > 1.0e-5 { 1.0 / square.sqrt() } else { f32::INFINITY }
        };
        let group = |chunk: &[Plane]| {
            let mut offsets = [chunk[chunk.len() - 1].offset; LANES];
            for (to, plane) in offsets.iter_mut().zip(chunk) {
                *to = plane.offset;
            }
            offsets
        };
        let normals: Vec<Vec3> = planes.iter().map(|p| p.normal).collect();
        let bulges: Vec<f32> = edges.chunks_exact(2).map(bulge).collect();
        let one_by_one = |side: usize| edges.iter().skip(side).step_by(2);
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
            widest_bulge: bulges.iter().copied().fold(1.0, greater),
            vertices: groups(vertices),
            normals: groups(&normals),
            offsets: planes.chunks(LANES).map(group).collect(),
            bulges,
        }
    }

    /// The vertices [m, local]; the last group is filled up with the last vertex.
    #[inline]
    pub(crate) fn vertices(&self) -> &[Vectors] {
        &self.vertices
    }

    /// Normals and offsets of the faces; the last group is filled up with the last face.
    #[inline]
    pub(crate) fn planes(&self) -> impl Iterator<Item = (&Vectors, &Lanes)> {
        self.normals.iter().zip(&self.offsets)
    }

    /// The edges in the order of their numbers.
    #[inline]
    pub(crate) fn edges(&self) -> &[EdgeLanes] {
        &self.edges
    }

    /// The corners of the box around the turned vertices.
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
        let low = vec3(least(low.x), least(low.y), least(low.z));
        (low, vec3(most(high.x), most(high.y), most(high.z)))
    }

    /// The least of `n` · v over the vertices.
    #[inline]
    pub(crate) fn least_along(&self, n: Vec3) -> f32 {
        let mut least = [f32::INFINITY; LANES];
        for v in &self.vertices {
            let along = v.dot(n);
            for i in 0..LANES {
                least[i] = lesser(along[i], least[i]);
            }
        }
        smallest(&least)
    }

    /// The least and the greatest of `n` · v over the vertices.
    #[inline]
    pub(crate) fn reach_along(&self, n: Vec3) -> (f32, f32) {
        let (mut least, mut most) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        for v in &self.vertices {
            let along = v.dot(n);
            for i in 0..LANES {
                least[i] = lesser(along[i], least[i]);
                most[i] = greater(along[i], most[i]);
            }
        }
        (smallest(&least), greatest(&most))
    }

    /// The first vertex whose `n` · v is `least`, as [`Self::least_along`] found it.
    #[inline]
    pub(crate) fn lowest_at(&self, n: Vec3, least: f32) -> usize {
        for (g, v) in self.vertices.iter().enumerate() {
            let mut below = [0.0; LANES];
            let along = v.dot(n);
            for i in 0..LANES {
                below[i] = -along[i];
            }
            if let Some(i) = first_reaching(&below, -least) {
                return g * LANES + i;
            }
        }
        0
    }

    /// The vertex number farthest along `n`, the first of several.
    #[inline]
    pub(crate) fn farthest_along(&self, n: Vec3) -> usize {
        most_along(&self.vertices, n)
    }

    /// The face whose normal is most along `n`, the first of several.
    #[inline]
    pub(crate) fn face_along(&self, n: Vec3) -> usize {
        most_along(&self.normals, n)
    }

    /// Signed distances of `p` from the planes, in groups of eight; as many as `out` has room for.
    #[inline]
    pub(crate) fn distances(&self, p: Vec3, out: &mut [Lanes]) {
        for ((n, offset), out) in self.normals.iter().zip(&self.offsets).zip(out) {
            for i in 0..LANES {
                out[i] = n.x[i] * p.x + n.y[i] * p.y + n.z[i] * p.z - offset[i];
            }
        }
    }

    /// The largest 1 / cos of half the angle between the normals at an edge; infinite if some are
    /// opposite.
    #[inline]
    pub(crate) const fn widest_bulge(&self) -> f32 {
        self.widest_bulge
    }

    /// An upper bound of (n · p − the hull's reach along n) over the directions n between the normals
    /// of the two faces at edge `edge`, if `d` and `e` are the distances of p from these faces. The
    /// quantity is a cosine along that arc, so it exceeds the nearer end's by no more than the bulge
    /// where it is above zero, and not at all below.
    #[inline]
    pub(crate) fn edge_bound(&self, edge: usize, d: f32, e: f32) -> f32 {
        let (most, bulge) = (greater(d, e), self.bulges[edge]);
        if bulge == f32::INFINITY {
            bulge
        } else if most > 0.0 {
            most * bulge
        } else {
            most
        }
    }
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

/// The number of the vector that is most along `n`, the first of several; 0 if nothing compares.
fn most_along(vectors: &[Vectors], n: Vec3) -> usize {
    let mut most = [f32::NEG_INFINITY; LANES];
    for v in vectors {
        let along = v.dot(n);
        for i in 0..LANES {
            most[i] = greater(along[i], most[i]);
        }
    }
    let most = greatest(&most);
    // Once more rather than to carry the numbers along: compilers make poor code of that.
    for (g, v) in vectors.iter().enumerate() {
        if let Some(i) = first_reaching(&v.dot(n), most) {
            return g * LANES + i;
        }
    }
    0
}

/// The place of the largest number, the first of several; 0 if nothing compares.
pub(crate) fn largest(groups: &[Lanes]) -> usize {
    let mut most = [f32::NEG_INFINITY; LANES];
    for group in groups {
        for i in 0..LANES {
            most[i] = greater(group[i], most[i]);
        }
    }
    let most = greatest(&most);
    for (g, group) in groups.iter().enumerate() {
        if let Some(i) = first_reaching(group, most) {
            return g * LANES + i;
        }
    }
    0
}

/// The first lane that is at least `least`.
#[inline]
fn first_reaching(group: &Lanes, least: f32) -> Option<usize> {
    any_reaches(group, least).then(|| group.iter().position(|d| *d >= least)).flatten()
}

/// True if some lane is at least `least`.
#[inline]
pub(crate) fn any_reaches(group: &Lanes, least: f32) -> bool {
    let mut any = false;
    for d in group {
        any |= *d >= least;
    }
    any
}

/// The largest lane. Not inlined: the loops before it would be laid out for it, not for themselves.
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
