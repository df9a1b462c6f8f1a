//! Bodies at rest: the number of points, their spread, and no jumps when poses jitter.

use super::tests::{Random, best, min_separation, touch};
use super::{PairCache, collide};
use crate::base::math::{Vec3, vec3};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::geometry::convex::sat::collide_hulls;
use crate::geometry::hull::{HalfEdge, Hull, Plane};
use crate::geometry::manifold::Manifold;
use crate::geometry::shape::Shape;
use crate::geometry::solid::Solid;

const QUARTER: f32 = core::f32::consts::FRAC_PI_2;

fn lying() -> Quat {
    Quat::from_axis_angle(Vec3::Z, QUARTER)
}

/// Twice the area of the polygon through the points, which `reduce` does not order.
fn spread(m: &Manifold) -> f32 {
    let p = m.points();
    let mut maximum = 0.0_f32;
    for i in 0..p.len() {
        for j in 0..p.len() {
            for k in 0..p.len() {
                let (u, v) = (p[j].position - p[i].position, p[k].position - p[i].position);
                maximum = maximum.max(u.cross(v).length());
            }
        }
    }
    maximum
}

/// Checks count, normal and depth at a pose and at poses close to it.
fn rests(a: &Shape, b: &Shape, at: &Pose, counts: &[usize], depth: f32) {
    let mut random = Random(9);
    for k in 0..200 {
        let tremble = if k == 0 { 0.0 } else { 1.0e-5 };
        let pose = Pose::new(
            at.position + random.vector() * tremble,
            at.rotation.turned_by(random.vector() * tremble),
        );
        let m = touch(a, b, &pose, 0.02);
        assert!(counts.contains(&m.count), "{a:?} {b:?} {pose:?} {m:?}");
        assert!((m.normal - Vec3::Y).length() < 1.0e-4, "{a:?} {b:?} {m:?}");
        for p in m.points() {
            assert!((p.separation + depth).abs() < 1.0e-4, "{a:?} {b:?} {m:?}");
        }
    }
}

fn grounds() -> Vec<(Shape, f32)> {
    vec![
        (Shape::half_space([0.0, 1.0, 0.0], 0.5), 0.5),
        (Shape::box_half([5.0, 0.5, 5.0]), 0.5),
        (Shape::cylinder(0.5, 3.0), 0.5),
    ]
}

#[test]
fn solids_at_rest_keep_their_points() {
    for (ground, top) in grounds() {
        for depth in [0.005, 0.0, -0.001] {
            let at = |height: f32, q: Quat| Pose::new([0.1, top + height - depth, 0.2], q);
            let rest = |shape: &Shape, height: f32, q: Quat, counts: &[usize]| {
                rests(&ground, shape, &at(height, q), counts, depth);
            };
            rest(&Shape::sphere(0.3), 0.3, Quat::IDENTITY, &[1]);
            rest(&Shape::capsule(0.5, 0.3), 0.3, lying(), &[2]);
            rest(&Shape::capsule(0.5, 0.3), 0.8, Quat::IDENTITY, &[1]);
            rest(&Shape::box_half([0.3, 0.4, 0.5]), 0.4, Quat::IDENTITY, &[4]);
            rest(&Shape::cylinder(0.4, 0.5), 0.4, Quat::IDENTITY, &[4]);
            rest(&Shape::cylinder(0.4, 0.5), 0.5, lying(), &[2]);
            rest(&Shape::cone(0.6, 0.5), 0.6, Quat::IDENTITY, &[4]);
            // Slant: the angle of the side with the axis is atan(0.5 / 1.2).
            let tilt = crate::base::trig::atan2(0.5, 1.2);
            let on_side = Quat::from_axis_angle(Vec3::Z, -QUARTER - tilt);
            let height = 0.6 * crate::base::trig::sin_cos(tilt).0;
            rest(&Shape::cone(0.6, 0.5), height, on_side, &[2]);
        }
    }
}

#[test]
fn small_and_large_solids_rest_alike() {
    for scale in [0.05, 20.0, 100.0] {
        let ground = Shape::box_half([3.0 * scale, 0.5 * scale, 3.0 * scale]);
        let cylinder = Shape::cylinder(0.4 * scale, 0.5 * scale);
        for (shape, height, q, count) in [
            (Shape::capsule(0.5 * scale, 0.3 * scale), 0.3, lying(), 2),
            (cylinder.clone(), 0.4, Quat::IDENTITY, 4),
            (cylinder, 0.5, lying(), 2),
            (Shape::cone(0.6 * scale, 0.5 * scale), 0.6, Quat::IDENTITY, 4),
        ] {
            for depth in [0.005, 0.0, -0.001] {
                let pose = Pose::new(vec3(0.1, 0.5 + height - depth, 0.2) * scale, q);
                let m = touch(&ground, &shape, &pose, 0.02 * scale);
                assert_eq!(m.count, count, "{scale} {shape:?} {m:?}");
                // The rotation of the pose rounds; the normal is exact otherwise.
                assert!((m.normal - Vec3::Y).length() < 1.0e-6, "{scale} {shape:?} {m:?}");
                for p in m.points() {
                    assert!((p.separation + depth * scale).abs() < 1.0e-5 * scale, "{m:?}");
                }
            }
        }
    }
}

#[test]
fn small_solids_rest_far_out_on_a_wide_ground() {
    let ground = Shape::box_half([200.0, 1.0, 200.0]);
    let mut random = Random(6);
    for (shape, height, q, count) in [
        (Shape::box_half([0.1, 0.1, 0.1]), 0.1, Quat::IDENTITY, 4),
        (Shape::capsule(0.2, 0.1), 0.1, lying(), 2),
        (Shape::cylinder(0.1, 0.1), 0.1, Quat::IDENTITY, 4),
        (Shape::cylinder(0.2, 0.1), 0.1, lying(), 2),
    ] {
        for _ in 0..200 {
            let (x, z) = (150.0 * random.signed(), 150.0 * random.signed());
            let pose = Pose::new([x, 1.0 + height - 0.001, z], q);
            let m = touch(&ground, &shape, &pose, 0.02);
            assert_eq!(m.count, count, "{shape:?} {pose:?} {m:?}");
            assert!((m.normal - Vec3::Y).length() < 1.0e-6, "{shape:?} {pose:?} {m:?}");
            for p in m.points() {
                assert!((p.separation + 0.001).abs() < 5.0e-5, "{shape:?} {pose:?} {m:?}");
            }
        }
    }
}

#[test]
fn standing_bodies_have_widely_spread_points() {
    for (ground, top) in grounds() {
        for (shape, height, area) in [
            (Shape::box_half([0.3, 0.4, 0.5]), 0.4, 0.6),
            (Shape::cylinder(0.4, 0.5), 0.4, 0.5),
            (Shape::cone(0.6, 0.5), 0.6, 0.5),
        ] {
            let m = touch(&ground, &shape, &Pose::at([0.1, top + height - 0.001, 0.2]), 0.02);
            assert_eq!(m.count, 4);
            assert!(spread(&m) > area * 0.9, "{ground:?} {shape:?} {m:?}");
        }
    }
}

#[test]
fn equal_cylinders_stack_with_four_points() {
    let c = Shape::cylinder(0.4, 0.5);
    for turn in [0.0, 0.1, 0.3] {
        let pose = Pose::new([0.0, 0.799, 0.0], Quat::from_axis_angle(Vec3::Y, turn));
        rests(&c, &c, &pose, &[4], 0.001);
    }
}

#[test]
fn parallel_lying_cylinders_touch_along_a_line() {
    let c = Shape::cylinder(0.4, 0.5);
    let m = touch(&c, &c, &Pose::at([0.6, 0.1, 0.797]), 0.02);
    assert_eq!(m.count, 2, "{m:?}");
    let n = vec3(0.6, 0.0, 0.797).normalize_or(Vec3::X);
    assert!((m.normal - n).length() < 1.0e-3, "{m:?} {n:?}");
    let exact = (0.36_f32 + 0.797 * 0.797).sqrt() - 1.0;
    assert!((min_separation(&m) - exact).abs() < 1.0e-4);
}

#[test]
fn a_rolling_cylinder_keeps_its_line_exactly() {
    let (ground, top) = (Shape::box_half([5.0, 0.5, 5.0]), 0.5);
    let c = Shape::cylinder(0.4, 0.5);
    for k in 0..400_u16 {
        let turn = f32::from(k) * 0.01;
        let q =
            Quat::from_axis_angle(Vec3::Y, 0.3) * lying() * Quat::from_axis_angle(Vec3::Y, turn);
        let m = touch(&ground, &c, &Pose::new([0.1, top + 0.499, 0.0], q), 0.02);
        assert_eq!((m.count, m.normal), (2, Vec3::Y), "{m:?}");
        for p in m.points() {
            assert!((p.separation + 0.001).abs() < 1.0e-5, "{m:?}");
        }
        let line = m.points[1].position - m.points[0].position;
        assert!((line.length() - 0.8).abs() < 1.0e-3, "{m:?}");
    }
}

#[test]
fn a_box_at_rest_keeps_its_feature_ids() {
    let (a, b) = (Shape::box_half([0.5, 0.5, 0.5]), Shape::box_half([0.5, 0.5, 0.5]));
    let (a, b) = (Solid::of(&a), Solid::of(&b));
    let mut random = Random(4);
    let mut cache = PairCache::default();
    let ids = |m: &Manifold| m.points().iter().map(|p| p.feature).collect::<Vec<_>>();
    let first = collide(best(), &a, &b, &Pose::at([0.0, 0.999, 0.0]), 0.02, &mut cache);
    assert_eq!(first.count, 4);
    for _ in 0..300 {
        let pose = Pose::new(
            vec3(0.0, 0.999, 0.0) + random.vector() * 5.0e-5,
            Quat::from_rotation_vector(random.vector() * 5.0e-5),
        );
        let m = collide(best(), &a, &b, &pose, 0.02, &mut cache);
        assert_eq!(ids(&m), ids(&first), "{m:?}");
    }
}

#[test]
fn crossed_box_edges_touch_in_one_point() {
    let a = Shape::box_half([0.5, 0.5, 0.5]);
    let q = Quat::from_axis_angle(Vec3::Y, QUARTER) * Quat::from_axis_angle(Vec3::X, QUARTER / 2.0);
    let roll = Quat::from_axis_angle(Vec3::X, QUARTER / 2.0);
    let half = 0.5 * 2.0_f32.sqrt();
    // In the frame of A its upper edge along x points to +y +z.
    let up = vec3(0.0, 1.0, 1.0) * 0.5_f32.sqrt();
    let pose = Pose::new(up * (2.0 * half - 0.001), roll * q);
    let m = touch(&a, &a, &pose, 0.02);
    assert_eq!(m.count, 1, "{m:?}");
    assert!((m.normal - up).length() < 1.0e-4, "{m:?}");
    assert!((min_separation(&m) + 0.001).abs() < 1.0e-5, "{m:?}");
}

#[test]
fn a_triangle_is_a_polytope_of_two_faces() {
    let vertices = [vec3(-2.0, 0.0, -2.0), vec3(0.0, 0.0, 3.0), vec3(2.0, 0.0, -2.0)];
    let planes = [Plane { normal: Vec3::Y, offset: 0.0 }, Plane { normal: -Vec3::Y, offset: 0.0 }];
    // Face 0 has the corners 0 1 2, face 1 in reverse order.
    let edge = |origin, face, next| HalfEdge { origin, face, next };
    let edges =
        [edge(0, 0, 2), edge(1, 1, 5), edge(1, 0, 4), edge(2, 1, 1), edge(2, 0, 0), edge(0, 1, 3)];
    let triangle = Hull::from_parts(vertices.into(), planes.into(), vec![0, 1], edges.into());
    let triangle = &triangle;
    let cube = Shape::box_half([0.25, 0.25, 0.25]);
    let Shape::Box { half_extents } = cube else { return };
    let hull = Hull::cuboid(half_extents);
    let mut random = Random(8);
    for _ in 0..200 {
        let turn = Quat::from_axis_angle(Vec3::Y, random.signed());
        let pose = Pose::new([0.2 * random.signed(), 0.24, 0.2 * random.signed()], turn);
        let m = collide_hulls(best(), triangle, &hull, &pose, 0.02, &mut PairCache::default());
        assert_eq!((m.count, m.normal), (4, Vec3::Y), "{m:?}");
        assert!((min_separation(&m) + 0.01).abs() < 1.0e-5);
        let w = collide_hulls(
            best(),
            &hull,
            triangle,
            &pose.inverse(),
            0.02,
            &mut PairCache::default(),
        );
        assert_eq!(w.count, 4);
        // Beside the triangle there is no contact.
        let beside = Pose::new([4.0, 0.0, 0.0], turn);
        let none = collide_hulls(best(), triangle, &hull, &beside, 0.02, &mut PairCache::default());
        assert_eq!(none.count, 0);
    }
    // A corner of the box against an edge of the triangle, in its plane.
    let turn = Quat::from_axis_angle(Vec3::Y, QUARTER / 2.0);
    let pose = Pose::new([0.0, 0.0, -2.0 - 0.25 * 2.0_f32.sqrt() + 0.01], turn);
    let m = collide_hulls(best(), triangle, &hull, &pose, 0.02, &mut PairCache::default());
    assert!(m.count > 0 && (m.normal + Vec3::Z).length() < 1.0e-3, "{m:?}");
}

#[test]
fn capsules_side_by_side_have_two_points_and_crossed_ones_one() {
    let c = Shape::capsule(0.5, 0.2);
    let m = touch(&c, &c, &Pose::at([0.39, 0.2, 0.0]), 0.02);
    assert_eq!((m.count, m.normal), (2, Vec3::X));
    for p in m.points() {
        assert!((p.separation + 0.01).abs() < 1.0e-6 && (p.position.x - 0.195).abs() < 1.0e-6);
    }
    let m = touch(&c, &c, &Pose::new([0.39, 0.2, 0.0], Quat::from_axis_angle(Vec3::X, 1.0)), 0.02);
    assert_eq!(m.count, 1);
    let m = touch(&c, &c, &Pose::at([0.0, 1.39, 0.0]), 0.02);
    assert_eq!((m.count, m.normal), (1, Vec3::Y));
}

/// Run with `cargo test --release -p drystone -- --ignored --nocapture time_of`.
#[test]
#[ignore = "a measurement"]
fn time_of_pairs() {
    let boxes = [Shape::box_half([0.5, 0.3, 0.8]), Shape::box_half([0.5, 0.5, 0.5])];
    let measure = |what: &str, a: &Shape, b: &Shape, reach: f32, keep: bool| {
        let (a, b) = (Solid::of(a), Solid::of(b));
        let mut random = Random(2);
        let poses: Vec<Pose> =
            (0..256).map(|_| Pose::new(random.direction() * reach, random.rotation())).collect();
        let mut caches = vec![PairCache::default(); poses.len()];
        let mut points = 0;
        let begin = std::time::Instant::now();
        for _ in 0..200 {
            for (pose, cache) in poses.iter().zip(&mut caches) {
                if !keep {
                    *cache = PairCache::default();
                }
                points += collide(best(), &a, &b, pose, 0.02, cache).count;
            }
        }
        let ns = begin.elapsed().as_secs_f64() * 1.0e9 / (200.0 * poses.len() as f64);
        println!("{what}: {ns:.0} ns, {:.2} points", points as f64 / (200.0 * poses.len() as f64));
    };
    measure("box-box fresh, deep", &boxes[0], &boxes[1], 0.8, false);
    measure("box-box fresh, near", &boxes[0], &boxes[1], 1.2, false);
    measure("box-box fresh, apart", &boxes[0], &boxes[1], 1.8, false);
    measure("box-box cached, apart", &boxes[0], &boxes[1], 1.8, true);
    let ground = Shape::box_half([5.0, 1.0, 5.0]);
    for (what, shape, height) in [
        ("sphere", Shape::sphere(0.5), 0.5),
        ("capsule", Shape::capsule(0.5, 0.5), 1.0),
        ("box", boxes[1].clone(), 0.5),
        ("cylinder", Shape::cylinder(0.5, 0.5), 0.5),
        ("cone", Shape::cone(0.5, 0.5), 0.5),
    ] {
        for depth in [-0.002, 0.002] {
            let pose = Pose::at([0.3, 1.0 + height - depth, 0.1]);
            let (a, b) = (Solid::of(&ground), Solid::of(&shape));
            let begin = std::time::Instant::now();
            let mut points = 0;
            for _ in 0..50_000 {
                points = std::hint::black_box(collide(
                    best(),
                    &a,
                    &b,
                    std::hint::black_box(&pose),
                    0.02,
                    &mut PairCache::default(),
                ))
                .count;
            }
            let ns = begin.elapsed().as_secs_f64() * 1.0e9 / 50_000.0;
            println!("box ground, {what} at depth {depth}: {ns:.0} ns, {points} points");
        }
    }
}
