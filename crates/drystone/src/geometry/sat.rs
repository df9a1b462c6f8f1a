//! Two polytopes to a manifold: separating axes, then clipping [Gregorius13].
//!
//! Symbols: u, v normals of the two faces at an edge, d the edge's direction; R, t rotation and
//! position of B in the frame of A.

use super::clip::{Polygon, Reference, clip, closest_of_segments, flip};
use super::gjk;
use super::hull::{HalfEdge, Hull};
use super::manifold::Manifold;
use super::manifold::PairCache;
use crate::base::math::{Mat3, Vec3, greater};
use crate::base::pose::Pose;
use crate::base::wide::{LANES, Lanes};

const FACE_A: u8 = 1;
const FACE_B: u8 = 2;
const EDGES: u8 = 3;

/// Feature ids begin with what the reference is.
const REFERENCE_B: u32 = 0x8000_0000;
const EDGE_PAIR: u32 = 0x4000_0000;

/// Squared sine below which two edges count as parallel (0.3°): the axes of faces serve there.
const PARALLEL: f32 = 2.5e-5;

/// Part of the size by which a later kind of axis must be better than an earlier one: without it
/// rounding would choose, and feature ids would flicker.
const PREFERENCE: f32 = 1.0e-3;

/// Rounding of a distance, as a part of the lengths that go into it: 2^-24 for each of about ten
/// operations.
const ROUNDING: f32 = 1.0e-6;

/// Groups of eight planes for which bounds are kept; larger hulls are searched in full.
const NEAR_GROUPS: usize = 16;
/// Most edges that are listed.
const CANDIDATES: usize = 64;

/// Rotation and position of B in the frame of A.
#[derive(Clone, Copy)]
struct Frames {
    r: Mat3,
    t: Vec3,
}

#[derive(Clone, Copy)]
struct FaceAxis {
    face: usize,
    separation: f32,
}

#[derive(Clone, Copy)]
struct EdgeAxis {
    /// Half-edges of A and of B.
    a: usize,
    b: usize,
    separation: f32,
    /// Unit, from A to B [frame of B].
    normal: Vec3,
}

/// The manifold of two hulls in the frame of A. Points farther apart than `margin` [m] are left out.
///
/// Every axis that could be the best one is tried, but few are: B contains a ball about its center, so
/// along an axis it cannot be farther from A than that ball is. One pass over the planes gives this
/// bound for all faces, and two of its numbers that for an edge.
pub(crate) fn collide_hulls(
    a: &Hull,
    b: &Hull,
    b_in_a: &Pose,
    margin: f32,
    cache: &mut PairCache,
) -> Manifold {
    let r = b_in_a.rotation.to_mat3();
    let b_frames = Frames { r, t: b_in_a.position };
    let rt = r.transpose();
    let a_frames = Frames { r: rt, t: -(rt * b_in_a.position) };
    if let Some(gap) = cached_separation(a, b, &b_frames, &a_frames, *cache)
        && gap > margin
    {
        return Manifold::apart(gap);
    }
    let rounding = ROUNDING * (b_in_a.position.length() + a.reach + b.reach);
    let (mut near_a, mut near_b) = (Near::new(), Near::new());
    near_a.measure(a, b, &b_frames);
    let face_a = best_face(a, b, &b_frames, margin, &near_a, rounding);
    if face_a.separation > margin {
        remember(cache, FACE_A, face_a.face, 0);
        return Manifold::apart(face_a.separation);
    }
    near_b.measure(b, a, &a_frames);
    let face_b = best_face(b, a, &a_frames, margin, &near_b, rounding);
    if face_b.separation > margin {
        remember(cache, FACE_B, 0, face_b.face);
        return Manifold::apart(face_b.separation);
    }
    let slack = PREFERENCE * thinness(a, b);
    let of_faces = greater(face_a.separation, face_b.separation);
    // An edge contact must be better than this, so edges that cannot be are not looked at.
    let floor = of_faces + slack;
    let edges_a = near_a.edges(a, b.inner, floor, rounding);
    let edges_b = near_b.edges(b, a.inner, floor, rounding);
    let edges = best_edges(a, b, &a_frames, margin, [edges_a.numbers(), edges_b.numbers()]);
    if let Some(e) = edges
        && e.separation > floor
    {
        remember(cache, EDGES, e.a, e.b);
        return if e.separation > margin {
            Manifold::apart(e.separation)
        } else {
            edge_contact(a, b, b_in_a, &e)
        };
    }
    let m = if face_b.separation > face_a.separation + slack {
        remember(cache, FACE_B, 0, face_b.face);
        let a_in_b = Pose { position: a_frames.t, rotation: b_in_a.rotation.conjugate() };
        flip(&face_contact(b, a, &a_in_b, face_b.face, margin, REFERENCE_B), b_in_a)
    } else {
        remember(cache, FACE_A, face_a.face, 0);
        face_contact(a, b, b_in_a, face_a.face, margin, 0)
    };
    if m.count > 0 { m } else { beside_the_face(a, b, b_in_a, margin, m.normal, of_faces) }
}

#[expect(clippy::cast_possible_truncation, reason = "hulls have fewer than 2^16 features")]
fn remember(cache: &mut PairCache, kind: u8, a: usize, b: usize) {
    (cache.kind, cache.a, cache.b) = (kind, a as u16, b as u16);
}

/// The separation along the axis that the cache names: one of those that the full search would try.
fn cached_separation(
    a: &Hull,
    b: &Hull,
    b_frames: &Frames,
    a_frames: &Frames,
    cache: PairCache,
) -> Option<f32> {
    let (i, j) = (usize::from(cache.a), usize::from(cache.b));
    match cache.kind {
        FACE_A if i < a.planes.len() => Some(face_separation(a, b, b_frames, i)),
        FACE_B if j < b.planes.len() => Some(face_separation(b, a, a_frames, j)),
        EDGES if (i | 1) < a.edges.len() && (j | 1) < b.edges.len() => {
            let edge = EdgeOf::new(a, a_frames, i & !1);
            edge.against(b, j & !1).map(|x| x.separation)
        }
        _ => None,
    }
}

#[inline]
fn face_separation(a: &Hull, b: &Hull, frames: &Frames, face: usize) -> f32 {
    let plane = a.planes[face];
    let n = frames.r.transpose_mul(plane.normal);
    b.lanes.least_along(n) + plane.normal.dot(frames.t) - plane.offset
}

/// The distances of the center of one hull from the planes of another.
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

    fn measure(&mut self, of: &Hull, other: &Hull, frames: &Frames) {
        self.overflow = of.planes.len() > NEAR_GROUPS * LANES;
        if !self.overflow {
            of.lanes.distances(frames.r * other.center + frames.t, &mut self.distances);
        }
    }

    /// The face of `of` farthest from the center, the first of several.
    fn farthest(&self, of: &Hull) -> usize {
        if self.overflow {
            return 0;
        }
        let (mut first, mut most) = (0, f32::NEG_INFINITY);
        for (g, group) in self.distances[..of.planes.len().div_ceil(LANES)].iter().enumerate() {
            for (i, d) in group.iter().enumerate() {
                // The last group is filled up with the last plane, which comes first.
                if *d > most {
                    (first, most) = (g * LANES + i, *d);
                }
            }
        }
        first
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
            let mut most = group[0];
            for d in group {
                most = greater(*d, most);
            }
            if most < floor {
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

    /// Edges of `of` along which a body that contains a ball of radius `inner` about the measured
    /// center may be separated by more than `floor`.
    fn edges(&self, of: &Hull, inner: f32, floor: f32, rounding: f32) -> Candidates {
        let mut found = Candidates { numbers: [0; CANDIDATES], count: 0 };
        if self.overflow {
            found.count = CANDIDATES + 1;
            return found;
        }
        let floor = floor + inner;
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

/// The face of `a` that separates most; the search ends at the first beyond `margin`.
fn best_face(
    a: &Hull,
    b: &Hull,
    frames: &Frames,
    margin: f32,
    near: &Near,
    rounding: f32,
) -> FaceAxis {
    let first = near.farthest(a);
    let mut best = FaceAxis { face: first, separation: face_separation(a, b, frames, first) };
    if best.separation > margin {
        return best;
    }
    let floor = best.separation + b.inner - rounding;
    near.for_faces(a, floor, |face, d| {
        if face == first || d - b.inner + rounding < best.separation {
            return true;
        }
        let separation = face_separation(a, b, frames, face);
        // Of equal ones the first, wherever the search began.
        if separation > best.separation || (separation >= best.separation && face < best.face) {
            best = FaceAxis { face, separation };
        }
        separation <= margin
    });
    best
}

/// Half the least width of the thinner hull, seen from its center; flat ones do not count.
fn thinness(a: &Hull, b: &Hull) -> f32 {
    let (thin, thick) = if a.inner < b.inner { (a.inner, b.inner) } else { (b.inner, a.inner) };
    if thin > 1.0e-3 * thick { thin } else { thick }
}

fn normal_of(x: &Hull, e: HalfEdge) -> Vec3 {
    x.planes[usize::from(e.face)].normal
}

/// An edge of A with what the test against edges of B needs, in the frame of B.
struct EdgeOf {
    edge: usize,
    tail: Vec3,
    d: Vec3,
    u: Vec3,
    v: Vec3,
}

impl EdgeOf {
    #[inline]
    fn new(a: &Hull, a_frames: &Frames, edge: usize) -> Self {
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
    fn against(&self, b: &Hull, edge_b: usize) -> Option<EdgeAxis> {
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

/// The pair of edges that separates most; the search ends at the first beyond `margin`. `numbers`
/// are the half-edges of A and of B that count; `None`: all.
fn best_edges(
    a: &Hull,
    b: &Hull,
    a_frames: &Frames,
    margin: f32,
    numbers: [Option<&[u16]>; 2],
) -> Option<EdgeAxis> {
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
            let edge = EdgeOf::new(a, a_frames, number(numbers[0], i));
            let crossing = group.crossed_by(&edge);
            for (lane, crosses) in crossing.into_iter().enumerate().take(lanes) {
                if !crosses {
                    continue;
                }
                let Some(axis) = edge.against(b, number(numbers[1], from + lane)) else { continue };
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

/// Eight edges of B: normals of both faces and the edge itself.
struct EdgeGroup {
    u: [Lanes; 3],
    v: [Lanes; 3],
    d: [Lanes; 3],
}

impl EdgeGroup {
    const fn new() -> Self {
        let none = [[0.0; LANES]; 3];
        Self { u: none, v: none, d: none }
    }

    #[inline]
    fn put(&mut self, lane: usize, b: &Hull, edge: usize) {
        let (e, twin) = (b.edges[edge], b.edges[edge + 1]);
        let (u, v) = (normal_of(b, e), normal_of(b, twin));
        let d = b.vertices[usize::from(twin.origin)] - b.vertices[usize::from(e.origin)];
        for k in 0..3 {
            (self.u[k][lane], self.v[k][lane], self.d[k][lane]) = (u[k], v[k], d[k]);
        }
    }

    /// Which of the arcs are crossed by that of `edge`: the first test of [`EdgeOf::against`].
    #[inline]
    fn crossed_by(&self, edge: &EdgeOf) -> [bool; LANES] {
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

/// The corners of a face; every k-th of a very large one.
pub(crate) fn face_polygon(x: &Hull, face: usize, out: &mut Polygon) {
    out.clear();
    let Some(&first) = x.face_edges.get(face) else { return };
    let mut count = 0;
    let mut e = first;
    while count < x.edges.len() {
        count += 1;
        e = x.edges[usize::from(e)].next;
        if e == first {
            break;
        }
    }
    let stride = Polygon::stride(count);
    for k in 0..count {
        let edge = x.edges[usize::from(e)];
        if k % stride == 0 {
            out.add(x.vertices[usize::from(edge.origin)], u32::from(edge.origin));
        }
        e = edge.next;
    }
}

/// The face whose normal is most along `direction`.
#[inline]
pub(crate) fn face_along(x: &Hull, direction: Vec3) -> usize {
    x.lanes.face_along(direction)
}

/// Contact of face `face` of A with the face of B that looks at it most.
fn face_contact(
    a: &Hull,
    b: &Hull,
    b_in_a: &Pose,
    face: usize,
    margin: f32,
    flag: u32,
) -> Manifold {
    let plane = a.planes[face];
    let n = plane.normal;
    let incident_face = face_along(b, -b_in_a.local_direction(n));
    let (mut reference, mut incident) = (Polygon::empty(), Polygon::empty());
    face_polygon(a, face, &mut reference);
    face_polygon(b, incident_face, &mut incident);
    incident.transform(b_in_a);
    let reference = Reference { corners: reference.corners(), normal: n, offset: plane.offset };
    clip(&reference, &mut incident, margin, flag)
}

fn edge_contact(a: &Hull, b: &Hull, b_in_a: &Pose, e: &EdgeAxis) -> Manifold {
    let ends = |x: &Hull, k: usize| {
        [x.edges[k], x.edges[k + 1]].map(|h| x.vertices[usize::from(h.origin)])
    };
    let edge_b = ends(b, e.b).map(|p| b_in_a.point(p));
    let (on_a, on_b) = closest_of_segments(ends(a, e.a), edge_b);
    let normal = b_in_a.direction(e.normal);
    #[expect(clippy::cast_possible_truncation, reason = "fewer than 2^15 edges")]
    let feature = EDGE_PAIR | (e.a as u32 & 0x7fff) << 15 | (e.b as u32 & 0x7fff);
    Manifold::single(normal, (on_a + on_b) * 0.5, e.separation, feature)
}

/// No axis separates by more than the margin and yet nothing lies above the face: corners or edges
/// pass beside it. The true closest points decide; where the polytopes overlap after all, the corner
/// of B that is deepest along the face normal `n` does, at the separation of the faces.
fn beside_the_face(
    a: &Hull,
    b: &Hull,
    b_in_a: &Pose,
    margin: f32,
    n: Vec3,
    of_faces: f32,
) -> Manifold {
    let closest = gjk::distance(
        |d| support(a, d),
        |d| b_in_a.point(support(b, b_in_a.local_direction(d))),
        b_in_a.point(b.center) - a.center,
    );
    match closest {
        Some(c) if c.distance > margin => Manifold::apart(c.distance),
        Some(c) => Manifold::single(c.normal, (c.point_a + c.point_b) * 0.5, c.distance, EDGE_PAIR),
        None if of_faces <= 0.0 => {
            let corner = b_in_a.point(support(b, -b_in_a.local_direction(n)));
            Manifold::single(n, corner - n * (0.5 * of_faces), of_faces, EDGE_PAIR)
        }
        _ => Manifold::default(),
    }
}

/// The vertex farthest along `direction`.
#[inline]
pub(crate) fn support(x: &Hull, direction: Vec3) -> Vec3 {
    x.vertices[x.lanes.farthest_along(direction)]
}

#[cfg(test)]
mod tests {
    use super::{Frames, Near, best_edges, best_face, face_separation};
    use crate::base::math::{Vec3, greater};
    use crate::geometry::collide::tests::Random;
    use crate::geometry::hull::Hull;

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
            let r = random.rotation().to_mat3();
            // From deep overlap to well apart.
            let t = random.direction() * ((a.reach + b.reach) * random.signed().abs());
            let to_a = Frames { r, t };
            let rt = r.transpose();
            let to_b = Frames { r: rt, t: -(rt * t) };
            let rounding = 1.0e-6 * (t.length() + a.reach + b.reach);
            let everywhere = f32::INFINITY;
            let mut of_faces = f32::NEG_INFINITY;
            let mut near = [Near::new(), Near::new()];
            for (near, (x, y, frames)) in near.iter_mut().zip([(a, b, to_a), (b, a, to_b)]) {
                near.measure(x, y, &frames);
                let found = best_face(x, y, &frames, everywhere, near, rounding);
                let all = (0..x.planes.len()).map(|i| face_separation(x, y, &frames, i));
                let best = all.fold(f32::NEG_INFINITY, greater);
                assert_eq!(found.separation.to_bits(), best.to_bits());
                of_faces = greater(of_faces, best);
            }
            let lists = [
                near[0].edges(a, b.inner, of_faces, rounding),
                near[1].edges(b, a.inner, of_faces, rounding),
            ];
            let few = best_edges(a, b, &to_b, everywhere, [lists[0].numbers(), lists[1].numbers()]);
            let all = best_edges(a, b, &to_b, everywhere, [None, None]);
            if let Some(best) = all
                && best.separation > of_faces
            {
                with_edges += 1;
                assert_eq!(few.map(|x| x.separation.to_bits()), Some(best.separation.to_bits()));
            }
        }
        assert!(with_edges > 500, "{with_edges}");
    }
}
