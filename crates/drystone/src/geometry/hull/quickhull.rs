//! Triangulates the hull of points: quickhull [Barber96] in double precision.
//!
//! The input is `f32`, so sums and products of three coordinates are almost exact here, and the
//! surface stays convex by construction. A point within `tolerance` of the surface counts as on it.
//! This also welds near duplicates, since a point next to a vertex is never farther out than that.

use std::collections::BinaryHeap;

use crate::base::double::{DVec3, greater};

/// A triangle of the surface.
#[derive(Clone, Debug)]
pub(super) struct Triangle {
    /// Corners, counter-clockwise seen from outside.
    pub(super) v: [usize; 3],
    /// `adjacent[k]` is the triangle across the edge from `v[k]` to `v[(k + 1) % 3]`.
    pub(super) adjacent: [usize; 3],
    pub(super) normal: DVec3,
    pub(super) offset: f64,
    alive: bool,
    /// Number of the last insertion that saw this triangle.
    seen: usize,
    /// Points above it that are not yet in the hull, and the farthest of them.
    above: Vec<usize>,
    farthest: Option<(f64, usize)>,
}

impl Triangle {
    /// Returns `None` where the corners are within `tiny` of a line.
    fn new(points: &[DVec3], v: [usize; 3], adjacent: [usize; 3], tiny: f64) -> Option<Self> {
        let [a, b, c] = v.map(|i| points[i]);
        let n = (b - a).cross(c - a);
        let length = n.length();
        let longest = greater((b - a).length(), greater((c - b).length(), (a - c).length()));
        if length <= longest * tiny {
            return None;
        }
        let normal = n * (1.0 / length);
        let offset = normal.dot(a);
        let (above, farthest) = (Vec::new(), None);
        Some(Self { v, adjacent, normal, offset, alive: true, seen: 0, above, farthest })
    }

    pub(super) fn distance(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    fn take(&mut self, point: usize, distance: f64) {
        self.above.push(point);
        if self.farthest.is_none_or(|(d, _)| distance > d) {
            self.farthest = Some((distance, point));
        }
    }
}

/// Reason why there is no surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Failure {
    /// The maximum thickness found.
    Flat(f64),
}

struct Builder<'a> {
    points: &'a [DVec3],
    triangles: Vec<Triangle>,
    tolerance: f64,
    /// Lengths below this are rounding noise of `f64`.
    noise: f64,
    /// Farthest first; an entry is stale if its triangle is dead or has another farthest point.
    queue: BinaryHeap<(u64, core::cmp::Reverse<usize>)>,
    insertions: usize,
    vertices: usize,
}

/// Computes the surface around `points`, with at most `max_vertices` corners, farthest points
/// first. `points` are relative to a center near them; if they are thinner than `minimum`, they are
/// flat.
pub(super) fn triangulate(
    points: &[DVec3],
    max_vertices: usize,
    tolerance: f64,
    minimum: f64,
) -> Result<Vec<Triangle>, Failure> {
    let corners = simplex(points, minimum)?;
    let [a, b, c, _] = corners.map(|i| points[i]);
    let size = greater((b - a).length(), (c - a).length());
    let mut builder = Builder {
        points,
        triangles: Vec::new(),
        tolerance,
        noise: size * 1.0e-12,
        queue: BinaryHeap::new(),
        insertions: 0,
        vertices: 4,
    };
    builder.start(corners);
    // A point can end up above a triangle that it was never tested against. Once the surface is
    // closed, all points are tested against all triangles. The number of rounds is limited, so that
    // rounding cannot make them endless.
    for _ in 0..4 {
        builder.expand(max_vertices);
        if builder.vertices >= max_vertices || !builder.collect_missed() {
            break;
        }
    }
    Ok(builder.finish())
}

/// Finds four points far apart, the last below the triangle of the other three.
fn simplex(points: &[DVec3], minimum: f64) -> Result<[usize; 4], Failure> {
    // The other coordinates break ties: otherwise a point inside a flat face could become a corner
    // and use up the vertex limit.
    let keys: [fn(DVec3) -> [f64; 3]; 3] =
        [|p| [p.x, p.y, p.z], |p| [p.y, p.z, p.x], |p| [p.z, p.x, p.y]];
    let mut extremes = [0; 6];
    for (k, key) in keys.iter().enumerate() {
        for (i, p) in points.iter().enumerate() {
            if key(*p) < key(points[extremes[2 * k]]) {
                extremes[2 * k] = i;
            }
            if key(*p) > key(points[extremes[2 * k + 1]]) {
                extremes[2 * k + 1] = i;
            }
        }
    }
    let mut pair = (0.0, 0, 0);
    for a in extremes {
        for b in extremes {
            let length = (points[b] - points[a]).length();
            if length > pair.0 {
                pair = (length, a, b);
            }
        }
    }
    let (length, a, b) = pair;
    if length <= minimum {
        return Err(Failure::Flat(0.0));
    }
    let along = (points[b] - points[a]) * (1.0 / length);
    let (width, c) = farthest(points, |p| along.cross(p - points[a]).length());
    if width <= minimum {
        return Err(Failure::Flat(0.0));
    }
    let normal = along.cross(points[c] - points[a]);
    let normal = normal * (1.0 / normal.length());
    let (thickness, d) = farthest(points, |p| normal.dot(p - points[a]).abs());
    if thickness <= minimum {
        return Err(Failure::Flat(thickness));
    }
    let below = normal.dot(points[d] - points[a]) < 0.0;
    Ok(if below { [a, b, c, d] } else { [a, c, b, d] })
}

fn farthest(points: &[DVec3], measure: impl Fn(DVec3) -> f64) -> (f64, usize) {
    let key = |p: DVec3| [measure(p), p.x, p.y, p.z];
    let mut best = ([0.0; 4], 0);
    for (i, p) in points.iter().enumerate() {
        let k = key(*p);
        if k[0] > 0.0 && k > best.0 {
            best = (k, i);
        }
    }
    (best.0[0], best.1)
}

impl Builder<'_> {
    fn start(&mut self, [a, b, c, d]: [usize; 4]) {
        let faces = [
            ([a, b, c], [1, 2, 3]),
            ([b, a, d], [0, 3, 2]),
            ([c, b, d], [0, 1, 3]),
            ([a, c, d], [0, 2, 1]),
        ];
        for (v, adjacent) in faces {
            if let Some(t) = Triangle::new(self.points, v, adjacent, 0.0) {
                self.triangles.push(t);
            }
        }
        let all: Vec<usize> = (0..self.points.len()).collect();
        self.assign(&all, 0, &[]);
    }

    /// Assigns each point to the triangle it is highest above, among those from `first` on and
    /// `more`.
    fn assign(&mut self, points: &[usize], first: usize, more: &[usize]) {
        for &p in points {
            let mut best = (self.tolerance, usize::MAX);
            for t in (first..self.triangles.len()).chain(more.iter().copied()) {
                let d = self.triangles[t].distance(self.points[p]);
                if d > best.0 {
                    best = (d, t);
                }
            }
            if best.1 != usize::MAX {
                self.triangles[best.1].take(p, best.0);
            }
        }
        for t in (first..self.triangles.len()).chain(more.iter().copied()) {
            self.enqueue(t);
        }
    }

    fn enqueue(&mut self, t: usize) {
        if let Some((d, _)) = self.triangles[t].farthest {
            // The bits of positive floats increase with their values.
            self.queue.push((d.to_bits(), core::cmp::Reverse(t)));
        }
    }

    fn expand(&mut self, max_vertices: usize) {
        while self.vertices < max_vertices {
            let Some((key, core::cmp::Reverse(t))) = self.queue.pop() else { return };
            let triangle = &self.triangles[t];
            let Some((d, eye)) = triangle.farthest.filter(|_| triangle.alive) else { continue };
            if d.to_bits() != key {
                continue;
            }
            // A triangle counts as hidden if the eye is within this height of its plane. A
            // threshold that cuts through triangles that share a line with the eye leaves a sliver;
            // another threshold may not.
            let inserted =
                [1.0e3, 1.0e5, 0.0].iter().any(|scale| self.insert(t, eye, self.noise * scale));
            if !inserted {
                self.drop_point(t, eye);
            }
        }
    }

    /// Drops a point that cannot be joined cleanly; the final check measures the error.
    fn drop_point(&mut self, t: usize, point: usize) {
        let above = core::mem::take(&mut self.triangles[t].above);
        self.triangles[t].farthest = None;
        for p in above {
            if p != point {
                let d = self.triangles[t].distance(self.points[p]);
                self.triangles[t].take(p, d);
            }
        }
        self.enqueue(t);
    }

    /// Replaces all triangles that `eye` sees by a cone to it. Returns false, with nothing changed,
    /// if their rim is not one simple loop or a new triangle would have no area.
    fn insert(&mut self, first: usize, eye: usize, hidden: f64) -> bool {
        self.insertions += 1;
        let at = self.points[eye];
        self.triangles[first].seen = self.insertions;
        let mut visible = vec![first];
        // Rim edge: from, to, the triangle beyond.
        let mut rim: Vec<(usize, usize, usize)> = Vec::new();
        let mut next = 0;
        while let Some(&t) = visible.get(next) {
            next += 1;
            for k in 0..3 {
                let beyond = self.triangles[t].adjacent[k];
                let other = &mut self.triangles[beyond];
                if other.seen != self.insertions && other.distance(at) > hidden {
                    other.seen = self.insertions;
                    visible.push(beyond);
                }
            }
        }
        for &t in &visible {
            let triangle = &self.triangles[t];
            for k in 0..3 {
                let beyond = triangle.adjacent[k];
                if self.triangles[beyond].seen != self.insertions {
                    rim.push((triangle.v[k], triangle.v[(k + 1) % 3], beyond));
                }
            }
        }
        if !order_loop(&mut rim) {
            return false;
        }
        let base = self.triangles.len();
        let n = rim.len();
        let mut cone = Vec::with_capacity(n);
        for (k, &(a, b, beyond)) in rim.iter().enumerate() {
            let adjacent = [beyond, base + (k + 1) % n, base + (k + n - 1) % n];
            match Triangle::new(self.points, [a, b, eye], adjacent, self.noise) {
                Some(t) => cone.push(t),
                None => return false,
            }
        }
        for (k, &(a, b, beyond)) in rim.iter().enumerate() {
            let other = &mut self.triangles[beyond];
            for j in 0..3 {
                if other.v[j] == b && other.v[(j + 1) % 3] == a {
                    other.adjacent[j] = base + k;
                }
            }
        }
        self.triangles.append(&mut cone);
        self.vertices = self.vertices + 1 - self.swallowed(&visible, &rim);
        let mut orphans = Vec::new();
        for t in visible {
            let triangle = &mut self.triangles[t];
            triangle.alive = false;
            triangle.farthest = None;
            orphans.append(&mut triangle.above);
        }
        orphans.retain(|p| *p != eye);
        let neighbors: Vec<usize> = rim.iter().map(|r| r.2).collect();
        self.assign(&orphans, base, &neighbors);
        true
    }

    /// Number of vertices of the visible triangles that are not on the rim.
    fn swallowed(&self, visible: &[usize], rim: &[(usize, usize, usize)]) -> usize {
        let mut inner: Vec<usize> = visible.iter().flat_map(|t| self.triangles[*t].v).collect();
        inner.sort_unstable();
        inner.dedup();
        inner.len() - rim.len()
    }

    /// Assigns points that are above any triangle; returns true if there are some.
    fn collect_missed(&mut self) -> bool {
        let mut missed = false;
        for p in 0..self.points.len() {
            let mut best = (self.tolerance * 2.0, usize::MAX);
            for (t, triangle) in self.triangles.iter().enumerate() {
                if triangle.alive && triangle.distance(self.points[p]) > best.0 {
                    best = (triangle.distance(self.points[p]), t);
                }
            }
            if best.1 != usize::MAX {
                self.triangles[best.1].take(p, best.0);
                self.enqueue(best.1);
                missed = true;
            }
        }
        missed
    }

    /// Returns the living triangles, renumbered.
    fn finish(self) -> Vec<Triangle> {
        let mut number = vec![0; self.triangles.len()];
        let mut count = 0;
        for (t, triangle) in self.triangles.iter().enumerate() {
            number[t] = count;
            count += usize::from(triangle.alive);
        }
        let mut living: Vec<Triangle> = self.triangles.into_iter().filter(|t| t.alive).collect();
        for t in &mut living {
            t.adjacent = t.adjacent.map(|a| number[a]);
        }
        living
    }
}

/// Sorts edges head to tail; returns false if they are not one loop that meets every vertex once.
fn order_loop(rim: &mut [(usize, usize, usize)]) -> bool {
    if rim.len() < 3 {
        return false;
    }
    rim.sort_unstable();
    if rim.windows(2).any(|w| w[0].0 == w[1].0) {
        return false;
    }
    let sorted = rim.to_vec();
    let mut at = sorted[0];
    for (k, place) in rim.iter_mut().enumerate() {
        if k > 0 {
            let Ok(i) = sorted.binary_search_by_key(&at.1, |e| e.0) else { return false };
            at = sorted[i];
            if i == 0 {
                return false;
            }
        }
        *place = at;
    }
    at.1 == sorted[0].0
}
