//! The search of the axis that separates two polytopes most.
//!
//! All axes are tried that could be the best one, and few could: a body cannot be farther away along
//! an axis than any one of its points. So the first good axis gives a point of each body near the
//! contact, one pass over the planes their distances, and what lies below the best axis so far is
//! left out: most faces by one number, most edges by two.
//!
//! Symbols: u, v normals of the two faces at an edge, d the edge's direction; R, t rotation and
//! position of one body in the frame of the other.

use super::edges::{EdgeAxis, EdgeGroup, EdgeOf, Frames};
use crate::base::math::{Vec3, greater, lesser};
use crate::base::pose::Pose;
use crate::base::wide::{LANES, Lanes};
use crate::geometry::clip::closest_of_segments;
use crate::geometry::hull::Hull;
use crate::geometry::hull::lanes::{any_reaches, largest};
use crate::geometry::manifold::PairCache;

const FACE_A: u8 = 1;
const FACE_B: u8 = 2;
const EDGES: u8 = 3;

/// Rounding of a distance, as a part of the lengths that go into it: 2^-24 for each of about ten
/// operations.
const ROUNDING: f32 = 1.0e-6;

/// Groups of eight planes for which bounds are kept; larger hulls are searched in full.
const NEAR_GROUPS: usize = 16;
/// Most edges that are listed.
const CANDIDATES: usize = 64;

/// Two hulls, each seen from the other.
pub(super) struct Pair<'a> {
    a: Side<'a>,
    b: Side<'a>,
    rounding: f32,
}

/// A hull, and the other one in its frame.
struct Side<'a> {
    hull: &'a Hull,
    other: &'a Hull,
    frames: Frames,
}

#[derive(Clone, Copy)]
pub(super) struct FaceAxis {
    pub(super) face: usize,
    pub(super) separation: f32,
    /// The vertex of the other hull that is nearest along the axis [frame of the face's hull].
    witness: Vec3,
}

impl FaceAxis {
    const NONE: Self = Self { face: 0, separation: f32::NEG_INFINITY, witness: Vec3::ZERO };
}

/// The best axes of each kind.
pub(super) struct Axes {
    pub(super) face_a: FaceAxis,
    /// Only if it is better than that of A.
    pub(super) face_b: FaceAxis,
    /// Only if it is better than both by the slack.
    pub(super) edges: Option<EdgeAxis>,
}

/// The best faces; those that cannot win may be missing.
struct Faces {
    face_a: FaceAxis,
    face_b: FaceAxis,
}

/// What [`Pair::search`] was asked for.
#[derive(Clone, Copy)]
struct Limits {
    margin: f32,
    slack: f32,
}

pub(super) enum Verdict {
    /// Some axis separates by so much [m], which is more than the margin.
    Apart(f32),
    Axes(Axes),
}

impl<'a> Pair<'a> {
    pub(super) fn new(a: &'a Hull, b: &'a Hull, b_in_a: &Pose) -> Self {
        let r = b_in_a.rotation.to_mat3();
        let rt = r.transpose();
        Self {
            a: Side { hull: a, other: b, frames: Frames { r, t: b_in_a.position } },
            b: Side { hull: b, other: a, frames: Frames { r: rt, t: -(rt * b_in_a.position) } },
            rounding: ROUNDING * (b_in_a.position.length() + a.reach + b.reach),
        }
    }

    /// The best axes, or the first that separates by more than `margin`. A pair of edges counts only
    /// if it is better than all faces by `slack` [m]. Begins with the axis that the last search ended
    /// with: what is below it is left out from the start, and it shows where the bodies meet.
    pub(super) fn search(&self, margin: f32, slack: f32, cache: &mut PairCache) -> Verdict {
        let mut near = [Near::new(), Near::new()];
        let limits = Limits { margin, slack };
        let (i, j) = (usize::from(cache.a), usize::from(cache.b));
        let (a, b) = (self.a.hull, self.b.hull);
        let mut first_edges = None;
        if cache.kind == EDGES && (i | 1) < a.edges.len() && (j | 1) < b.edges.len() {
            let edge = EdgeOf::new(a, &self.b.frames, i & !1);
            first_edges = edge.against(b, j & !1).map(|axis| (edge, axis));
        }
        let faces = match &first_edges {
            Some((_, axis)) if axis.separation > margin => return Verdict::Apart(axis.separation),
            Some((edge, axis)) => self.faces_from_edges(edge, axis, limits, &mut near),
            None if cache.kind == FACE_B && j < b.planes.len() => {
                self.faces_from_b(j, limits, &mut near)
            }
            None => {
                let last = (cache.kind == FACE_A && i < a.planes.len()).then_some(i);
                self.faces_from_a(last, limits, &mut near)
            }
        };
        let Faces { face_a, face_b } = faces;
        if face_a.separation > margin {
            remember(cache, FACE_A, face_a.face, 0);
            return Verdict::Apart(face_a.separation);
        }
        if face_b.separation > margin {
            remember(cache, FACE_B, 0, face_b.face);
            return Verdict::Apart(face_b.separation);
        }
        let least = greater(face_a.separation, face_b.separation) + slack;
        let known = first_edges.map(|(_, axis)| axis);
        let floor = known.map_or(least, |x| greater(least, x.separation - self.rounding));
        let [near_a, near_b] = &near;
        let edges_a = near_a.edges(a, floor, self.rounding);
        let mut edges = None;
        if edges_a.count > 0 {
            let edges_b = near_b.edges(b, floor, self.rounding);
            edges = self.best_edges(margin, [edges_a.numbers(), edges_b.numbers()]);
        }
        if let Some(x) = known
            && edges.is_none_or(|e| x.separation > e.separation)
        {
            edges = known;
        }
        let edges = edges.filter(|e| e.separation > least);
        if let Some(e) = edges {
            remember(cache, EDGES, e.a, e.b);
            if e.separation > margin {
                return Verdict::Apart(e.separation);
            }
        } else if face_b.separation > face_a.separation + slack {
            remember(cache, FACE_B, 0, face_b.face);
        } else {
            remember(cache, FACE_A, face_a.face, 0);
        }
        Verdict::Axes(Axes { face_a, face_b, edges })
    }

    /// The best faces, beginning with a face of A: the last one, or the one that looks at B's center.
    /// Where a face is beyond the margin the search ends. Leaves in `near` how far points of the bodies
    /// near the contact are from the planes of the other.
    fn faces_from_a(&self, last: Option<usize>, limits: Limits, near: &mut [Near; 2]) -> Faces {
        let [near_a, near_b] = near;
        let start = last.unwrap_or_else(|| {
            near_a.measure(self.a.hull, self.a.frames.point(self.b.hull.center));
            near_a.farthest(self.a.hull)
        });
        let first = self.a.first_face(start, limits.margin);
        if first.separation > limits.margin {
            return Faces { face_a: first, face_b: FaceAxis::NONE };
        }
        near_a.measure(self.a.hull, first.witness);
        let low = [first.witness; 2];
        let face_a = self.a.best_face(near_a, first, low, limits.margin, self.rounding);
        if face_a.separation > limits.margin {
            return Faces { face_a, face_b: FaceAxis::NONE };
        }
        if face_a.face != first.face {
            near_a.measure(self.a.hull, face_a.witness);
        }
        let in_a = self.b.frames.point(self.a.own_witness(near_a, &face_a, self.rounding));
        near_b.measure(self.b.hull, in_a);
        let floor = FaceAxis { separation: face_a.separation, ..FaceAxis::NONE };
        let mut face_b = self.b.best_face(near_b, floor, [in_a; 2], limits.margin, self.rounding);
        if face_b.separation > face_a.separation {
            // Its witnesses are nearer to the contact.
            near_b.measure(self.b.hull, face_b.witness);
            let in_b = self.b.own_witness(near_b, &face_b, self.rounding);
            near_a.measure(self.a.hull, self.a.frames.point(in_b));
        } else {
            face_b = FaceAxis::NONE;
        }
        Faces { face_a, face_b }
    }

    /// The same, beginning with a face of B: only faces of A that it does not beat by the slack count.
    fn faces_from_b(&self, last: usize, limits: Limits, near: &mut [Near; 2]) -> Faces {
        let [near_a, near_b] = near;
        let first = self.b.first_face(last, limits.margin);
        if first.separation > limits.margin {
            return Faces { face_a: FaceAxis::NONE, face_b: first };
        }
        near_b.measure(self.b.hull, first.witness);
        let low = [first.witness; 2];
        let face_b = self.b.best_face(near_b, first, low, limits.margin, self.rounding);
        if face_b.separation > limits.margin {
            return Faces { face_a: FaceAxis::NONE, face_b };
        }
        if face_b.face != first.face {
            near_b.measure(self.b.hull, face_b.witness);
        }
        let in_b = self.a.frames.point(self.b.own_witness(near_b, &face_b, self.rounding));
        near_a.measure(self.a.hull, in_b);
        let floor = FaceAxis { separation: face_b.separation - limits.slack, ..FaceAxis::NONE };
        let face_a = self.a.best_face(near_a, floor, [in_b; 2], limits.margin, self.rounding);
        if face_a.separation <= floor.separation {
            return Faces { face_a: FaceAxis::NONE, face_b };
        }
        if face_a.separation < face_b.separation {
            return Faces { face_a, face_b };
        }
        near_a.measure(self.a.hull, face_a.witness);
        let in_a = self.a.own_witness(near_a, &face_a, self.rounding);
        near_b.measure(self.b.hull, self.b.frames.point(in_a));
        Faces { face_a, face_b: FaceAxis::NONE }
    }

    /// The same, beginning with a pair of edges: only faces that it does not beat by the slack count, and
    /// where the edges are nearest is the contact.
    fn faces_from_edges(
        &self,
        edge: &EdgeOf,
        axis: &EdgeAxis,
        limits: Limits,
        near: &mut [Near; 2],
    ) -> Faces {
        let [near_a, near_b] = near;
        let (a, b) = (self.a.hull, self.b.hull);
        let ends_b =
            [b.edges[axis.b], b.edges[axis.b + 1]].map(|e| b.vertices[usize::from(e.origin)]);
        let ends_a = [edge.tail, edge.tail + edge.d];
        let (on_a, on_b) = closest_of_segments(ends_a, ends_b);
        near_a.measure(a, self.a.frames.point(on_b));
        near_b.measure(b, on_a);
        let floor = FaceAxis { separation: axis.separation - limits.slack, ..FaceAxis::NONE };
        let low = [self.a.frames.point(ends_b[0]), self.a.frames.point(ends_b[1])];
        let mut face_a = self.a.best_face(near_a, floor, low, limits.margin, self.rounding);
        let mut face_b = FaceAxis::NONE;
        if face_a.separation <= limits.margin {
            let floor = FaceAxis { separation: face_a.separation, ..FaceAxis::NONE };
            face_b = self.b.best_face(near_b, floor, ends_a, limits.margin, self.rounding);
            if face_b.separation <= floor.separation {
                face_b = FaceAxis::NONE;
            }
        }
        if face_a.separation <= floor.separation {
            face_a = FaceAxis::NONE;
        }
        Faces { face_a, face_b }
    }

    /// The pair of edges that separates most; the search ends at the first beyond `margin`. `numbers`
    /// are the half-edges of A and of B that count; `None`: all.
    fn best_edges(&self, margin: f32, numbers: [Option<&[u16]>; 2]) -> Option<EdgeAxis> {
        let (a, b) = (self.a.hull, self.b.hull);
        let count = |x: &Hull, list: Option<&[u16]>| list.map_or(x.edges.len() / 2, <[u16]>::len);
        let number = |list: Option<&[u16]>, k: usize| list.map_or(2 * k, |l| usize::from(l[k]));
        let [count_a, count_b] = [count(a, numbers[0]), count(b, numbers[1])];
        let mut best: Option<EdgeAxis> = None;
        if count_a == 0 {
            return best;
        }
        let mut group = EdgeGroup::new();
        for from in (0..count_b).step_by(LANES) {
            let lanes = LANES.min(count_b - from);
            for lane in 0..lanes {
                group.put(lane, b, number(numbers[1], from + lane));
            }
            for i in 0..count_a {
                let edge = EdgeOf::new(a, &self.b.frames, number(numbers[0], i));
                let crossing = group.crossed_by(&edge);
                for (lane, crosses) in crossing.into_iter().enumerate().take(lanes) {
                    if !crosses {
                        continue;
                    }
                    let Some(axis) = edge.against(b, number(numbers[1], from + lane)) else {
                        continue;
                    };
                    if best.is_none_or(|x| axis.separation > x.separation) {
                        best = Some(axis);
                        if axis.separation > margin {
                            return best;
                        }
                    }
                }
            }
        }
        best
    }
}

impl Side<'_> {
    /// Separation along the normal of a face, the normal seen from the other hull, and the least of it over
    /// that one's vertices.
    #[inline]
    fn separation(&self, face: usize) -> (f32, Vec3, f32) {
        let plane = self.hull.planes[face];
        let n = self.frames.r.transpose_mul(plane.normal);
        let least = self.other.lanes.least_along(n);
        (least + plane.normal.dot(self.frames.t) - plane.offset, n, least)
    }

    /// The axis of a face, with the vertex that gave the least.
    #[inline]
    fn with_witness(&self, face: usize, separation: f32, n: Vec3, least: f32) -> FaceAxis {
        let lowest = self.other.vertices[self.other.lanes.lowest_at(n, least)];
        FaceAxis { face, separation, witness: self.frames.point(lowest) }
    }

    /// The axis of the face to begin with; the witness only if that is not beyond the margin.
    #[inline]
    fn first_face(&self, face: usize, margin: f32) -> FaceAxis {
        let (separation, n, least) = self.separation(face);
        if separation > margin {
            return FaceAxis { face, separation, witness: Vec3::ZERO };
        }
        self.with_witness(face, separation, n, least)
    }

    /// The face that separates more than `start`, most of all; else `start`. The search ends at the
    /// first beyond `margin`. `near` holds the distances of some point of the other hull, `low` are two more.
    fn best_face(
        &self,
        near: &Near,
        start: FaceAxis,
        low: [Vec3; 2],
        margin: f32,
        rounding: f32,
    ) -> FaceAxis {
        let mut best = start;
        let mut low = low;
        near.for_faces(self.hull, start.separation - rounding, |face, d| {
            if d + rounding < best.separation {
                return true;
            }
            let plane = &self.hull.planes[face];
            if lesser(plane.distance(low[0]), plane.distance(low[1])) + rounding < best.separation {
                return true;
            }
            let (separation, n, least) = self.separation(face);
            // Of equal ones the first, wherever the search began.
            if separation > best.separation || (separation >= best.separation && face < best.face) {
                best = self.with_witness(face, separation, n, least);
                low = [best.witness, low[0]];
            }
            best.separation <= margin
        });
        best
    }

    /// A point of the hull near the contact along a face axis: below the other's witness, which is
    /// known by its distances `near`.
    fn own_witness(&self, near: &Near, axis: &FaceAxis, rounding: f32) -> Vec3 {
        let w = axis.witness;
        if near.is_inside(self.hull, rounding) {
            return w;
        }
        let below = w - self.hull.planes[axis.face].normal * axis.separation;
        let mut at = Near::new();
        at.measure(self.hull, below);
        if at.is_inside(self.hull, rounding) {
            return below;
        }
        self.hull.vertices[self.hull.lanes.farthest_along(w - self.hull.center)]
    }
}

/// The distances of a point of one hull from the planes of another: upper bounds of what the planes'
/// normals can separate.
struct Near {
    distances: [Lanes; NEAR_GROUPS],
    /// The planes do not fit: nothing is known.
    overflow: bool,
}

/// The edges that may carry a contact.
struct Candidates {
    numbers: [u16; CANDIDATES],
    count: usize,
}

impl Candidates {
    /// `None`: all of them.
    fn numbers(&self) -> Option<&[u16]> {
        self.numbers.get(..self.count)
    }
}

impl Near {
    const fn new() -> Self {
        Self { distances: [[0.0; LANES]; NEAR_GROUPS], overflow: false }
    }

    fn measure(&mut self, of: &Hull, point: Vec3) {
        self.overflow = of.planes.len() > NEAR_GROUPS * LANES;
        if !self.overflow {
            of.lanes.distances(point, &mut self.distances);
        }
    }

    /// The face of `of` farthest from the center, the first of several.
    fn farthest(&self, of: &Hull) -> usize {
        if self.overflow {
            return 0;
        }
        largest(&self.distances[..of.planes.len().div_ceil(LANES)])
    }

    /// True if the measured point is in `of`, up to rounding.
    fn is_inside(&self, of: &Hull, rounding: f32) -> bool {
        let mut outside = self.overflow;
        for group in &self.distances[..of.planes.len().div_ceil(LANES).min(NEAR_GROUPS)] {
            for d in group {
                outside |= *d > rounding;
            }
        }
        !outside
    }

    /// Of plane `i`; infinite if not known.
    #[inline]
    fn at(&self, i: usize) -> f32 {
        if self.overflow { f32::INFINITY } else { self.distances[i / LANES][i % LANES] }
    }

    /// Calls `f` for the faces of `of` whose distance is at least `floor`, in order, until it says no.
    #[inline]
    fn for_faces(&self, of: &Hull, floor: f32, mut f: impl FnMut(usize, f32) -> bool) {
        let count = of.planes.len();
        if self.overflow {
            let _ = (0..count).all(|face| f(face, f32::INFINITY));
            return;
        }
        for (g, group) in self.distances[..count.div_ceil(LANES)].iter().enumerate() {
            if !any_reaches(group, floor) {
                continue;
            }
            for (i, d) in group.iter().enumerate() {
                let face = g * LANES + i;
                if *d >= floor && face < count && !f(face, *d) {
                    return;
                }
            }
        }
    }

    /// Edges of `of` along which a body that contains the measured point may be separated by more than
    /// `floor`.
    fn edges(&self, of: &Hull, floor: f32, rounding: f32) -> Candidates {
        let mut found = Candidates { numbers: [0; CANDIDATES], count: 0 };
        if self.overflow {
            found.count = CANDIDATES + 1;
            return found;
        }
        // Where no edge bulges by more than the largest, one of an edge's two faces must reach this.
        let widest = of.lanes.widest_bulge();
        let least = if floor > 0.0 { floor / widest } else { floor } - 2.0 * rounding;
        self.for_faces(of, least, |face, d| {
            let first = of.face_edges[face];
            let mut e = first;
            loop {
                let edge = of.edges[usize::from(e)];
                let other = usize::from(of.edges[usize::from(e ^ 1)].face);
                let across = self.at(other);
                // Each edge once: at the nearer of its faces.
                if (d > across || (d >= across && face < other))
                    && of.lanes.edge_bound(usize::from(e / 2), d + rounding, across + rounding)
                        >= floor
                {
                    if let Some(number) = found.numbers.get_mut(found.count) {
                        *number = e & !1;
                    }
                    found.count += 1;
                }
                e = edge.next;
                if e == first {
                    return true;
                }
            }
        });
        found
    }
}

#[expect(clippy::cast_possible_truncation, reason = "hulls have fewer than 2^16 features")]
fn remember(cache: &mut PairCache, kind: u8, a: usize, b: usize) {
    (cache.kind, cache.a, cache.b) = (kind, a as u16, b as u16);
}

#[cfg(test)]
mod tests {
    use super::{Pair, Side, Verdict};
    use crate::base::math::{Vec3, greater};
    use crate::base::pose::Pose;
    use crate::geometry::collide::tests::Random;
    use crate::geometry::hull::Hull;
    use crate::geometry::manifold::PairCache;

    fn hulls(random: &mut Random) -> Vec<Hull> {
        let cloud = |random: &mut Random, n: usize, scale: Vec3| {
            let points: Vec<Vec3> = (0..n).map(|_| random.direction().mul_each(scale)).collect();
            Hull::from_points(&points).unwrap()
        };
        let mut all = vec![Hull::cuboid(Vec3::splat(0.5)), Hull::cuboid([0.1, 1.0, 2.0].into())];
        for n in [4, 6, 10, 32, 120] {
            all.push(cloud(random, n, Vec3::ONE));
            all.push(cloud(random, n, [1.0, 0.3, 0.05].into()));
        }
        all
    }

    #[test]
    fn what_is_not_looked_at_cannot_be_the_best_axis() {
        let mut random = Random(77);
        let hulls = hulls(&mut random);
        let mut with_edges = 0;
        for _ in 0..6000 {
            let pick = |r: &mut Random| {
                let n = hulls.len();
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "small"
                )]
                let k = ((r.signed() * 0.5 + 0.5) * 1000.0) as usize;
                &hulls[k % n]
            };
            let (a, b) = (pick(&mut random), pick(&mut random));
            let turn = random.rotation();
            // From deep overlap to well apart.
            let t = random.direction() * ((a.reach + b.reach) * random.signed().abs());
            let pair = Pair::new(a, b, &Pose::new(t, turn));
            let everywhere = f32::INFINITY;
            let Verdict::Axes(found) = pair.search(everywhere, 0.0, &mut PairCache::default())
            else {
                panic!("nothing is farther apart than that");
            };
            let most = |side: &Side<'_>| {
                let all = (0..side.hull.planes.len()).map(|i| side.separation(i).0);
                all.fold(f32::NEG_INFINITY, greater)
            };
            let (of_a, of_b) = (most(&pair.a), most(&pair.b));
            assert_eq!(found.face_a.separation.to_bits(), of_a.to_bits());
            if of_b > of_a {
                assert_eq!(found.face_b.separation.to_bits(), of_b.to_bits());
            }
            let of_faces = greater(of_a, of_b);
            if let Some(best) = pair.best_edges(everywhere, [None, None])
                && best.separation > of_faces
            {
                with_edges += 1;
                let few = found.edges.map(|x| x.separation.to_bits());
                assert_eq!(few, Some(best.separation.to_bits()));
            }
        }
        assert!(with_edges > 500, "{with_edges}");
    }

    /// Kind and separation of the axis that carries the contact, or that separates.
    fn winner(verdict: &Verdict, slack: f32) -> (u8, f32) {
        match verdict {
            Verdict::Apart(_) => (0, 0.0),
            Verdict::Axes(x) => match x.edges {
                Some(e) => (3, e.separation),
                None if x.face_b.separation > x.face_a.separation + slack => {
                    (2, x.face_b.separation)
                }
                None => (1, x.face_a.separation),
            },
        }
    }

    #[test]
    fn where_the_search_begins_does_not_show_in_what_it_finds() {
        let mut random = Random(31);
        let hulls = hulls(&mut random);
        let mut kinds = [0; 4];
        for i in 0..6000_usize {
            let (a, b) = (&hulls[i % hulls.len()], &hulls[(i / hulls.len()) % hulls.len()]);
            let slack = if i % 2 == 0 { 0.0 } else { 1.0e-3 };
            let margin = 0.1 * random.signed().abs();
            let turn = random.rotation();
            let t = random.direction() * ((a.reach + b.reach) * random.signed().abs());
            // From the axis of the same place, of one near it, and of any other.
            let by = [0.0, 0.02, 1.0][i % 3];
            let before = Pose::new(t + random.direction() * by, turn);
            let mut cache = PairCache::default();
            let _ = Pair::new(a, b, &before).search(f32::INFINITY, slack, &mut cache);
            let pair = Pair::new(a, b, &Pose::new(t, turn));
            let cold = pair.search(margin, slack, &mut PairCache::default());
            let warm = pair.search(margin, slack, &mut cache);
            let ((kind, separation), (other, same)) = (winner(&cold, slack), winner(&warm, slack));
            kinds[usize::from(kind)] += 1;
            if kind != 0 && other == 0 {
                // A pair of edges beyond the margin that does not beat the faces by the slack.
                assert!(separation > margin - slack - 4.0 * pair.rounding, "{i}");
                continue;
            }
            assert_eq!((kind, separation.to_bits()), (other, same.to_bits()), "{i}");
        }
        assert!(kinds.iter().all(|n| *n > 300), "{kinds:?}");
    }
}
