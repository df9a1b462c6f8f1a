//! How far a convex solid is from another solid, and how far it can go before the two meet.
//!
//! The way by conservative advancement: a plane between the two at their closest points stays between them until
//! the one that moves has crossed their distance along its normal, so it may go on by so much
//! [Mirtich96]. The normals turn towards that of the contact, and the steps become smaller as fast as the gap does.

mod turning;

use super::boxes::Ray;
use super::collide::convex::Convex;
use super::collide::{MAX_PARTS, MeshScratch, Reach, collide, collide_mesh};
use super::gjk;
use super::manifold::{Manifold, ManifoldPoint, PairCache};
use super::mesh::{Mesh, Pack};
use super::solid::{Core, Solid};
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater, lesser};
use crate::base::pose::Pose;
use crate::base::wide::SimdLevel;

/// Where A and B are nearest to each other, in the frame of A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearby {
    /// [m]; below 0: they overlap by so much along the normal.
    pub(crate) distance: f32,
    pub(crate) point_a: Vec3,
    pub(crate) point_b: Vec3,
    /// Unit, from A to B.
    pub(crate) normal: Vec3,
}

/// Where B comes to meet A, in the frame of A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meeting {
    /// Part of the way, 0 to 1; 0 where they overlap at the start.
    pub(crate) fraction: f32,
    pub(crate) point: Vec3,
    /// Unit, from A to B.
    pub(crate) normal: Vec3,
    /// They overlap at the start by more than some roundings.
    pub(crate) overlap: bool,
}

/// Steps of an advancement: 3 to 10 for polytopes, 30 for what round bodies graze. What takes longer counts as
/// met where it has come to, a little before it is.
const ROUNDS: usize = 64;

/// Two that are so near, as a part of their sizes and places, have met: some roundings of f32.
const MET: f32 = 2.0e-6;

/// A way that leaves a surface by no more than this angle [rad] against it goes along it: some roundings of a direction.
pub(crate) const ALONG: f32 = 1.0e-6;

/// What slides along a surface is kept off it by so many times what counts as met, so that nothing that is flush with
/// the surface is: a seam would stop it otherwise.
const CLEAR: f32 = 4.0;

/// Closest points so near tell no normal: for it the two are moved apart by this part of the size of the smaller one.
const APART: f32 = 0.01;

/// The closest points of A and the convex B, unless they are farther apart than `reach` [m].
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

/// How B moves against A, evenly, up to a part of it [frame of A].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Course {
    /// How far the origin of its frame moves [m].
    pub(crate) delta: Vec3,
    /// How far it turns about that origin, as a rotation vector [rad].
    pub(crate) turn: Vec3,
    /// The part of the whole way that is looked at, 0 to 1.
    pub(crate) limit: f32,
}

impl Course {
    /// All of a way without a turn [m].
    pub(crate) const fn straight(delta: Vec3) -> Self {
        Self { delta, turn: Vec3::ZERO, limit: 1.0 }
    }
}

/// What B touches and slides along.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sliding {
    /// Off all of it: at least 1 along each of the normals. Zero: it touches nothing.
    pub(crate) off: Vec3,
    /// By so much what is flush may yet stand out, as places are rounded [m].
    pub(crate) least: f32,
}

impl Sliding {
    /// How far B is kept off what is met up to `met` [m].
    fn shift(&self, met: f32) -> Vec3 {
        self.off * greater(CLEAR * met, self.least)
    }
}

/// Tells the normals, from A to B, along which the two touch within `slack` [m] or some roundings.
pub(crate) fn touched(a: &Solid, b: &Solid, b_in_a: &Pose, slack: f32, mut tell: impl FnMut(Vec3)) {
    let (made, margin) = manifolds(a, b, b_in_a, slack);
    for m in &made {
        let deepest = m.points().iter().map(|p| p.separation).fold(f32::INFINITY, lesser);
        if deepest.abs() <= margin {
            tell(m.normal);
        }
    }
}

/// Where the convex B first meets A on its course.
pub(crate) fn meet(
    a: &Solid,
    b: &Solid,
    b_in_a: &Pose,
    course: &Course,
    sliding: &Sliding,
) -> Option<Meeting> {
    let placed = Placed { sliding: *sliding, ..Placed::new(a, b, b_in_a)? };
    let Course { delta, limit, .. } = *course;
    // A ball that turns stays as it is.
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
    // What a triangle says of an overlap is that of its plane alone; all of them together say more.
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
    /// True of two that overlap by more than what counts as touching, `met` [m].
    fn overlaps(&self, met: f32) -> bool {
        self.distance < -2.0 * met
    }

    /// True of two that touch or overlap, unless they do no more than touch, within `met` [m], and B leaves the surface or goes along it.
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

/// What B comes to: a convex set, without its rounding, around a point in it.
struct Set<F> {
    support: F,
    center: Vec3,
    /// Of the order of its extent [m].
    size: f32,
}

/// A convex core as a set.
fn convex_set<'a>(x: &'a Convex<'_>) -> Set<impl Fn(Vec3) -> Vec3 + 'a> {
    Set { support: |d| x.support(d), center: x.center(), size: x.size() }
}

/// The contacts of two that touch or overlap, and how far apart they may be to touch: `slack` [m] and some roundings.
fn manifolds(a: &Solid, b: &Solid, b_in_a: &Pose, slack: f32) -> ([Manifold; MAX_PARTS], f32) {
    let mut made = [Manifold::default(); MAX_PARTS];
    // What touches may be apart by a rounding.
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

/// The deepest contact of two that touch or overlap.
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
    /// Of both.
    radius: [f32; 2],
    /// Of B, and how far it is from the origin [m].
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

    /// The closest points of a set and of B moved by `shift`; `None` where they touch.
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

    /// That of two that touch, or overlap by no more than a rounding: B is moved out, and back again.
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

    /// How far the two are moved apart where their closest points are too near to tell a normal [m].
    fn apart(&self, set: &Set<impl Fn(Vec3) -> Vec3>) -> f32 {
        APART * if set.size > 0.0 { lesser(self.size, set.size) } else { self.size }
    }

    /// Two so near have met [m]. `other`: the size and place of the other one [m].
    fn met(&self, other: f32) -> f32 {
        MET * (self.size + other)
    }

    /// Over a half-space.
    fn above(&self, normal: Vec3, offset: f32) -> Nearby {
        let point_b = self.support(-normal) - normal * self.radius[1];
        let distance = normal.dot(point_b) - offset;
        Nearby { distance, point_a: point_b - normal * distance, point_b, normal }
    }

    /// Over the plane of a triangle, seen from the side where B is.
    fn above_triangle(&self, face: Vec3, corner: Vec3) -> Nearby {
        let side = face.dot(self.pose.point(self.convex.center()) - corner);
        let normal = if side < 0.0 { -face } else { face };
        self.above(normal, normal.dot(corner))
    }

    /// Onto a half-space.
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

    /// Onto a convex set. `touch` says how the two touch or overlap at the start, if they do.
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
        for _ in 0..ROUNDS {
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
            // Up to half of the gap that counts as none: what touches has no closest points.
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

/// The corner of a triangle farthest along a direction.
fn farthest(corners: [Vec3; 3], direction: Vec3) -> Vec3 {
    let [a, b, c] = corners.map(|corner| corner.dot(direction));
    corners[if a >= b && a >= c { 0 } else { 1 + usize::from(c > b) }]
}

/// A triangle as a set.
fn flat(corners: [Vec3; 3]) -> Set<impl Fn(Vec3) -> Vec3> {
    let center = (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0);
    let size = greater((corners[1] - corners[0]).length(), (corners[2] - corners[0]).length());
    Set { support: move |d| farthest(corners, d), center, size }
}

/// The closest points of B and the nearest triangle within `reach`, of several at one distance that of lower number.
fn closest_triangle(mesh: &Mesh, b: &Placed<'_>, solid: &Solid, reach: f32) -> Option<Nearby> {
    let around = solid.aabb(b.pose);
    // Wider and wider: what is near is found among few.
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

/// The first triangle that B meets on its way by `delta`, in a box `around` it all the while. `meet` tells of a triangle, a lane
/// of a pack, where it is met within a part of the way.
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
            // Of several at one place the one of the lowest number.
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

    /// Our shapes, and parry's.
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

    /// How high the lowest point of a solid is along a normal.
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
                    // Both points are of the shapes, and no plane is between them that tells more: it is exact. (parry's
                    // capsules side by side are off by 2 mm.)
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
                        // They never overlap on the way, beyond what is grazed.
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
                    // A tenth of a millimeter before they are apart, and by no more than that way.
                    let step = 1e-4 / delta.length();
                    let gap = apart(meeting.fraction - step);
                    let ok = meeting.fraction < step || (gap > 0.0 && gap < 1e-4 + 2e-5);
                    assert!(ok, "{b:?} {pose:?} {delta:?}: {meeting:?} {gap}");
                    // Nothing was passed through on the way there.
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
            let (at, way) = (Pose::at([x, 0.0, 0.0]), vec3(1.0, 0.0, 0.0));
            let _ = meet(&ball, &ball, &at, &Course::straight(way), &Sliding::default());
            let _ = closest(&ball, &ball, &Pose::at([x, 0.0, 0.0]), 1.0);
        }
    }
}
