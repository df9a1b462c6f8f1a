//! Distance of a convex solid from another solid, and its motion up to the first hit.
//!
//! The motion uses conservative advancement [Mirtich96]. A plane between the two at their closest
//! points stays between them until the moving solid has covered their distance along its normal, so
//! it may advance by that much. The normals converge to the contact normal, and the steps shrink as
//! fast as the gap does.

mod turning;

use super::boxes::Ray;
use super::collide::convex::Convex;
use super::collide::{MAX_PARTS, MeshScratch, Reach, collide, collide_mesh};
use super::convex::gjk;
use super::manifold::{Manifold, ManifoldPoint, PairCache};
use super::mesh::{Mesh, Pack};
use super::solid::{Core, Solid};
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater, lesser};
use crate::base::pose::Pose;
use crate::base::simd::wide::SimdLevel;

/// The closest points of A and B, in the frame of A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearby {
    /// Distance [m]; below 0: the depth of the overlap along the normal.
    pub(crate) distance: f32,
    pub(crate) point_a: Vec3,
    pub(crate) point_b: Vec3,
    /// Unit normal, from A to B.
    pub(crate) normal: Vec3,
}

/// The first hit of the moving B on A, in the frame of A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meeting {
    /// Fraction of the motion, 0 to 1; 0 for an overlap at the start.
    pub(crate) fraction: f32,
    pub(crate) point: Vec3,
    /// Unit normal, from A to B.
    pub(crate) normal: Vec3,
    /// Whether they overlap at the start by more than some roundings.
    pub(crate) overlap: bool,
}

/// Maximum number of advancement steps: 3 to 10 for polytopes, 30 for grazed round bodies. A search
/// that takes longer counts as a hit where it stands, slightly before the true one.
const MAX_STEPS: usize = 64;

/// Maximum distance that counts as a hit, relative to sizes and positions: some roundings of f32.
const MET: f32 = 2.0e-6;

/// Maximum angle [rad] into or out of a surface for a motion along it: some roundings of a
/// direction.
pub(crate) const ALONG: f32 = 1.0e-6;

/// Height above a surface at which a shape slides along it, in multiples of the distance that
/// counts as a hit. Whatever is flush with the surface then stays clear; otherwise a seam would
/// stop the shape.
const CLEAR: f32 = 4.0;

/// Shift that moves the two apart to find a normal, relative to the smaller one's size: closest
/// points that are too near give none.
const APART: f32 = 0.01;

/// Returns the closest points of A and the convex B, unless they are farther apart than `reach`
/// [m].
pub(crate) fn closest(a: &Solid, b: &Solid, b_in_a: &Pose, reach: f32) -> Option<Nearby> {
    let placed = Placed::new(a, b, b_in_a)?;
    let found = match &a.core {
        Core::HalfSpace { normal, offset } => placed.above(*normal, *offset),
        Core::Mesh(mesh) => closest_triangle(mesh, &placed, b, greater(reach, 0.0))?,
        core => {
            let x = Convex::of(core)?;
            let set = convex_set(&x);
            placed.nearby(&set, Vec3::ZERO).unwrap_or_else(|| placed.touching(&set))
        }
    };
    let apart = found.distance > 0.0;
    let near = if apart { found } else { deepest(a, b, b_in_a).unwrap_or(found) };
    (near.distance <= reach).then_some(near)
}

/// Motion of B relative to A, at constant velocity, up to a fraction of it [frame of A].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Course {
    /// Displacement of the origin of B's frame [m].
    pub(crate) delta: Vec3,
    /// Rotation about that origin, as a rotation vector [rad].
    pub(crate) turn: Vec3,
    /// The part of the motion to search, 0 to 1.
    pub(crate) limit: f32,
}

impl Course {
    /// A whole motion without rotation [m].
    pub(crate) const fn straight(delta: Vec3) -> Self {
        Self { delta, turn: Vec3::ZERO, limit: 1.0 }
    }
}

/// The surfaces that B touches and slides along.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sliding {
    /// Direction off all of them: at least 1 along each normal. Zero if B touches nothing.
    pub(crate) off: Vec3,
    /// Maximum height by which flush surfaces may stand out, because positions are rounded [m].
    pub(crate) minimum: f32,
}

impl Sliding {
    /// Shift of B off the surfaces [m]; `met` is the distance that counts as a hit [m].
    fn shift(&self, met: f32) -> Vec3 {
        self.off * greater(CLEAR * met, self.minimum)
    }
}

/// Calls `tell` with the normals, from A to B, along which the two touch within `slack` [m] plus
/// some roundings.
pub(crate) fn touched(a: &Solid, b: &Solid, b_in_a: &Pose, slack: f32, mut tell: impl FnMut(Vec3)) {
    let (made, margin) = manifolds(a, b, b_in_a, slack);
    for m in &made {
        let deepest = m.points().iter().map(|p| p.separation).fold(f32::INFINITY, lesser);
        if deepest.abs() <= margin {
            tell(m.normal);
        }
    }
}

/// Returns the first hit of the convex B on A.
pub(crate) fn meet(
    a: &Solid,
    b: &Solid,
    b_in_a: &Pose,
    course: &Course,
    sliding: &Sliding,
) -> Option<Meeting> {
    let placed = Placed { sliding: *sliding, ..Placed::new(a, b, b_in_a)? };
    let Course { delta, limit, .. } = *course;
    // A ball that turns does not change.
    let turns = course.turn != Vec3::ZERO && !matches!(b.core, Core::Point);
    let found = match &a.core {
        _ if turns => turning::meet(a, b, &placed, course),
        Core::HalfSpace { normal, offset } => placed.fall(*normal, *offset, delta, limit),
        Core::Mesh(mesh) => meet_triangle(mesh, &placed, b, delta, limit),
        core => {
            let x = Convex::of(core)?;
            placed.advance(&convex_set(&x), delta, limit, || deepest(a, b, b_in_a))
        }
    }?;
    // An overlap with a single triangle only uses its plane; all triangles together give a better
    // one.
    if found.fraction > 0.0 || !matches!(a.core, Core::Mesh(_)) {
        return Some(found);
    }
    let Some(deep) = deepest(a, b, b_in_a) else {
        return Some(Meeting { overlap: false, ..found });
    };
    let met = placed.met(0.0);
    let is_in_the_way = turns || deep.normal.dot(delta) < 0.0;
    let met_at_start = Meeting::at_start(&deep, met);
    Some(if is_in_the_way {
        met_at_start
    } else {
        Meeting { overlap: met_at_start.overlap, ..found }
    })
}

impl Nearby {
    /// Returns true if the two overlap by more than the distance that counts as touching, `met`
    /// [m].
    fn overlaps(&self, met: f32) -> bool {
        self.distance < -2.0 * met
    }

    /// Returns true if the motion hits at its start. Two that only touch, within `met` [m], do not
    /// hit if B moves away from the surface or along it.
    fn meets_at_once(&self, delta: Vec3, met: f32) -> bool {
        self.overlaps(met) || self.normal.dot(delta) < -ALONG * delta.length()
    }
}

impl Meeting {
    fn at_start(near: &Nearby, met: f32) -> Self {
        let point = (near.point_a + near.point_b) * 0.5;
        Self { fraction: 0.0, point, normal: near.normal, overlap: near.overlaps(met) }
    }
}

/// The obstacle of B: a convex set, without its rounding, and a point inside it.
struct Set<F> {
    support: F,
    center: Vec3,
    /// Approximate extent [m].
    size: f32,
}

/// Converts a convex core to a set.
fn convex_set<'a>(x: &'a Convex<'_>) -> Set<impl Fn(Vec3) -> Vec3 + 'a> {
    Set { support: |d| x.support(d), center: x.center(), size: x.size() }
}

/// Returns the contacts of two solids that touch or overlap, and the maximum distance for a touch:
/// `slack` [m] plus some roundings.
fn manifolds(a: &Solid, b: &Solid, b_in_a: &Pose, slack: f32) -> ([Manifold; MAX_PARTS], f32) {
    let mut made = [Manifold::default(); MAX_PARTS];
    // Touching solids may be apart by a rounding.
    let own = if matches!(a.core, Core::Mesh(_)) { 0.0 } else { a.max_extent(Vec3::ZERO) };
    let size = own + b.max_extent(Vec3::ZERO) + b_in_a.position.abs().max_element();
    let margin = 2.0 * MET * size + slack;
    let level = SimdLevel::best().0;
    if let Core::Mesh(mesh) = &a.core {
        let reach = Reach::still(margin);
        collide_mesh(level, mesh, b, b_in_a, &reach, &mut MeshScratch::default(), &mut made);
    } else {
        made[0] = collide(level, a, b, b_in_a, margin, &mut PairCache::default());
    }
    (made, margin)
}

/// Returns the deepest contact of two solids that touch or overlap.
fn deepest(a: &Solid, b: &Solid, b_in_a: &Pose) -> Option<Nearby> {
    let (made, _) = manifolds(a, b, b_in_a, 0.0);
    let points = made.iter().flat_map(|m| m.points().iter().map(|p| (m.normal, p)));
    let by_depth = |x: &(Vec3, &ManifoldPoint), y: &(Vec3, &ManifoldPoint)| {
        x.1.separation.total_cmp(&y.1.separation)
    };
    let (normal, point) = points.min_by(by_depth)?;
    let half = normal * (0.5 * point.separation);
    let (point_a, point_b) = (point.position - half, point.position + half);
    Some(Nearby { distance: point.separation, point_a, point_b, normal })
}

/// B in the frame of A.
#[derive(Clone, Copy)]
struct Placed<'a> {
    convex: Convex<'a>,
    pose: &'a Pose,
    /// Rounding radii of A and B [m].
    radius: [f32; 2],
    /// Size of B plus its distance from the origin [m].
    size: f32,
    sliding: Sliding,
}

impl<'a> Placed<'a> {
    fn new(a: &Solid, b: &'a Solid, pose: &'a Pose) -> Option<Self> {
        let convex = Convex::of(&b.core)?;
        let size = b.max_extent(Vec3::ZERO) + pose.position.abs().max_element();
        let sliding = Sliding::default();
        Some(Self { convex, pose, radius: [a.radius, b.radius], size, sliding })
    }

    fn support(&self, direction: Vec3) -> Vec3 {
        self.pose.point(self.convex.support(self.pose.local_direction(direction)))
    }

    /// Returns the closest points of a set and of B moved by `shift`; `None` where they touch.
    fn nearby(&self, set: &Set<impl Fn(Vec3) -> Vec3>, shift: Vec3) -> Option<Nearby> {
        let start = self.pose.point(self.convex.center()) + shift - set.center;
        let c = gjk::distance(&set.support, |d| self.support(d) + shift, start)?;
        let [radius_a, radius_b] = self.radius;
        Some(Nearby {
            distance: c.distance - (radius_a + radius_b),
            point_a: c.point_a + c.normal * radius_a,
            point_b: c.point_b - c.normal * radius_b,
            normal: c.normal,
        })
    }

    /// Returns the closest points of two that touch, or overlap by no more than a rounding: moves B
    /// out and back again.
    fn touching(&self, set: &Set<impl Fn(Vec3) -> Vec3>) -> Nearby {
        let center = self.pose.point(self.convex.center());
        let normal = (center - set.center).normalize_or(Vec3::Y);
        let mut near = Nearby { distance: 0.0, point_a: center, point_b: center, normal };
        for _ in 0..2 {
            let shift = near.normal * self.apart(set);
            let Some(moved) = self.nearby(set, shift) else { break };
            let distance = lesser(moved.distance - moved.normal.dot(shift), 0.0);
            near = Nearby { distance, point_b: moved.point_b - shift, ..moved };
        }
        near
    }

    /// Shift that moves the two apart where their closest points are too near to give a normal [m].
    fn apart(&self, set: &Set<impl Fn(Vec3) -> Vec3>) -> f32 {
        APART * if set.size > 0.0 { lesser(self.size, set.size) } else { self.size }
    }

    /// Maximum distance that counts as a hit [m]. `other` is the size and distance from the origin
    /// of the other one [m].
    fn met(&self, other: f32) -> f32 {
        MET * (self.size + other)
    }

    /// Closest points of B and a half-space.
    fn above(&self, normal: Vec3, offset: f32) -> Nearby {
        let point_b = self.support(-normal) - normal * self.radius[1];
        let distance = normal.dot(point_b) - offset;
        Nearby { distance, point_a: point_b - normal * distance, point_b, normal }
    }

    /// Closest points of B and the plane of a triangle, seen from B's side.
    fn above_triangle(&self, face: Vec3, corner: Vec3) -> Nearby {
        let side = face.dot(self.pose.point(self.convex.center()) - corner);
        let normal = if side < 0.0 { -face } else { face };
        self.above(normal, normal.dot(corner))
    }

    /// First hit of B on a half-space.
    fn fall(&self, normal: Vec3, offset: f32, delta: Vec3, limit: f32) -> Option<Meeting> {
        let start = self.above(normal, offset);
        let met = self.met(offset.abs());
        if start.distance <= met {
            return start.meets_at_once(delta, met).then(|| Meeting::at_start(&start, met));
        }
        let clear = start.distance + normal.dot(self.sliding.shift(met));
        let fraction = clear / -normal.dot(delta);
        let point = start.point_b + delta * fraction;
        let meeting = Meeting { fraction, point, normal, overlap: false };
        (fraction >= 0.0 && fraction <= limit).then_some(meeting)
    }

    /// First hit of B on a convex set. `touch` returns the contact at the start, if they touch or
    /// overlap there.
    fn advance(
        &self,
        set: &Set<impl Fn(Vec3) -> Vec3>,
        delta: Vec3,
        limit: f32,
        touch: impl Fn() -> Option<Nearby>,
    ) -> Option<Meeting> {
        let met = self.met(set.size + set.center.length());
        let off = self.sliding.shift(met);
        let (mut fraction, mut normal) = (0.0, Vec3::ZERO);
        for _ in 0..MAX_STEPS {
            let near = self.nearby(set, delta * fraction + off);
            let Some(near) = near.filter(|near| near.distance > met) else {
                if fraction > 0.0 {
                    let rest = near.map_or(0.0, |near| near.distance);
                    fraction += rest / -normal.dot(delta);
                    break;
                }
                let deep = touch()?;
                return deep.meets_at_once(delta, met).then(|| Meeting::at_start(&deep, met));
            };
            normal = near.normal;
            let closing = -normal.dot(delta);
            if !(closing > 0.0) {
                return None;
            }
            // Advances to half of the distance that counts as a hit: touching sets have no closest
            // points.
            fraction += (near.distance - 0.5 * met) / closing;
            if !(fraction <= limit) {
                return None;
            }
        }
        let apart = self.apart(set);
        let mut point = set.center;
        for _ in 0..2 {
            let shift = delta * fraction + off + normal * apart;
            let Some(near) = self.nearby(set, shift) else { break };
            (point, normal) = (near.point_a, near.normal);
        }
        Some(Meeting { fraction, point, normal, overlap: false })
    }
}

/// Returns the corner of a triangle farthest along a direction.
fn farthest(corners: [Vec3; 3], direction: Vec3) -> Vec3 {
    let [a, b, c] = corners.map(|corner| corner.dot(direction));
    corners[if a >= b && a >= c { 0 } else { 1 + usize::from(c > b) }]
}

/// Converts a triangle to a set.
fn flat(corners: [Vec3; 3]) -> Set<impl Fn(Vec3) -> Vec3> {
    let center = (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0);
    let size = greater((corners[1] - corners[0]).length(), (corners[2] - corners[0]).length());
    Set { support: move |d| farthest(corners, d), center, size }
}

/// Returns the closest points of B and the nearest triangle within `reach`; at equal distances the
/// lower number wins.
fn closest_triangle(mesh: &Mesh, b: &Placed<'_>, solid: &Solid, reach: f32) -> Option<Nearby> {
    let around = solid.aabb(b.pose);
    // The search widens step by step, so that a near triangle is found among few.
    let mut look = lesser(reach, around.half_extents().max_element());
    loop {
        let mut best: Option<(u32, Nearby)> = None;
        mesh.tree().query(&around.grown(look), &mut |item| {
            let pack = mesh.pack(item);
            for (lane, &number) in pack.numbers().iter().enumerate() {
                let corners = pack.triangle(lane);
                let limit = best.map_or(look, |(_, near)| near.distance);
                if !around.grown(limit).overlaps(&Aabb::of_points(corners)) {
                    continue;
                }
                let set = flat(corners);
                let near = b.nearby(&set, Vec3::ZERO).unwrap_or_else(|| b.touching(&set));
                if best.is_none_or(|(n, b)| (near.distance, number) < (b.distance, n)) {
                    best = Some((number, near));
                }
            }
        });
        match best {
            Some((_, near)) if near.distance <= look => return Some(near),
            _ if look >= reach => return None,
            _ => look = lesser(4.0 * look + MET * b.size, reach),
        }
    }
}

/// Returns the first triangle that B hits while it moves by `delta` inside the box `around`, which
/// moves with it. `meet` returns the hit on a triangle (a lane of a pack) up to a fraction of the
/// motion.
fn first_triangle(
    mesh: &Mesh,
    around: &Aabb,
    delta: Vec3,
    limit: f32,
    mut meet: impl FnMut(&Pack, usize, f32) -> Option<Meeting>,
) -> Option<Meeting> {
    let mut best: Option<(u32, Meeting)> = None;
    mesh.tree().ray(&Ray::of_box(around, delta), limit, |item| {
        let pack = mesh.pack(item);
        for (lane, &number) in pack.numbers().iter().enumerate() {
            let limit = best.map_or(limit, |(_, meeting)| meeting.fraction);
            let end = Aabb::new(around.min + delta * limit, around.max + delta * limit);
            if !around.union(&end).overlaps(&Aabb::of_points(pack.triangle(lane))) {
                continue;
            }
            // At equal fractions the lowest number wins.
            if let Some(met) = meet(pack, lane, limit)
                && best.is_none_or(|(n, m)| (met.fraction, number) < (m.fraction, n))
            {
                best = Some((number, met));
            }
        }
        best.map_or(limit, |(_, meeting)| meeting.fraction)
    });
    best.map(|(_, meeting)| meeting)
}

fn meet_triangle(
    mesh: &Mesh,
    b: &Placed<'_>,
    solid: &Solid,
    delta: Vec3,
    limit: f32,
) -> Option<Meeting> {
    let around = solid.aabb(b.pose).grown(MET * b.size);
    first_triangle(mesh, &around, delta, limit, |pack, lane, limit| {
        let corners = pack.triangle(lane);
        let touch = || Some(b.above_triangle(pack.normal(lane), corners[0]));
        b.advance(&flat(corners), delta, limit, touch)
    })
}

#[cfg(test)]
mod tests {
    use super::{Course, Sliding, closest, meet};
    use crate::base::math::{Vec3, vec3};
    use crate::base::pose::Pose;
    use crate::base::quat::Quat;
    use crate::geometry::hull::Hull;
    use crate::geometry::mesh::Mesh;
    use crate::geometry::oracle::{Numbers, grid, parry};
    use crate::geometry::shape::Shape;
    use crate::geometry::solid::Solid;
    use parry3d::query;
    use parry3d::shape;
    use std::sync::Arc;

    /// Pairs of our shapes and parry's.
    fn shapes(numbers: &mut Numbers) -> Vec<(Shape, Box<dyn shape::Shape>)> {
        let half = vec3(0.7, 0.4, 1.1);
        let points: Vec<Vec3> = (0..24).map(|_| numbers.point()).collect();
        let hull = Hull::from_points(&points).unwrap();
        let theirs: Vec<_> = hull.vertices().iter().map(|v| parry(*v)).collect();
        let theirs = shape::ConvexPolyhedron::from_convex_hull(&theirs).unwrap();
        vec![
            (Shape::sphere(0.6), Box::new(shape::Ball::new(0.6))),
            (Shape::capsule(0.5, 0.3), Box::new(shape::Capsule::new_y(0.5, 0.3))),
            (Shape::box_half(half), Box::new(shape::Cuboid::new(parry(half)))),
            (Shape::cylinder(0.5, 0.6), Box::new(shape::Cylinder::new(0.5, 0.6))),
            (Shape::cone(0.6, 0.7), Box::new(shape::Cone::new(0.6, 0.7))),
            (Shape::Hull(Arc::new(hull)), Box::new(theirs)),
        ]
    }

    fn rotation(numbers: &mut Numbers) -> Quat {
        let axis = numbers.point().normalize_or(Vec3::X);
        Quat::from_axis_angle(axis, 3.0 * numbers.next())
    }

    /// Height of the lowest point of a solid along a normal.
    fn height(b: &Solid, pose: &Pose, normal: Vec3) -> f32 {
        let convex = super::Convex::of(&b.core).unwrap();
        let lowest = pose.point(convex.support(pose.local_direction(-normal)));
        normal.dot(lowest) - b.radius
    }

    #[test]
    fn convex_shapes_are_as_far_apart_as_their_closest_points() {
        let mut numbers = Numbers(11);
        let all = shapes(&mut numbers);
        for (a, theirs_a) in &all {
            for (b, theirs_b) in &all {
                let (solid_a, solid_b) = (Solid::of(a), Solid::of(b));
                for _ in 0..60 {
                    let pose = Pose::new(numbers.point() * 3.0, rotation(&mut numbers));
                    let q = pose.rotation;
                    let isometry = parry3d::math::Pose::from_parts(
                        parry(pose.position),
                        parry3d::math::Rotation::from_xyzw(q.x, q.y, q.z, q.w),
                    );
                    let identity = parry3d::math::Pose::IDENTITY;
                    let theirs = query::distance(&identity, &**theirs_a, &isometry, &**theirs_b)
                        .unwrap()
                        .distance;
                    let found = closest(&solid_a, &solid_b, &pose, 100.0).unwrap();
                    if theirs <= 0.0 {
                        assert!(found.distance < 1e-4, "{a:?} {b:?} {pose:?}: {found:?}");
                        continue;
                    }
                    // Both points belong to the shapes, and no plane between them gives a larger
                    // distance: it is exact. (parry's distance of capsules side by side is off by 2
                    // mm.)
                    let lowest = height(&solid_b, &pose, found.normal);
                    let highest = -height(&solid_a, &Pose::IDENTITY, -found.normal);
                    let off = (found.distance - (lowest - highest)).abs();
                    assert!(off < 1e-5, "{a:?} {b:?} {pose:?}: {found:?} {off}");
                    assert!(found.distance < theirs + 1e-5);
                    let between = found.point_b - found.point_a;
                    assert!((between - found.normal * found.distance).length() < 1e-5);
                    assert!(closest(&solid_a, &solid_b, &pose, 0.9 * theirs).is_none());
                }
            }
        }
    }

    #[test]
    fn what_moves_meets_at_the_place_where_the_distance_is_gone() {
        let mut numbers = Numbers(5);
        let mut all: Vec<Solid> =
            shapes(&mut numbers).iter().map(|(shape, _)| Solid::of(shape)).collect();
        let convex = all.clone();
        let (vertices, triangles) = grid();
        all.push(Solid::of(&Shape::Mesh(Arc::new(Mesh::new(vertices, triangles).unwrap()))));
        all.push(Solid::of(&Shape::HalfSpace { normal: vec3(0.6, 0.8, 0.0), offset: -1.0 }));
        let (mut met, mut missed) = (0, 0);
        for a in &all {
            for b in &convex {
                for _ in 0..60 {
                    let pose = Pose::new(numbers.point() * 4.0, rotation(&mut numbers));
                    let delta = numbers.point() * 6.0;
                    let at = |t: f32| Pose::new(pose.position + delta * t, pose.rotation);
                    let apart = |t: f32| closest(a, b, &at(t), 100.0).unwrap().distance;
                    let start = apart(0.0);
                    let Some(meeting) =
                        meet(a, b, &pose, &Course::straight(delta), &Sliding::default())
                    else {
                        missed += 1;
                        // They never overlap during the motion, beyond grazing.
                        for k in 0..=40_u8 {
                            let t = f32::from(k) / 40.0;
                            assert!(apart(t) > -1e-3, "{b:?} {pose:?} {delta:?} {t}");
                        }
                        continue;
                    };
                    met += 1;
                    if start < 0.0 {
                        assert!(meeting.fraction <= 0.0);
                        continue;
                    }
                    // A tenth of a millimeter before the hit they are apart, by no more than that
                    // distance.
                    let step = 1e-4 / delta.length();
                    let gap = apart(meeting.fraction - step);
                    let ok = meeting.fraction < step || (gap > 0.0 && gap < 1e-4 + 2e-5);
                    assert!(ok, "{b:?} {pose:?} {delta:?}: {meeting:?} {gap}");
                    // The motion passed through nothing before the hit.
                    for k in 0..20_u8 {
                        let t = (meeting.fraction - step) * f32::from(k) / 20.0;
                        assert!(apart(t) > 0.0, "{b:?} {pose:?} {delta:?} {t}");
                    }
                    assert!((meeting.normal.length() - 1.0).abs() < 1e-5);
                    assert!(meeting.normal.dot(delta) < 1e-5);
                    let rest = height(b, &at(meeting.fraction), meeting.normal);
                    assert!((rest - meeting.normal.dot(meeting.point)).abs() < 1e-3);
                }
            }
        }
        assert!(met > 300 && missed > 300, "{met} {missed}");
    }

    #[test]
    fn what_lies_on_a_face_slides_along_it_and_leaves_it_freely() {
        let floor = Solid::of(&Shape::box_half([5.0, 0.5, 5.0]));
        let cube = Solid::of(&Shape::box_half([0.5; 3]));
        let plane = Solid::of(&Shape::HalfSpace { normal: Vec3::Y, offset: 0.5 });
        for (delta, meets) in [
            (vec3(0.0, 1.0, 0.0), false),
            (vec3(1.0, 0.0, 0.0), false),
            (vec3(1.0, 0.2, 0.0), false),
            (vec3(0.0, -1.0, 0.0), true),
            (vec3(1.0, -0.1, 0.0), true),
        ] {
            for (floor, above) in [(&floor, 2.0e-6), (&plane, 0.0), (&plane, 2.0e-6)] {
                let pose = Pose::at([0.0, 1.0 + above, 0.0]);
                let found =
                    meet(floor, &cube, &pose, &Course::straight(delta), &Sliding::default());
                assert_eq!(found.is_some(), meets, "{delta:?}: {found:?}");
                assert!(
                    found.is_none_or(|m| m.fraction < 1e-4 && m.normal == Vec3::Y),
                    "{found:?}"
                );
            }
        }
    }

    #[test]
    fn numbers_that_are_not_finite_meet_nothing() {
        let ball = Solid::of(&Shape::sphere(1.0));
        for x in [f32::NAN, f32::INFINITY, f32::MAX] {
            let (at, displacement) = (Pose::at([x, 0.0, 0.0]), vec3(1.0, 0.0, 0.0));
            let _ = meet(&ball, &ball, &at, &Course::straight(displacement), &Sliding::default());
            let _ = closest(&ball, &ball, &Pose::at([x, 0.0, 0.0]), 1.0);
        }
    }
}
