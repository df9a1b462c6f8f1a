//! Turns the triangles of a surface into polygons: joins coplanar neighbors and removes the
//! vertices and faces that this makes unnecessary.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::quickhull::Triangle;
use crate::base::double::{DVec3, greater};

/// Triangles that share a plane.
struct Facet {
    triangles: Vec<usize>,
    area: f64,
    /// Minimum height of its first triangle: normals of slivers are unreliable.
    height: f64,
    /// The plane of the largest triangle. It stays fixed while the facet grows, so errors do not
    /// add up.
    normal: DVec3,
    offset: f64,
    /// Incremented on every change of the facet.
    version: u32,
}

/// Queue entry, smallest deviation first: bits of the deviation, small facet and its version, large
/// facet and its version.
type Candidate = (u64, usize, u32, usize, u32);

struct Merger<'a> {
    points: &'a [DVec3],
    triangles: &'a [Triangle],
    facet_of: Vec<usize>,
    facets: Vec<Facet>,
    tolerance: f64,
    queue: BinaryHeap<Reverse<Candidate>>,
}

/// Returns the faces of the surface as loops of point numbers, counter-clockwise seen from outside.
///
/// Facets whose corners all lie within `tolerance` of a larger neighbor's plane join it. Slivers
/// thinner than `tolerance` join the neighbor that fits best. Points scattered by about the
/// tolerance can produce a facet that is not a convex disc; it is split into its triangles again.
pub(super) fn polygons(
    points: &[DVec3],
    triangles: &[Triangle],
    tolerance: f64,
) -> Vec<Vec<usize>> {
    let mut merger = Merger::new(points, triangles, tolerance);
    merger.run();
    let mut loops = Vec::new();
    for (f, facet) in merger.facets.iter().enumerate() {
        match merger.boundary(f).filter(|rim| dent(points, rim, facet.normal) <= 4.0 * tolerance) {
            Some(rim) => loops.push(rim),
            None => loops.extend(facet.triangles.iter().map(|t| triangles[*t].v.to_vec())),
        }
    }
    remove_collinear(&mut loops, points.len());
    loops
}

/// Deviation of a loop from convexity: the maximum distance by which a corner lies inside the line
/// from the corner before it to the one after it.
pub(super) fn dent(points: &[DVec3], face: &[usize], normal: DVec3) -> f64 {
    let p = |k: usize| points[face[k % face.len()]];
    let mut worst: f64 = 0.0;
    for k in 0..face.len() {
        let chord = p(k + 2) - p(k);
        let area = chord.cross(p(k + 1) - p(k)).dot(normal);
        if area > 0.0 {
            worst = greater(worst, area / chord.length());
        }
    }
    worst
}

/// Returns the faces of the surface as triangles.
pub(super) fn unmerged(triangles: &[Triangle]) -> Vec<Vec<usize>> {
    triangles.iter().map(|t| t.v.to_vec()).collect()
}

impl<'a> Merger<'a> {
    fn new(points: &'a [DVec3], triangles: &'a [Triangle], tolerance: f64) -> Self {
        let facets = triangles
            .iter()
            .enumerate()
            .map(|(i, t)| {
                let [a, b, c] = t.v.map(|v| points[v]);
                let area = (b - a).cross(c - a).length();
                let longest =
                    greater((b - a).length(), greater((c - b).length(), (a - c).length()));
                let height = area / longest;
                let (normal, offset) = (t.normal, t.offset);
                Facet { triangles: vec![i], area, height, normal, offset, version: 0 }
            })
            .collect();
        let facet_of = (0..triangles.len()).collect();
        Self { points, triangles, facet_of, facets, tolerance, queue: BinaryHeap::new() }
    }

    fn run(&mut self) {
        for f in 0..self.facets.len() {
            self.offer(f);
        }
        while let Some(Reverse((_, small, version_small, large, version_large))) = self.queue.pop()
        {
            let fresh = self.facets[small].version == version_small
                && self.facets[large].version == version_large;
            if fresh {
                self.join(small, large);
            }
        }
    }

    /// Moves the triangles of `small` to `large` and considers the edges that came with them.
    fn join(&mut self, small: usize, large: usize) {
        let moved = core::mem::take(&mut self.facets[small].triangles);
        self.facets[small].version += 1;
        self.facets[large].area += self.facets[small].area;
        for &t in &moved {
            self.facet_of[t] = large;
        }
        for &t in &moved {
            for other in self.triangles[t].adjacent {
                self.consider(large, self.facet_of[other]);
            }
        }
        self.facets[large].triangles.extend(moved);
    }

    fn offer(&mut self, f: usize) {
        let first = self.facets[f].triangles[0];
        for other in self.triangles[first].adjacent {
            if other > first {
                self.consider(f, self.facet_of[other]);
            }
        }
    }

    fn consider(&mut self, f: usize, g: usize) {
        if f == g {
            return;
        }
        let by_area = self.facets[f].area < self.facets[g].area;
        let (small, large) = if by_area { (f, g) } else { (g, f) };
        let (plane, part) = (&self.facets[large], &self.facets[small]);
        let mut deviation: f64 = 0.0;
        for &t in &part.triangles {
            for v in self.triangles[t].v {
                let d = plane.normal.dot(self.points[v]) - plane.offset;
                deviation = greater(deviation, d.abs());
            }
        }
        // A sliver's corner lies within the sliver's height of a neighbor's edge, and this edge
        // lies within the tolerance of that neighbor's plane.
        let sliver = part.height < self.tolerance;
        let limit = if sliver { 3.0 * self.tolerance } else { self.tolerance };
        // Folded pieces are within the tolerance of the plane too; joining them would turn a thin
        // rim inside out.
        let folded = !sliver && plane.normal.dot(part.normal) <= 0.0;
        if deviation <= limit && !folded {
            self.queue.push(Reverse((
                deviation.to_bits(),
                small,
                part.version,
                large,
                plane.version,
            )));
        }
    }

    /// Returns the rim of a facet; `None` if it is more than one loop or meets a vertex twice.
    fn boundary(&self, f: usize) -> Option<Vec<usize>> {
        let inside = |t: usize| self.facet_of[t] == f;
        let mut rim: Vec<(usize, usize)> = Vec::new();
        for &t in &self.facets[f].triangles {
            let triangle = &self.triangles[t];
            for k in 0..3 {
                if !inside(triangle.adjacent[k]) {
                    rim.push((triangle.v[k], triangle.v[(k + 1) % 3]));
                }
            }
        }
        rim.sort_unstable();
        if rim.is_empty() || rim.windows(2).any(|w| w[0].0 == w[1].0) {
            return None;
        }
        let mut vertices = Vec::with_capacity(rim.len());
        let mut at = rim[0];
        for _ in 0..rim.len() {
            vertices.push(at.0);
            let i = rim.binary_search_by_key(&at.1, |e| e.0).ok()?;
            at = rim[i];
        }
        // A walk of as many steps as edges returns to the start only if there is one loop: a
        // shorter loop would have repeated its first vertex.
        let repeated = vertices[1..].contains(&vertices[0]);
        (at == rim[0] && !repeated).then_some(vertices)
    }
}

/// Removes vertices where only two faces meet, and faces that are left with fewer than three
/// vertices.
fn remove_collinear(loops: &mut Vec<Vec<usize>>, points: usize) {
    loop {
        let mut degree = vec![0_u32; points];
        for v in loops.iter().flatten() {
            degree[*v] += 1;
        }
        let before: usize = loops.iter().map(Vec::len).sum();
        for face in loops.iter_mut() {
            face.retain(|v| degree[*v] > 2);
        }
        loops.retain(|face| face.len() > 2);
        if loops.iter().map(Vec::len).sum::<usize>() == before {
            return;
        }
    }
}
