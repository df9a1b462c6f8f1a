//! Hulls of real and random clouds are closed, convex and contain their points.
//!
//! `data/convex_hulls_even.bin` has point clouds of game assets. Each record has a count (u32) and
//! that number of points (3 × f32), little-endian. Its license is in the same folder.

use drystone::geometry::{Aabb, HullError};
use drystone::{Hull, Vec3, vec3};
use proptest::prelude::{Strategy, prop, proptest};

fn clouds() -> Vec<Vec<Vec3>> {
    let (words, rest) = include_bytes!("../data/convex_hulls_even.bin").as_chunks::<4>();
    assert!(rest.is_empty());
    let mut words = words.iter();
    let mut clouds = Vec::new();
    while let Some(count) = words.next() {
        let mut float = || f32::from_le_bytes(*words.next().expect("whole records"));
        let points = (0..u32::from_le_bytes(*count)).map(|_| vec3(float(), float(), float()));
        clouds.push(points.collect());
    }
    clouds
}

fn double(p: Vec3) -> [f64; 3] {
    p.to_array().map(f64::from)
}

/// Signed distance, computed in f64 to avoid rounding.
fn distance(hull: &Hull, face: usize, p: Vec3) -> f64 {
    let plane = hull.planes()[face];
    let (n, p) = (double(plane.normal), double(p));
    n[0] * p[0] + n[1] * p[1] + n[2] * p[2] - f64::from(plane.offset)
}

/// Checks every property that the collision routines require; returns the maximum distance of a
/// point above a plane.
fn check(hull: &Hull, points: &[Vec3]) -> f64 {
    let faces = hull.face_count();
    let (v, e) = (hull.vertices().len(), hull.edge_count());
    assert_eq!(v + faces, e + 2, "Euler");
    let bounds = Aabb::of_points(points.iter().copied());
    let size = f64::from((bounds.max - bounds.min).max_element());
    let reach = f64::from(bounds.max.abs().max(bounds.min.abs()).max_element());
    // Offsets and points are rounded to f32 at this magnitude.
    let slack = 1.0e-3 * size + 1.0e-6 * reach;
    let mut degree = vec![0; v];
    let mut highest: f64 = 0.0;
    for f in 0..faces {
        assert!((hull.planes()[f].normal.length() - 1.0).abs() < 1.0e-6);
        let face = hull.face(f);
        assert!(face.len() >= 3);
        for i in &face {
            degree[usize::from(*i)] += 1;
            let d = distance(hull, f, hull.vertices()[usize::from(*i)]);
            assert!(d.abs() <= slack, "corner {d} off its face, size {size}");
        }
        for p in hull.vertices() {
            assert!(distance(hull, f, *p) <= 1.0e-7 * reach, "vertex outside");
        }
        for p in points {
            highest = highest.max(distance(hull, f, *p));
        }
    }
    assert!(degree.iter().all(|d| *d >= 3));
    assert!(hull.vertices().iter().all(|p| points.contains(p)));
    highest / slack
}

fn parry_volume(points: &[Vec3]) -> Option<f64> {
    let middle = Aabb::of_points(points.iter().copied()).center();
    let points: Vec<parry3d::math::Vector> =
        points.iter().map(|p| parry3d::math::Vector::from((*p - middle).to_array())).collect();
    let (v, t) = parry3d::transformation::try_convex_hull(&points).ok()?;
    let volume = t.iter().map(|t| {
        let [a, b, c] = t.map(|i| v[i as usize].to_array().map(f64::from));
        let cross =
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        (cross[0] * c[0] + cross[1] * c[1] + cross[2] * c[2]) / 6.0
    });
    Some(volume.sum())
}

#[test]
fn every_cloud_of_game_assets_gives_a_sound_hull_or_is_flat() {
    let (mut valid, mut flat, mut compared) = (0, 0, 0);
    let mut worst = (0.0, 0);
    for (i, points) in clouds().iter().enumerate() {
        match Hull::from_points(points) {
            Ok(hull) => {
                valid += 1;
                let above = check(&hull, points);
                assert!(above <= 1.0, "cloud {i}: {above} of the slack above a plane");
                let Some(reference) = parry_volume(points).filter(|v| *v > 0.0) else { continue };
                compared += 1;
                let off = (f64::from(hull.volume()) / reference - 1.0).abs();
                if off > worst.0 {
                    worst = (off, i);
                }
            }
            Err(HullError::Flat(_)) => flat += 1,
            Err(e) => panic!("cloud {i}: {e}"),
        }
    }
    // Twelve of the flat ones lie exactly in a plane; the thickness of one is 6e-6 of its extent.
    assert_eq!((valid, flat, compared), (3365, 13, 3365));
    assert!(worst.0 < 0.01, "cloud {}: volume off by {} of parry's", worst.1, worst.0);
}

fn numbers(low: f32, high: f32) -> impl Strategy<Value = Vec3> {
    (low..high, low..high, low..high).prop_map(|(x, y, z)| vec3(x, y, z))
}

proptest! {
    #[test]
    fn a_hull_of_random_points_contains_them(
        points in prop::collection::vec(numbers(-1.0, 1.0), 4..200),
        squeeze in numbers(0.01, 10.0),
        shift in numbers(-50.0, 50.0),
    ) {
        let points: Vec<Vec3> =
            points.iter().map(|p| p.mul_each(squeeze) + shift).collect();
        match Hull::from_points(&points) {
            Ok(hull) => {
                let above = check(&hull, &points);
                assert!(above <= 1.0, "{above} of the slack above a plane");
            }
            Err(e) => assert!(matches!(e, HullError::Flat(_)), "{e}"),
        }
    }

    #[test]
    fn points_on_a_coarse_grid_give_a_sound_hull(
        points in prop::collection::vec(prop::array::uniform3(0_u8..5), 4..60),
        limit in 4_usize..40,
    ) {
        let points: Vec<Vec3> =
            points.iter().map(|p| Vec3::from(p.map(|x| f32::from(x) * 0.1))).collect();
        match Hull::from_points(&points) {
            Ok(hull) => assert!(check(&hull, &points) <= 1.0),
            Err(e) => assert!(matches!(e, HullError::Flat(_)), "{e}"),
        }
        if let Ok(hull) = Hull::from_points_limited(&points, limit) {
            check(&hull, &points);
            assert!(hull.vertices().len() <= limit);
        }
    }

    #[test]
    fn points_scattered_by_about_the_tolerance_give_a_sound_hull(
        points in prop::collection::vec((prop::array::uniform3(-1_i8..2), numbers(-1.0, 1.0)), 8..200),
        scatter in 0.0_f32..7.0,
        axis in numbers(-1.0, 1.0),
    ) {
        // Scatter from 1e-7 to 1 of the extent, uniform in the exponent.
        let scatter = drystone::math::trig::exp(-scatter * core::f32::consts::LN_10);
        let turn = drystone::Quat::from_axis_angle(axis.normalize_or(Vec3::X), 1.0);
        let points: Vec<Vec3> = points
            .iter()
            .map(|(p, noise)| turn.rotate(Vec3::from(p.map(f32::from)) + *noise * scatter))
            .collect();
        match Hull::from_points(&points) {
            Ok(hull) => assert!(check(&hull, &points) <= 1.0),
            Err(e) => assert!(matches!(e, HullError::Flat(_)), "{e}"),
        }
    }

    #[test]
    fn the_hull_of_a_cuboids_corners_is_the_cuboid(half in numbers(0.1, 20.0)) {
        let corner = |i: u8, bit: u8, h: f32| if i >> bit & 1 == 1 { h } else { -h };
        let points: Vec<Vec3> = (0..8)
            .map(|i| vec3(corner(i, 0, half.x), corner(i, 1, half.y), corner(i, 2, half.z)))
            .collect();
        let hull = Hull::from_points(&points).unwrap();
        assert_eq!((hull.vertices().len(), hull.edge_count(), hull.face_count()), (8, 12, 6));
        let box_volume = 8.0 * half.x * half.y * half.z;
        assert!((hull.volume() - box_volume).abs() <= 1.0e-6 * box_volume);
        for plane in hull.planes() {
            let expected = plane.normal.abs().dot(half);
            assert!((plane.offset - expected).abs() <= 1.0e-6 * expected);
        }
    }
}
