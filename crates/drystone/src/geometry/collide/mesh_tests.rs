#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "numbers of lattices and of random choices are small"
)]

use std::sync::Arc;

use fearless_simd::Level;

use super::{MeshScratch, Reach, collide_mesh};
use crate::base::math::{Vec3, vec3};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::geometry::collide::MAX_PARTS;
use crate::geometry::hull::Hull;
use crate::geometry::manifold::Manifold;
use crate::geometry::mesh::Mesh;
use crate::geometry::solid::{Core, Solid};

#[path = "mesh_level_tests.rs"]
mod levels;

const MARGIN: f32 = 0.02;

struct Rng(u32);

impl Rng {
    /// A random number, 0 to 1.
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 16_777_216.0
    }

    fn vector(&mut self, size: f32) -> Vec3 {
        vec3(self.next() - 0.5, self.next() - 0.5, self.next() - 0.5) * (2.0 * size)
    }

    fn rotation(&mut self) -> Quat {
        Quat::from_rotation_vector(self.vector(3.0))
    }
}

/// n × n squares of two triangles each over [-half, half]², at the height that `y` returns.
fn grid(n: u32, half: f32, flip: bool, y: impl Fn(f32, f32) -> f32) -> Mesh {
    let at = |i: u32| (i as f32 / n as f32 - 0.5) * 2.0 * half;
    let mut v = Vec::new();
    let mut t = Vec::new();
    for i in 0..=n {
        for k in 0..=n {
            v.push(vec3(at(i), y(at(i), at(k)), at(k)));
        }
    }
    for i in 0..n {
        for k in 0..n {
            let a = i * (n + 1) + k;
            t.push([a, a + 1, a + n + 1]);
            t.push([a + 1, a + n + 2, a + n + 1]);
        }
    }
    if flip {
        for triangle in &mut t {
            triangle.swap(1, 2);
        }
    }
    Mesh::new(v, t).unwrap()
}

fn flat(n: u32, flip: bool) -> Mesh {
    grid(n, 5.0, flip, |_, _| 0.0)
}

fn ball(radius: f32) -> Solid {
    Solid { core: Core::Point, radius }
}

fn capsule(half_height: f32, radius: f32) -> Solid {
    Solid { core: Core::Segment { half_height }, radius }
}

fn cuboid(x: f32, y: f32, z: f32) -> Solid {
    Solid { core: Core::Hull(Arc::new(Hull::cuboid(vec3(x, y, z)))), radius: 0.0 }
}

fn cone(half_height: f32, radius_bottom: f32, radius_top: f32) -> Solid {
    Solid { core: Core::Frustum { half_height, radius_bottom, radius_top }, radius: 0.0 }
}

fn collide(mesh: &Mesh, b: &Solid, pose: &Pose) -> Vec<Manifold> {
    let mut out = [Manifold::default(); MAX_PARTS];
    let n = collide_mesh(
        Level::new(),
        mesh,
        b,
        pose,
        &Reach::still(MARGIN),
        &mut MeshScratch::default(),
        &mut out,
    );
    for m in &out[..n] {
        assert!(m.count >= 1 && (m.normal.length() - 1.0).abs() < 1e-4, "{m:?}");
        assert!(m.points().iter().all(|p| p.position.is_finite() && p.separation <= MARGIN));
    }
    out[..n].to_vec()
}

/// A rotation that lays a solid on its side: its axis along x.
fn lying() -> Quat {
    Quat::from_axis_angle(Vec3::Z, core::f32::consts::FRAC_PI_2)
}

#[test]
fn what_rests_on_a_flat_floor_gets_exactly_its_normal_and_all_its_points() {
    // Solid, rotation, height of the origin above the ground, number of points.
    let cases: [(Solid, Quat, f32, usize); 6] = [
        (ball(0.5), Quat::IDENTITY, 0.5, 1),
        (capsule(0.5, 0.25), lying(), 0.25, 2),
        (capsule(0.5, 0.25), Quat::IDENTITY, 0.75, 1),
        (cuboid(0.7, 0.5, 0.9), Quat::IDENTITY, 0.5, 4),
        (cone(0.6, 0.4, 0.4), Quat::IDENTITY, 0.6, 4),
        (cone(0.6, 0.4, 0.4), lying(), 0.4, 2),
    ];
    for n in [1, 20] {
        for flip in [false, true] {
            let mesh = flat(n, flip);
            for side in [1.0, -1.0] {
                for (solid, rotation, height, count) in &cases {
                    for gap in [-0.01, 0.0, 0.012] {
                        for (x, z, turn) in [(0.0, 0.0, 0.0), (0.1, -0.23, 0.4), (1.137, 0.5, 1.1)]
                        {
                            let rotation = Quat::from_axis_angle(Vec3::Y, turn) * *rotation;
                            let pose = Pose::new(vec3(x, side * (height + gap), z), rotation);
                            let m = collide(&mesh, solid, &pose);
                            assert_eq!(m.len(), 1, "{solid:?} {pose:?} grid {n}: {m:#?}");
                            assert_eq!(m[0].normal, vec3(0.0, side, 0.0), "{solid:?} {pose:?}");
                            assert_eq!(m[0].count, *count, "{solid:?} {pose:?} grid {n} {m:#?}");
                            for p in m[0].points() {
                                assert!((p.separation - gap).abs() < 2e-5, "{p:?} {gap}");
                            }
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_box_across_many_triangles_keeps_its_corners_and_their_features() {
    let solid = cuboid(0.7, 0.5, 0.9);
    let mesh = flat(20, false);
    let mut features = Vec::new();
    for step in 0..60 {
        let rotation = Quat::from_axis_angle(Vec3::Y, 0.3);
        let pose = Pose::new(vec3(-2.0 + 0.06 * step as f32, 0.495, 0.013 * step as f32), rotation);
        let m = collide(&mesh, &solid, &pose);
        assert_eq!((m.len(), m[0].count, m[0].normal), (1, 4, Vec3::Y));
        for corner in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let corner = pose.point(vec3(0.7 * corner.0, -0.5, 0.9 * corner.1));
            let near = |p: Vec3| (p - corner).length() < 0.005;
            assert!(m[0].points().iter().any(|p| near(p.position)), "{step} {m:?}");
        }
        let mut f: Vec<u32> = m[0].points().iter().map(|p| p.feature).collect();
        f.sort_unstable();
        features.push(f);
    }
    assert!(features.windows(2).all(|w| w[0] == w[1]), "{features:?}");
}

#[test]
fn nothing_that_tilts_or_sinks_on_a_flat_grid_ever_gets_another_normal() {
    let mut rng = Rng(7);
    for mesh in [flat(20, false), flat(33, true)] {
        let solids = [
            ball(0.3),
            capsule(0.4, 0.2),
            cuboid(0.3, 0.4, 0.5),
            cone(0.4, 0.3, 0.3),
            cone(0.4, 0.3, 0.0),
        ];
        for solid in &solids {
            for _ in 0..400 {
                let rotation = rng.rotation();
                let at = Pose::new(Vec3::ZERO, rotation);
                let down = -solid.aabb(&at).min.y;
                let depth = rng.next() * 0.1 * down - 0.01;
                let place = rng.vector(3.0);
                let pose = Pose::new(vec3(place.x, down - depth, place.z), rotation);
                let m = collide(&mesh, solid, &pose);
                // The bounding box of a frustum is exact, that of a hull is not.
                let low = match &solid.core {
                    Core::Hull(h) => {
                        h.vertices().iter().map(|v| pose.point(*v).y).fold(9.0, f32::min)
                    }
                    _ => -depth,
                };
                if low > MARGIN - 1e-4 {
                    continue;
                }
                assert_eq!(m.len(), 1, "{solid:?} {pose:?} {m:#?}");
                assert_eq!(m[0].normal, Vec3::Y, "{solid:?} {pose:?} {m:#?}");
                let deepest = m[0].points().iter().map(|p| p.separation).fold(9.0, f32::min);
                assert!((deepest - low).abs() < 2e-4, "{deepest} {low} {solid:?} {pose:?} {m:#?}");
            }
        }
    }
}

/// Slopes downwards on both sides of the z axis.
fn roof(n: u32, slope: f32) -> Mesh {
    grid(n, 2.0, false, |x, _| -x.abs() * slope)
}

#[test]
fn a_solid_on_a_ridge_is_pushed_along_a_normal_between_the_faces() {
    for n in [2, 8] {
        let mesh = roof(n, 1.0);
        for (solid, height) in [
            (ball(0.3), 0.3),
            (capsule(0.3, 0.2), 0.5),
            (cuboid(0.5, 0.3, 0.4), 0.3),
            (cone(0.3, 0.4, 0.4), 0.3),
        ] {
            let pose = Pose::at(vec3(0.02, height - 0.01, 0.1));
            let m = collide(&mesh, &solid, &pose);
            assert!(m[0].normal.y > 0.99, "{solid:?} {m:?}");
            assert!((m[0].points[0].separation + 0.01).abs() < 2e-3, "{solid:?} {m:?}");
            assert!(m[0].points().iter().all(|p| p.position.x.abs() < 0.05), "{solid:?} {m:?}");
        }
        let lying_along = Quat::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2);
        for solid in [capsule(0.5, 0.2), cone(0.5, 0.2, 0.2)] {
            let pose = Pose::new(vec3(0.01, 0.19, 0.1), lying_along);
            let m = collide(&mesh, &solid, &pose);
            assert!(m.len() == 1 && m[0].count == 2 && m[0].normal.y > 0.99, "{solid:?} {m:#?}");
        }
    }
    // A box edge across the ridge, tipped: edge on edge, up.
    let tipped = Quat::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_4);
    let pose = Pose::new(vec3(0.0, 0.3 * 2.0_f32.sqrt() - 0.02, 0.1), tipped);
    let m = collide(&roof(2, 1.0), &cuboid(0.5, 0.3, 0.3), &pose);
    assert!(m.len() == 1 && m[0].count == 1 && m[0].normal.y > 0.999, "{m:#?}");
    assert!((m[0].points[0].separation + 0.02).abs() < 1e-4, "{m:#?}");
}

#[test]
fn a_groove_gives_one_manifold_for_each_of_its_walls() {
    for n in [2, 10] {
        let mesh = grid(n, 2.0, false, |x, _| x.abs());
        let turned = Quat::from_axis_angle(Vec3::Z, core::f32::consts::FRAC_PI_4);
        let s = 2.0_f32.sqrt();
        for (solid, pose, count) in [
            (ball(0.3), Pose::at(vec3(0.0, 0.3 * s - 0.01, 0.1)), 1),
            (capsule(0.3, 0.2), Pose::at(vec3(0.0, 0.3 + 0.2 * s - 0.01, 0.1)), 1),
            (cuboid(0.3, 0.3, 0.4), Pose::new(vec3(0.0, 0.3 * s - 0.01, 0.1), turned), 4),
        ] {
            let m = collide(&mesh, &solid, &pose);
            assert_eq!(m.len(), 2, "{solid:?} {m:#?}");
            for part in &m {
                assert!((part.normal.y - 1.0 / s).abs() < 1e-4, "{solid:?} {m:#?}");
                assert_eq!(part.count, count, "{solid:?} {m:#?}");
            }
            assert!(m[0].normal.x * m[1].normal.x < 0.0);
        }
    }
}

/// A block with the top at y = 0, x from -2 to 0, and a floor at y = -1 before it.
fn step() -> Mesh {
    let v = vec![
        vec3(-2.0, 0.0, -2.0),
        vec3(-2.0, 0.0, 2.0),
        vec3(0.0, 0.0, -2.0),
        vec3(0.0, 0.0, 2.0),
        vec3(0.0, -1.0, -2.0),
        vec3(0.0, -1.0, 2.0),
        vec3(2.0, -1.0, -2.0),
        vec3(2.0, -1.0, 2.0),
    ];
    let quads = [[0, 1, 3, 2], [2, 3, 5, 4], [4, 5, 7, 6]];
    Mesh::new(v, quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect())
        .unwrap()
}

#[test]
fn a_solid_beside_a_step_is_pushed_away_from_it_not_down_or_up() {
    // Its center is below the top of the step, its own top above it.
    for yaw in [0.0, 0.3, 0.785] {
        for solid in [cuboid(0.4, 0.7, 0.4), cone(0.7, 0.4, 0.4), capsule(0.4, 0.3)] {
            let rotation = Quat::from_axis_angle(Vec3::Y, yaw);
            let left = -solid.aabb(&Pose::new(Vec3::ZERO, rotation)).min.x;
            let pose = Pose::new(vec3(left - 0.01, -0.305, 0.2), rotation);
            let m = collide(&step(), &solid, &pose);
            assert!(!m.is_empty(), "{solid:?}");
            for part in &m {
                let wall = part.normal.x > 0.9;
                let floor = part.normal.y > 0.999 && part.points[0].separation.abs() < 0.3;
                assert!(wall || floor, "{yaw} {solid:?} {m:#?}");
                assert!(part.points().iter().all(|p| p.separation > -0.02), "{yaw} {m:#?}");
            }
            assert!(m.iter().any(|p| p.normal.x > 0.9), "{yaw} {solid:?} {m:#?}");
        }
    }
}

/// Like [`step`], in squares of 1 m: half of the triangles of its wall meet the top in a corner
/// only.
fn step_in_squares() -> Mesh {
    let mut v = Vec::new();
    let mut t = Vec::new();
    for z in -3..3 {
        let [z, w] = [z as f32, (z + 1) as f32];
        let line = [(-1.0, 0.0), (0.0, 0.0), (0.0, -1.0), (1.0, -1.0)];
        for ends in line.windows(2) {
            let n = v.len() as u32;
            v.extend([(0, z), (0, w), (1, w), (1, z)].map(|(i, z)| vec3(ends[i].0, ends[i].1, z)));
            t.extend([[n, n + 1, n + 2], [n, n + 2, n + 3]]);
        }
    }
    Mesh::new(v, t).unwrap()
}

#[test]
fn a_box_on_a_ledge_is_not_pushed_by_the_wall_below_it() {
    let mesh = step_in_squares();
    let solid = cuboid(0.35, 0.3, 0.4);
    for yaw in [0.0, 0.1, 0.4, 0.9] {
        for tilt in [-0.03, 0.0, 0.02] {
            let rotation = Quat::from_axis_angle(Vec3::Y, yaw)
                * Quat::from_axis_angle(vec3(0.6, 0.0, 0.8), tilt);
            let Core::Hull(hull) = &solid.core else { unreachable!() };
            let low = hull.vertices().iter().map(|v| rotation.rotate(*v).y).fold(9.0, f32::min);
            for gap in [0.0002, 0.0, -0.002, -0.01] {
                for i in 0..60 {
                    let x = 0.005 * i as f32 - 0.2;
                    for z in [-0.3, -0.1, 0.0, 0.225, 0.5] {
                        let pose = Pose::new(vec3(x, gap - low, z), rotation);
                        for m in collide(&mesh, &solid, &pose) {
                            let deep = m.points[0].separation;
                            assert!(deep > gap - 0.009, "{pose:?} {m:#?}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_box_that_hangs_over_a_ledge_is_not_pulled_in_by_the_wall_below_it() {
    // Its center has just passed the wall's plane, over the ledge; from there the wall is seen from
    // within the ground. Half of the wall's triangles meet the ledge in a corner only.
    let mut v: Vec<Vec3> = Vec::new();
    let mut t = Vec::new();
    let mut add = |corners: [Vec3; 4]| {
        let n = v.len() as u32;
        v.extend(corners);
        t.extend([[n, n + 1, n + 2], [n, n + 2, n + 3]]);
    };
    for x in -2..2 {
        let (x, w) = (x as f32, (x + 1) as f32);
        for (z, y) in [(-2.0, -1.0), (-1.0, -1.0), (0.0, 0.0), (1.0, 0.0)] {
            add([vec3(x, y, z), vec3(x, y, z + 1.0), vec3(w, y, z + 1.0), vec3(w, y, z)]);
        }
        add([vec3(x, -1.0, 0.0), vec3(w, -1.0, 0.0), vec3(w, 0.0, 0.0), vec3(x, 0.0, 0.0)]);
    }
    let mesh = Mesh::new(v, t).unwrap();
    let solid = cuboid(0.33, 0.26, 0.26);
    for tilt in [-1.2e-3, -1.0e-3, -3.0e-4, 0.0, 3.0e-4, 1.0e-3, 1.2e-3] {
        for yaw in [0.0, 0.03, 0.4] {
            for x in [0.1, 0.28, 0.5] {
                for z in [-0.004, 0.004, 0.02] {
                    let rotation =
                        Quat::from_axis_angle(Vec3::X, tilt) * Quat::from_axis_angle(Vec3::Y, yaw);
                    let m = collide(&mesh, &solid, &Pose::new(vec3(x, 0.2602, z), rotation));
                    for part in &m {
                        assert!(part.normal.y > 0.99, "{tilt} {yaw} {x} {z} {m:#?}");
                    }
                    assert!(!m.is_empty());
                }
            }
        }
    }
}

#[test]
fn the_order_of_triangles_and_vertices_only_renames_features() {
    let mesh = grid(6, 2.0, false, |x, z| 0.3 * x * x - 0.2 * z * z);
    let mut triangles = mesh.triangles().to_vec();
    triangles.reverse();
    for t in &mut triangles {
        t.rotate_left(1);
    }
    let other = Mesh::new(mesh.vertices().to_vec(), triangles).unwrap();
    let mut rng = Rng(3);
    for solid in [ball(0.3), cuboid(0.3, 0.2, 0.4), cone(0.3, 0.2, 0.1)] {
        for _ in 0..100 {
            let pose = Pose::new(rng.vector(0.8), rng.rotation());
            let (a, b) = (collide(&mesh, &solid, &pose), collide(&other, &solid, &pose));
            assert_eq!(a.is_empty(), b.is_empty());
            if !a.is_empty() {
                let (p, q) = (a[0].points(), b[0].points());
                let minimum = |p: &[crate::geometry::manifold::ManifoldPoint]| {
                    p.iter().map(|p| p.separation).fold(9.0, f32::min)
                };
                assert!((minimum(p) - minimum(q)).abs() < 1e-4, "{solid:?} {a:#?} {b:#?}");
            }
        }
    }
}

fn terrain(seed: u32) -> Mesh {
    let mut rng = Rng(seed);
    let heights: Vec<f32> = (0..200).map(|_| rng.next() * 0.6).collect();
    grid(8, 2.0, false, |x, z| {
        let (i, k) = (((x + 2.0) * 2.0).round() as usize, ((z + 2.0) * 2.0).round() as usize);
        heights[i * 9 + k]
    })
}

#[test]
fn a_ball_over_rough_ground_is_as_far_as_its_nearest_triangle() {
    use parry3d::query::PointQuery;
    let mut rng = Rng(11);
    let mut touching = 0;
    for seed in 0..10 {
        let mesh = terrain(seed);
        for _ in 0..300 {
            let place = rng.vector(1.7);
            let center = vec3(place.x, rng.next(), place.z);
            let point = parry3d::math::Vector::new(center.x, center.y, center.z);
            let mut nearest = f32::INFINITY;
            for corners in mesh.triangles().iter().map(|t| t.map(|i| mesh.vertices()[i as usize])) {
                let [a, b, c] = corners.map(|v| parry3d::math::Vector::new(v.x, v.y, v.z));
                let triangle = parry3d::shape::Triangle::new(a, b, c);
                nearest = nearest.min(triangle.distance_to_local_point(point, true));
            }
            if !(0.01..0.3).contains(&nearest) {
                continue;
            }
            touching += 1;
            // 5 mm of overlap: the first manifold is the nearest feature of the surface.
            let radius = nearest + 0.005;
            let m = collide(&mesh, &ball(radius), &Pose::at(center));
            assert!(!m.is_empty(), "{center:?} {nearest}");
            let separation = m[0].points[0].separation;
            assert!((separation + 0.005).abs() < 1e-4, "{seed} {center:?} {nearest} {m:#?}");
            assert!(
                collide(&mesh, &ball(nearest - 0.021), &Pose::at(center)).is_empty()
                    || nearest < 0.022
            );
        }
    }
    assert!(touching > 500, "{touching}");
}

#[test]
fn what_overlaps_rough_ground_is_always_held() {
    use parry3d::math::{Pose as Isometry, Vector};
    let mut rng = Rng(5);
    let mut missed = Vec::new();
    let mut touching = 0;
    for seed in 0..6 {
        let mesh = terrain(seed);
        let vertices = mesh.vertices().iter().map(|v| Vector::new(v.x, v.y, v.z)).collect();
        let other = parry3d::shape::TriMesh::new(vertices, mesh.triangles().to_vec()).unwrap();
        for _ in 0..300 {
            let place = rng.vector(1.5);
            let pose = Pose::new(vec3(place.x, 0.4 + 0.6 * rng.next(), place.z), rng.rotation());
            let q = pose.rotation;
            let iso = Isometry::from_parts(
                Vector::new(pose.position.x, pose.position.y, pose.position.z),
                parry3d::math::Rotation::from_xyzw(q.x, q.y, q.z, q.w),
            );
            let shapes: [(Solid, Box<dyn parry3d::shape::Shape>); 3] = [
                (
                    cuboid(0.2, 0.3, 0.25),
                    Box::new(parry3d::shape::Cuboid::new(Vector::new(0.2, 0.3, 0.25))),
                ),
                (capsule(0.2, 0.15), Box::new(parry3d::shape::Capsule::new_y(0.2, 0.15))),
                (cone(0.3, 0.2, 0.2), Box::new(parry3d::shape::Cylinder::new(0.3, 0.2))),
            ];
            for (solid, shape) in &shapes {
                let depth =
                    parry3d::query::contact(&Isometry::IDENTITY, &other, &iso, &**shape, 0.0)
                        .unwrap()
                        .map_or(0.0, |c| -c.dist);
                let m = collide(&mesh, solid, &pose);
                if depth > 0.002 {
                    touching += 1;
                    if m.is_empty() || m[0].points[0].separation > 0.0 {
                        missed.push((seed, format!("{:.9?}", solid.core), pose, depth, m));
                    }
                }
            }
        }
    }
    assert!(touching > 1000, "{touching}");
    // A cylinder whose rim a corner enters is reported as just touching.
    let round = |m: &(u32, String, Pose, f32, Vec<Manifold>)| m.1.starts_with("Frustum");
    assert!(
        missed.len() <= 1 && missed.iter().all(round),
        "{} of {touching}: {missed:?}",
        missed.len()
    );
}

#[test]
fn no_mesh_and_no_pose_makes_it_panic() {
    let mut rng = Rng(99);
    let odd = [0.0, -0.0, f32::NAN, f32::INFINITY, 1.0e7, -1.0e7, 1.0e-7, 1.0e-30, 1.0, 0.5];
    let mut kept = 0;
    for round in 0..1500 {
        let strange = round % 3;
        let n = 3 + (rng.next() * 12.0) as usize;
        let coordinate = |rng: &mut Rng| {
            if rng.next() < 0.1 * strange as f32 {
                odd[(rng.next() * 9.9) as usize]
            } else {
                // A coarse lattice makes equal points, lines and flat folds likely.
                (rng.next() * 4.0).floor() * 0.5
            }
        };
        let v: Vec<Vec3> = (0..n)
            .map(|_| vec3(coordinate(&mut rng), coordinate(&mut rng), coordinate(&mut rng)))
            .collect();
        let index = |rng: &mut Rng| (rng.next() * (n as f32 + 0.01)) as u32;
        let t: Vec<[u32; 3]> =
            (0..20).map(|_| [index(&mut rng), index(&mut rng), index(&mut rng)]).collect();
        let Ok(mesh) = Mesh::new(v, t) else { continue };
        kept += 1;
        for solid in [
            ball(0.4),
            capsule(0.3, 0.2),
            capsule(0.0, 0.3),
            cuboid(0.3, 0.2, 0.5),
            cone(0.3, 0.4, 0.0),
            cone(0.3, 0.0, 0.4),
            cone(1.0, 3.0, 2.0),
        ] {
            let mut at = rng.vector(2.0);
            if rng.next() < 0.1 {
                at.x = odd[(rng.next() * 9.9) as usize];
            }
            let rotation = if rng.next() < 0.5 { Quat::IDENTITY } else { rng.rotation() };
            let mut out = [Manifold::default(); MAX_PARTS];
            let pose = Pose::new(at, rotation);
            let (reach, mut scratch) = (Reach::still(MARGIN), MeshScratch::default());
            let n =
                collide_mesh(Level::new(), &mesh, &solid, &pose, &reach, &mut scratch, &mut out);
            assert!(out[..n].iter().all(|m| m.count <= 4));
        }
    }
    assert!(kept > 300, "{kept}");
}

/// Prints times: `cargo test --release -p drystone -- --ignored --nocapture mesh_times`.
#[test]
#[ignore = "a measurement"]
fn mesh_times() {
    for (n, half) in [(1, 5.0), (20, 5.0), (100, 5.0)] {
        let mesh = grid(n, half, false, |_, _| 0.0);
        let rough = grid(n, half, false, |x, z| 0.02 * (x * 7.0 + z * z * 3.0 % 5.0) % 0.05);
        for (name, solid) in [
            ("ball", ball(0.5)),
            ("capsule", capsule(0.5, 0.5)),
            ("box", cuboid(0.5, 0.5, 0.5)),
            ("cylinder", cone(0.5, 0.5, 0.5)),
        ] {
            for (ground, mesh) in [("flat", &mesh), ("rough", &rough)] {
                let mut sum = 0;
                let (reach, mut scratch) = (Reach::still(MARGIN), MeshScratch::default());
                let start = std::time::Instant::now();
                for i in 0..2000 {
                    let pose = Pose::at(vec3(0.001 * i as f32 - 1.0, 0.499, 0.3));
                    let mut out = [Manifold::default(); MAX_PARTS];
                    sum += collide_mesh(
                        Level::new(),
                        mesh,
                        &solid,
                        &pose,
                        &reach,
                        &mut scratch,
                        &mut out,
                    );
                }
                let each = start.elapsed().as_secs_f64() / 2000.0 * 1e6;
                println!("{n}² {ground} {name}: {each:.2} µs, {} manifolds", sum / 2000);
            }
        }
    }
}
