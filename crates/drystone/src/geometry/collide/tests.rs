//! Every pair of kinds against closed forms, against another engine, and with A and B exchanged.

use std::sync::Arc;

use fearless_simd::Level;
use parry3d::math::{Pose as PeerPose, Rotation as PeerRotation, Vector as PeerVector};
use parry3d::query;
use parry3d::shape::{Ball, Capsule, Cone, ConvexPolyhedron, Cuboid, Cylinder, Shape as PeerShape};

use super::convex::Convex;
use super::{PairCache, collide};
use crate::base::math::{Vec3, vec3};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::base::simd::wide::SimdLevel;
use crate::geometry::hull::Hull;
use crate::geometry::manifold::Manifold;
use crate::geometry::shape::Shape;
use crate::geometry::solid::{Core, Solid};

pub(in crate::geometry) struct Random(pub(in crate::geometry) u64);

impl Random {
    /// A random number from -1 to 1.
    pub(in crate::geometry) fn signed(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / 8_388_608.0 - 1.0
    }

    pub(in crate::geometry) fn vector(&mut self) -> Vec3 {
        vec3(self.signed(), self.signed(), self.signed())
    }

    pub(in crate::geometry) fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector();
            if (0.01..1.0).contains(&v.length_squared()) {
                return v * (1.0 / v.length());
            }
        }
    }

    pub(in crate::geometry) fn rotation(&mut self) -> Quat {
        Quat::from_axis_angle(self.direction(), 3.2 * self.signed())
    }
}

pub(super) fn best() -> Level {
    SimdLevel::best().0
}

pub(super) fn touch(a: &Shape, b: &Shape, b_in_a: &Pose, margin: f32) -> Manifold {
    collide(best(), &Solid::of(a), &Solid::of(b), b_in_a, margin, &mut PairCache::default())
}

pub(super) fn min_separation(m: &Manifold) -> f32 {
    m.points().iter().map(|p| p.separation).fold(f32::INFINITY, f32::min)
}

fn rock() -> Shape {
    let mut random = Random(5);
    let points: Vec<Vec3> =
        (0..20).map(|_| random.direction().mul_each(vec3(0.7, 0.4, 0.5))).collect();
    Shape::Hull(Arc::new(Hull::from_points(&points).unwrap()))
}

pub(super) fn bounded() -> Vec<Shape> {
    vec![
        Shape::sphere(0.5),
        Shape::capsule(0.6, 0.25),
        Shape::box_half([0.5, 0.3, 0.8]),
        rock(),
        Shape::cylinder(0.4, 0.5),
        Shape::cone(0.6, 0.5),
        Shape::Cone { half_height: 0.3, radius_bottom: 0.2, radius_top: 0.6 },
    ]
}

fn peer(shape: &Shape) -> Option<Box<dyn PeerShape>> {
    Some(match shape {
        Shape::Sphere { radius } => Box::new(Ball::new(*radius)),
        Shape::Capsule { half_height, radius } => Box::new(Capsule::new_y(*half_height, *radius)),
        Shape::Box { half_extents: h } => Box::new(Cuboid::new(PeerVector::new(h.x, h.y, h.z))),
        Shape::Cylinder { half_height, radius } => Box::new(Cylinder::new(*half_height, *radius)),
        Shape::Cone { half_height, radius_bottom, radius_top } if *radius_top == 0.0 => {
            Box::new(Cone::new(*half_height, *radius_bottom))
        }
        Shape::Hull(hull) => {
            let points: Vec<PeerVector> =
                hull.vertices().iter().map(|v| PeerVector::new(v.x, v.y, v.z)).collect();
            Box::new(ConvexPolyhedron::from_convex_hull(&points)?)
        }
        _ => return None,
    })
}

fn peer_pose(pose: &Pose) -> PeerPose {
    let [x, y, z, w] = pose.rotation.to_array();
    let p = pose.position;
    PeerPose::from_parts(PeerVector::new(p.x, p.y, p.z), PeerRotation::from_xyzw(x, y, z, w))
}

/// Signed distance of two solids along a direction.
fn along(a: &Shape, b: &Shape, b_in_a: &Pose, n: Vec3) -> f32 {
    let (a, b) = (Solid::of(a), Solid::of(b));
    let (x, y) = (Convex::of(&a.core).unwrap(), Convex::of(&b.core).unwrap());
    let low = b_in_a.point(y.support(b_in_a.local_direction(-n)));
    n.dot(low - x.support(n)) - a.radius - b.radius
}

fn near_pose(random: &mut Random, reach: f32) -> Pose {
    Pose::new(random.direction() * (reach * (0.55 + 0.45 * random.signed())), random.rotation())
}

/// Pairs of shapes in random poses, most of them close.
fn for_random_pairs(rounds: usize, mut check: impl FnMut(&Shape, &Shape, &Pose)) {
    let shapes = bounded();
    let mut random = Random(1);
    for a in &shapes {
        for b in &shapes {
            for _ in 0..rounds {
                let pose = near_pose(&mut random, 1.4);
                check(a, b, &pose);
            }
        }
    }
}

#[test]
fn the_separation_is_that_along_the_normal_and_no_direction_separates_more() {
    let directions: Vec<Vec3> = {
        let mut random = Random(77);
        (0..300).map(|_| random.direction()).collect()
    };
    for_random_pairs(120, |a, b, pose| {
        let m = touch(a, b, pose, 0.02);
        let what = (a.kind(), b.kind(), pose);
        let best = directions.iter().map(|n| along(a, b, pose, *n)).fold(-9.0, f32::max);
        if m.count == 0 {
            let n = touch(a, b, pose, 9.0).normal;
            let proof = along(a, b, pose, n);
            assert!(proof > 0.0199, "missed {what:?} {proof}");
            return;
        }
        assert!((m.normal.length() - 1.0).abs() < 1.0e-5, "{what:?}");
        let s = min_separation(&m);
        let exact = along(a, b, pose, m.normal);
        // In a deep overlap with a hull the deepest corner may be beside the face that pushes it
        // out.
        let lost = if exact < -0.02 { 0.05 } else { 1.0e-3 };
        assert!(s > exact - 1.0e-3 && s < exact + lost, "{what:?} {s} {exact} {m:?}");
        assert!(best < exact + 1.0e-3, "{what:?}: {best} is better than {exact} {m:?}");
    });
}

#[test]
fn separations_agree_with_parry() {
    let (mut compared, mut apart) = (0, 0);
    for_random_pairs(150, |a, b, pose| {
        let (Some(x), Some(y)) = (peer(a), peer(b)) else { return };
        let there = peer_pose(pose);
        let Ok(Some(theirs)) = query::contact(&PeerPose::IDENTITY, &*x, &there, &*y, 0.02) else {
            return;
        };
        let m = touch(a, b, pose, 0.03);
        let what = (a.kind(), b.kind(), pose);
        let between_hulls = |s: &Shape| matches!(s, Shape::Box { .. } | Shape::Hull(_));
        if theirs.dist > 0.0 && between_hulls(a) && between_hulls(b) {
            // The axis between two corners is not among the tested axes of hulls.
            assert!(m.count == 0 || min_separation(&m) < theirs.dist + 1.0e-3, "{what:?}");
            return;
        }
        assert!(m.count > 0, "{what:?} {theirs:?}");
        let s = min_separation(&m);
        // The peer's search for the depth of round bodies sometimes ends early: the reference is
        // the distance that its normal proves.
        let n = theirs.normal1;
        let proven = along(a, b, pose, vec3(n.x, n.y, n.z));
        assert!(s > proven - 1.0e-3, "{what:?} {s} {proven} {theirs:?}");
        apart += usize::from((s - theirs.dist).abs() > 1.0e-3);
        compared += 1;
    });
    assert!(compared > 1000, "{compared}");
    assert!(apart * 200 < compared, "{apart} of {compared}");
}

#[test]
fn a_pair_and_its_exchange_have_the_same_contact() {
    for_random_pairs(60, |a, b, pose| {
        let (m, w) = (touch(a, b, pose, 0.02), touch(b, a, &pose.inverse(), 0.02));
        let what = (a.kind(), b.kind(), pose);
        assert_eq!(m.count == 0, w.count == 0, "{what:?}");
        if m.count == 0 {
            return;
        }
        assert!((min_separation(&m) - min_separation(&w)).abs() < 2.0e-3, "{what:?} {m:?} {w:?}");
        let turned = -pose.direction(w.normal);
        // Two directions may be equally good: then only the depth is the same.
        if turned.dot(m.normal) < 0.999 {
            let both = [along(a, b, pose, m.normal), along(a, b, pose, turned)];
            assert!((both[0] - both[1]).abs() < 2.0e-3, "{what:?} {both:?} {m:?} {w:?}");
        }
    });
}

#[test]
fn half_spaces_touch_where_the_lowest_point_is() {
    let mut random = Random(3);
    let ground = Shape::half_space([0.0, 1.0, 0.0], 0.25);
    for shape in bounded() {
        for _ in 0..300 {
            let mut pose = Pose::new(random.vector() * 1.2, random.rotation());
            pose.position.y += 0.8;
            let lowest = Solid::of(&shape).aabb(&pose).min.y;
            let m = touch(&ground, &shape, &pose, 0.05);
            let w = touch(&shape, &ground, &pose.inverse(), 0.05);
            // The bounding box of a rotated hull is not tight.
            if !matches!(shape, Shape::Hull(_)) {
                assert_eq!(m.count > 0, lowest - 0.25 <= 0.05, "{shape:?} {pose:?}");
            }
            assert_eq!(m.count, w.count);
            if m.count > 0 {
                assert_eq!(m.normal, Vec3::Y);
                assert!((min_separation(&m) - min_separation(&w)).abs() < 1.0e-5);
                assert!((pose.direction(w.normal) + Vec3::Y).length() < 1.0e-5);
                if !matches!(shape, Shape::Hull(_)) {
                    assert!(
                        (min_separation(&m) - (lowest - 0.25)).abs() < 1.0e-4,
                        "{shape:?} {pose:?}"
                    );
                }
            }
        }
    }
    assert_eq!(touch(&ground, &ground, &Pose::IDENTITY, 1.0).count, 0);
}

#[test]
fn any_pose_is_answered_without_panic() {
    let mut shapes = bounded();
    shapes.push(Shape::half_space([0.0, 1.0, 0.0], 0.0));
    let numbers = [0.0, -0.0, 1.0e-30, 1.0e-7, 1.0, 1.0e7, 1.0e30, f32::INFINITY, f32::NAN];
    for a in &shapes {
        for b in &shapes {
            for x in numbers {
                for y in numbers {
                    for q in
                        [Quat::IDENTITY, Quat::new(0.5, 0.5, 0.5, 0.5), Quat::new(x, 0.0, 0.0, 1.0)]
                    {
                        let pose = Pose::new([x, y, x], q);
                        let m = touch(a, b, &pose, 0.1);
                        let tame = x.abs() < 10.0 && y.abs() < 10.0 && q.angle() < 7.0;
                        if tame {
                            assert!(
                                m.normal.is_finite() && min_separation(&m) > -10.0,
                                "{a:?} {b:?} {pose:?}"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn cores_that_are_one_point_get_some_unit_normal() {
    for a in bounded() {
        for b in bounded() {
            let m = touch(&a, &b, &Pose::IDENTITY, 0.0);
            assert!(m.count > 0, "{a:?} {b:?}");
            assert!((m.normal.length() - 1.0).abs() < 1.0e-5, "{a:?} {b:?} {m:?}");
            assert!(m.points().iter().all(|p| p.position.is_finite() && p.separation < 0.0));
        }
    }
}

#[test]
fn the_cache_changes_no_answer() {
    let a = Solid::of(&Shape::box_half([0.5, 0.3, 0.8]));
    let b = Solid::of(&rock());
    let mut random = Random(21);
    let mut cache = PairCache::default();
    for _ in 0..5000 {
        let pose = near_pose(&mut random, 1.6);
        let fresh = collide(best(), &a, &b, &pose, 0.02, &mut PairCache::default());
        let mut again = collide(best(), &a, &b, &pose, 0.02, &mut cache);
        // Another axis proves another gap; both are less than the distance.
        assert!((again.gap > 0.02) == (fresh.gap > 0.02));
        again.gap = fresh.gap;
        assert_eq!(again, fresh);
    }
    for kind in 0..=255 {
        let mut any = PairCache { kind, a: 65_535, b: 60_000 };
        collide(best(), &a, &b, &Pose::IDENTITY, 0.02, &mut any);
    }
}

#[test]
fn what_is_apart_says_how_far() {
    let mut random = Random(33);
    let mut seen = 0;
    for a in bounded().into_iter().chain([Shape::HalfSpace { normal: Vec3::Y, offset: 0.1 }]) {
        for b in bounded() {
            let is_hull = |x: &Shape| matches!(Solid::of(x).core, Core::Hull(_));
            for _ in 0..60 {
                let pose = near_pose(&mut random, 3.0);
                let near = touch(&a, &b, &pose, 0.02);
                if near.count > 0 {
                    continue;
                }
                // The reported gap may be less than the distance: it is along one axis, or from one
                // plane.
                assert!(near.gap > 0.02, "{a:?} {b:?} {pose:?}: {}", near.gap);
                if !(is_hull(&a) && is_hull(&b)) {
                    let far = min_separation(&touch(&a, &b, &pose, 100.0));
                    // A normal that snaps to a flat side may cost a thousandth of the size.
                    assert!(near.gap < far + 1.0e-3, "{a:?} {b:?}: {} {far}", near.gap);
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 1000, "{seen}");
}

#[test]
fn rounded_boxes_touch_by_their_corners_at_the_true_distance() {
    let cube = Arc::new(Hull::cuboid(Vec3::splat(0.5)));
    let solid = Solid { core: Core::Hull(cube), radius: 0.1 };
    // Corner against corner: the cores are sqrt(3) 0.1 = 0.173 apart.
    let pose = Pose::at([1.1, 1.1, 1.1]);
    let m = collide(best(), &solid, &solid, &pose, 0.01, &mut PairCache::default());
    assert_eq!(m.count, 1);
    assert!((min_separation(&m) - (0.03_f32.sqrt() - 0.2)).abs() < 1.0e-5);
    assert!((m.points[0].position - Vec3::splat(0.55)).length() < 1.0e-5);
}
