//! Searches for the axis with the largest separation of two polytopes.
//!
//! The search tries every axis that could be the best, which are few: a body cannot be farther away
//! along an axis than any one of its points. A first good axis gives a point of each body near the
//! contact. One pass over the planes gives the distances of these points. Axes whose bound is below
//! the best axis so far are left out: most faces by one number, most edges by two.
//!
//! Symbols: u, v normals of the two faces at an edge, d the edge's direction; R, t rotation and
//! position of one body in the frame of the other.

use fearless_simd::Simd;

use super::edges::{EdgeAxis, EdgeGroup, EdgeOf, Frames};
use crate::base::math::{Vec3, greater};
use crate::base::pose::Pose;
use crate::base::simd::wide::{
    LANES, Vec3w, above, bits, lanes_in_use, load, max, min, reduce_max, splat,
};
use crate::geometry::convex::clip::closest_of_segments;
use crate::geometry::hull::Hull;
use crate::geometry::hull::lanes::EdgeList;
use crate::geometry::manifold::PairCache;

const FACE_A: u8 = 1;
const FACE_B: u8 = 2;
const EDGES: u8 = 3;

/// Rounding error of a distance, relative to the lengths that enter it: 2^-24 for each of about ten
/// operations.
const ROUNDING: f32 = 1.0e-6;

/// Two hulls, each in the frame of the other.
pub(crate) struct Pair<'a> {
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
pub(crate) struct FaceAxis {
    pub(crate) face: usize,
    pub(crate) separation: f32,
    /// Vertex of the other hull nearest along the axis [frame of the face's hull].
    witness: Vec3,
}

impl FaceAxis {
    const NONE: Self = Self::floor(f32::NEG_INFINITY);

    /// Stands for any axis that separates by no more than this.
    const fn floor(separation: f32) -> Self {
        Self { face: 0, separation, witness: Vec3::ZERO }
    }
}

/// The best axes of each kind; axes that cannot win may be missing.
pub(crate) struct Axes {
    pub(crate) face_a: FaceAxis,
    pub(crate) face_b: FaceAxis,
    /// Only if it is better than both faces by the slack.
    pub(crate) edges: Option<EdgeAxis>,
}

/// The best faces of both hulls, and for each hull a point of the other near the contact
/// [its frame].
struct Faces {
    of: [FaceAxis; 2],
    near: [Vec3; 2],
}

/// Start of the search.
enum Start {
    /// A face: of B if true, else of A.
    Face(bool, usize),
    Edges(EdgeOf, EdgeAxis),
}

/// Parameters of [`Pair::search`].
#[derive(Clone, Copy)]
struct Limits {
    margin: f32,
    slack: f32,
}

pub(crate) enum Verdict {
    /// Some axis separates by this much [m], which is more than the margin.
    Apart(f32),
    Axes(Axes),
}

impl<'a> Pair<'a> {
    #[inline(always)]
    pub(crate) fn new(a: &'a Hull, b: &'a Hull, b_in_a: &Pose) -> Self {
        let r = b_in_a.rotation.to_mat3();
        let rt = r.transpose();
        Self {
            a: Side { hull: a, other: b, frames: Frames { r, t: b_in_a.position } },
            b: Side { hull: b, other: a, frames: Frames { r: rt, t: -(rt * b_in_a.position) } },
            rounding: ROUNDING * (b_in_a.position.length() + a.reach + b.reach),
        }
    }

    /// Returns the best axes, or the first that separates by more than `margin`. A pair of edges
    /// counts only if it is better than all faces by `slack` [m]. The search starts with the final
    /// axis of the last search. Axes below it are left out from the start, and it shows where the
    /// bodies meet.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(
        &self,
        simd: S,
        margin: f32,
        slack: f32,
        cache: &mut PairCache,
    ) -> Verdict {
        let limits = Limits { margin, slack };
        let (start, known) = match self.start(simd, cache) {
            Start::Edges(_, axis) if axis.separation > margin => {
                return Verdict::Apart(axis.separation);
            }
            Start::Edges(edge, axis) => (Start::Edges(edge, axis), Some(axis)),
            start @ Start::Face(..) => (start, None),
        };
        let Faces { of: [face_a, face_b], near } = self.faces(simd, start, limits);
        if face_a.separation > margin {
            remember(cache, FACE_A, face_a.face, 0);
            return Verdict::Apart(face_a.separation);
        }
        if face_b.separation > margin {
            remember(cache, FACE_B, 0, face_b.face);
            return Verdict::Apart(face_b.separation);
        }
        let minimum = greater(face_a.separation, face_b.separation) + slack;
        let edges = self.edges(simd, (margin, minimum), known, near);
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

    /// Returns the axis of the last search, or else the face of A that faces B's center.
    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, cache: &PairCache) -> Start {
        let (a, b) = (self.a.hull, self.b.hull);
        let (i, j) = (usize::from(cache.a), usize::from(cache.b));
        match cache.kind {
            FACE_A if i < a.planes.len() => return Start::Face(false, i),
            FACE_B if j < b.planes.len() => return Start::Face(true, j),
            EDGES if (i | 1) < a.edges.len() && (j | 1) < b.edges.len() => {
                let edge = EdgeOf::new(a, &self.b.frames, i & !1);
                if let Some(axis) = edge.against(b, j & !1) {
                    return Start::Edges(edge, axis);
                }
            }
            _ => {}
        }
        let towards = self.a.frames.point(b.center);
        Start::Face(false, a.lanes.farthest_face(simd, towards))
    }

    /// Returns the best faces. For the hull with the start face all faces count; for the other one
    /// only faces that beat the start face. After a start with a pair of edges, faces count that it
    /// does not beat by the slack. The search ends at a face beyond the margin.
    #[inline(always)]
    fn faces<S: Simd>(&self, simd: S, start: Start, limits: Limits) -> Faces {
        let Limits { margin, slack } = limits;
        let of_b = matches!(start, Start::Face(true, _));
        let (x, y) = if of_b { (&self.b, &self.a) } else { (&self.a, &self.b) };
        let in_order = |x: FaceAxis, y: FaceAxis, near_x: Vec3, near_y: Vec3| {
            let (of, near) = ([x, y], [near_x, near_y]);
            if of_b {
                Faces { of: [of[1], of[0]], near: [near[1], near[0]] }
            } else {
                Faces { of, near }
            }
        };
        // A point of the other hull near each hull, the minimum that counts, and candidates for
        // lowest points.
        let (mut near_x, near_y, first, low);
        match &start {
            Start::Face(_, face) => {
                first = x.first_face(simd, *face, margin);
                if first.separation > margin {
                    return in_order(first, FaceAxis::NONE, Vec3::ZERO, Vec3::ZERO);
                }
                (near_x, near_y, low) = (first.witness, None, [first.witness; 2]);
            }
            Start::Edges(edge, axis) => {
                let b = self.b.hull;
                let [p, q] = [b.edges[axis.b], b.edges[axis.b + 1]];
                let ends_b = [b.vertices[usize::from(p.origin)], b.vertices[usize::from(q.origin)]];
                let ends_a = [edge.tail, edge.tail + edge.d];
                let (on_a, on_b) = closest_of_segments(ends_a, ends_b);
                near_x = x.frames.point(on_b);
                first = FaceAxis::floor(axis.separation - slack);
                low = [x.frames.point(ends_b[0]), x.frames.point(ends_b[1])];
                near_y = Some((on_a, ends_a));
            }
        }
        let (mut face_x, mut outside) =
            x.best_face(simd, near_x, (first, low), margin, self.rounding);
        if face_x.separation > margin {
            return in_order(face_x, FaceAxis::NONE, near_x, Vec3::ZERO);
        }
        let handicap = if of_b { slack } else { 0.0 };
        let floor = FaceAxis::floor(face_x.separation - handicap);
        let (near_y, low) = near_y.unwrap_or_else(
            #[inline(always)]
            || {
                if face_x.face != first.face {
                    near_x = face_x.witness;
                    outside = x.hull.lanes.outside(simd, near_x);
                }
                let own = x.own_witness(simd, (near_x, outside), &face_x, self.rounding);
                let own = y.frames.point(own);
                (own, [own; 2])
            },
        );
        let (face_y, _) = y.best_face(simd, near_y, (floor, low), margin, self.rounding);
        let is_better = face_y.separation > face_x.separation;
        if matches!(start, Start::Edges(..)) {
            if face_x.separation <= first.separation {
                face_x = FaceAxis::NONE;
            }
        } else if is_better && face_y.separation <= margin {
            // Its witnesses are nearer to the contact.
            let near_y = face_y.witness;
            let outside = y.hull.lanes.outside(simd, near_y);
            let own = y.own_witness(simd, (near_y, outside), &face_y, self.rounding);
            return in_order(face_x, face_y, x.frames.point(own), near_y);
        }
        let is_any = face_y.separation > floor.separation;
        in_order(face_x, if is_any { face_y } else { FaceAxis::NONE }, near_x, near_y)
    }

    /// Returns the pair of edges with the largest separation, if that is more than `minimum`.
    /// `known` is one of the pairs; `near` holds the points that decide which pairs may be better.
    #[inline(always)]
    fn edges<S: Simd>(
        &self,
        simd: S,
        (margin, minimum): (f32, f32),
        known: Option<EdgeAxis>,
        near: [Vec3; 2],
    ) -> Option<EdgeAxis> {
        let (a, b) = (&self.a.hull.lanes, &self.b.hull.lanes);
        let floor = known.map_or(minimum, |x| greater(minimum, x.separation - self.rounding));
        let bounds = (floor, self.rounding);
        let known = known.filter(|x| x.separation > minimum);
        let (mut of_a, mut of_b) = (EdgeList::EMPTY, EdgeList::EMPTY);
        a.find_edges(simd, near[0], bounds, &mut of_a);
        if of_a.is_empty() {
            return known;
        }
        b.find_edges(simd, near[1], bounds, &mut of_b);
        if of_b.is_empty() {
            return known;
        }
        let best = self.best_edges(simd, (margin, minimum), [of_a.numbers(), of_b.numbers()]);
        match (best, known) {
            (Some(e), Some(x)) if x.separation > e.separation => known,
            (None, _) => known,
            _ => best,
        }
    }

    /// Returns the pair of edges with the largest separation above `floor`; the search ends at the
    /// first beyond `margin`. `lists` are the half-edges of A and of B that count; `None`: all.
    #[inline(always)]
    fn best_edges<S: Simd>(
        &self,
        simd: S,
        (margin, floor): (f32, f32),
        lists: [Option<&[u16]>; 2],
    ) -> Option<EdgeAxis> {
        let (a, b) = (self.a.hull, self.b.hull);
        let count = |x: &Hull, list: Option<&[u16]>| list.map_or(x.edges.len() / 2, <[u16]>::len);
        let [count_a, count_b] = [count(a, lists[0]), count(b, lists[1])];
        let mut best: Option<EdgeAxis> = None;
        let mut floor = floor;
        for from_a in (0..count_a).step_by(LANES) {
            let mut of_a = EdgeGroup::of(a, lists[0], from_a);
            of_a.place(simd, &self.b.frames);
            for from_b in (0..count_b).step_by(LANES) {
                let of_b = EdgeGroup::of(b, lists[1], from_b);
                for i in 0..of_a.len() {
                    let Some(axis) = of_b.against(simd, &of_a, i, floor) else { continue };
                    (best, floor) = (Some(axis), axis.separation);
                    if floor > margin {
                        return best;
                    }
                }
            }
        }
        best
    }
}

impl Side<'_> {
    /// Returns the separation along the normal of a face, the normal in the other hull's frame, and
    /// the minimum along it over the other hull's vertices.
    #[inline(always)]
    fn separation<S: Simd>(&self, simd: S, face: usize) -> (f32, Vec3, f32) {
        let plane = self.hull.planes[face];
        let n = self.frames.r.transpose_mul(plane.normal);
        let minimum = self.other.lanes.min_along(simd, n);
        (minimum + plane.normal.dot(self.frames.t) - plane.offset, n, minimum)
    }

    /// Returns the axis of a face, with the vertex of the minimum.
    #[inline(always)]
    fn with_witness<S: Simd>(
        &self,
        simd: S,
        (face, separation): (usize, f32),
        n: Vec3,
        minimum: f32,
    ) -> FaceAxis {
        let lowest = self.other.vertices[self.other.lanes.lowest_at(simd, n, minimum)];
        FaceAxis { face, separation, witness: self.frames.point(lowest) }
    }

    /// Returns the axis of the first face; with the witness only if it is not beyond the margin.
    #[inline(always)]
    fn first_face<S: Simd>(&self, simd: S, face: usize, margin: f32) -> FaceAxis {
        let (separation, n, minimum) = self.separation(simd, face);
        if separation > margin {
            return FaceAxis { face, ..FaceAxis::floor(separation) };
        }
        self.with_witness(simd, (face, separation), n, minimum)
    }

    /// Returns the face with the largest separation, if above `start`, else `start`. The search
    /// ends at the first face beyond `margin`. `p` is a point of the other hull, `low` are two
    /// more. Also returns how far `p` is outside the hull, if the search ran to its end.
    #[inline(always)]
    fn best_face<S: Simd>(
        &self,
        simd: S,
        p: Vec3,
        (start, low): (FaceAxis, [Vec3; 2]),
        margin: f32,
        rounding: f32,
    ) -> (FaceAxis, f32) {
        let (mut best, mut low) = (start, low);
        let mut far = splat(simd, f32::NEG_INFINITY);
        let at = Vec3w::splat(simd, p);
        for (group, (n, offset)) in self.hull.lanes.planes().enumerate() {
            let (n, offset) = (n.load(simd), load(simd, offset));
            let d = n.dot(at) - offset;
            far = max(d, far);
            let floor = splat(simd, best.separation - rounding);
            let in_use = lanes_in_use(self.hull.planes.len(), group);
            let mut near = !bits(above(floor, d)) & in_use;
            while near != 0 {
                // The body is no farther than any of its points.
                let floor = splat(simd, best.separation - rounding);
                let (v, w) = (Vec3w::splat(simd, low[0]), Vec3w::splat(simd, low[1]));
                let bound = min(d, min(n.dot(v), n.dot(w)) - offset);
                near &= !bits(above(floor, bound));
                while near != 0 {
                    let face = group * LANES + near.trailing_zeros() as usize;
                    near &= near - 1;
                    let (separation, n, minimum) = self.separation(simd, face);
                    // The first of equal ones wins, wherever the search started.
                    if separation > best.separation
                        || (separation >= best.separation && face < best.face)
                    {
                        best = self.with_witness(simd, (face, separation), n, minimum);
                        low = [best.witness, low[0]];
                        if separation > margin {
                            return (best, f32::INFINITY);
                        }
                        break;
                    }
                }
            }
        }
        (best, reduce_max(far))
    }

    /// Returns a point of the hull near the contact along a face axis: below the point `near` of
    /// the other hull, whose distance outside this hull is `outside`.
    #[inline(always)]
    fn own_witness<S: Simd>(
        &self,
        simd: S,
        (near, outside): (Vec3, f32),
        axis: &FaceAxis,
        rounding: f32,
    ) -> Vec3 {
        if outside <= rounding {
            return near;
        }
        let below = near - self.hull.planes[axis.face].normal * axis.separation;
        if self.hull.lanes.outside(simd, below) <= rounding {
            return below;
        }
        self.hull.vertices[self.hull.lanes.lowest_vertex(simd, self.hull.center - near)]
    }
}

#[expect(clippy::cast_possible_truncation, reason = "hulls have fewer than 2^16 features")]
#[inline(always)]
fn remember(cache: &mut PairCache, kind: u8, a: usize, b: usize) {
    (cache.kind, cache.a, cache.b) = (kind, a as u16, b as u16);
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::{Pair, Side, Verdict};
    use crate::base::math::{Vec3, greater};
    use crate::base::pose::Pose;
    use crate::base::simd::wide::SimdLevel;
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

    fn search(pair: &Pair<'_>, margin: f32, slack: f32, cache: &mut PairCache) -> Verdict {
        let level = SimdLevel::best().0;
        dispatch!(level, simd => pair.search(simd, margin, slack, cache))
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
            // From deep overlap to large gaps.
            let t = random.direction() * ((a.reach + b.reach) * random.signed().abs());
            let pair = Pair::new(a, b, &Pose::new(t, turn));
            let everywhere = f32::INFINITY;
            let found = search(&pair, everywhere, 0.0, &mut PairCache::default());
            let Verdict::Axes(found) = found else {
                panic!("nothing is farther apart than that");
            };
            let level = SimdLevel::best().0;
            let maximum = |side: &Side<'_>| {
                let all = (0..side.hull.planes.len())
                    .map(|i| dispatch!(level, simd => side.separation(simd, i)).0);
                all.fold(f32::NEG_INFINITY, greater)
            };
            let (of_a, of_b) = (maximum(&pair.a), maximum(&pair.b));
            assert_eq!(found.face_a.separation.to_bits(), of_a.to_bits());
            if of_b > of_a {
                assert_eq!(found.face_b.separation.to_bits(), of_b.to_bits());
            }
            let of_faces = greater(of_a, of_b);
            let all = [None, None];
            let limits = (everywhere, f32::NEG_INFINITY);
            if let Some(best) = dispatch!(level, simd => pair.best_edges(simd, limits, all))
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
    fn every_simd_level_finds_the_same_bits() {
        let mut random = Random(5);
        let hulls = hulls(&mut random);
        let mut kinds = [0; 4];
        for i in 0..2000_usize {
            let (a, b) = (&hulls[i % hulls.len()], &hulls[(i / hulls.len()) % hulls.len()]);
            let turn = random.rotation();
            let t = random.direction() * ((a.reach + b.reach) * random.signed().abs());
            let pair = Pair::new(a, b, &Pose::new(t, turn));
            let found = SimdLevel::available().into_iter().map(|SimdLevel(level)| {
                let mut cache = PairCache::default();
                let found = dispatch!(level, simd => pair.search(simd, 0.02, 1.0e-3, &mut cache));
                let gap = if let Verdict::Apart(gap) = found { gap } else { 0.0 };
                let (kind, separation) = winner(&found, 1.0e-3);
                (kind, separation.to_bits(), gap.to_bits(), cache.kind, cache.a, cache.b)
            });
            let mut found: Vec<_> = found.collect();
            kinds[usize::from(found[0].0)] += 1;
            found.dedup();
            assert_eq!(found.len(), 1, "{i}: {found:?}");
        }
        assert!(kinds.iter().all(|n| *n > 100), "{kinds:?}");
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
            // Starts from the axis of the same place, of a place near it, and of any other.
            let by = [0.0, 0.02, 1.0][i % 3];
            let before = Pose::new(t + random.direction() * by, turn);
            let mut cache = PairCache::default();
            let _ = search(&Pair::new(a, b, &before), f32::INFINITY, slack, &mut cache);
            let pair = Pair::new(a, b, &Pose::new(t, turn));
            let cold = search(&pair, margin, slack, &mut PairCache::default());
            let warm = search(&pair, margin, slack, &mut cache);
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
