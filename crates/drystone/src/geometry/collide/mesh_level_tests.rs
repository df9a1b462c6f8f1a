//! Compares the lanes of all SIMD levels with each other and with scalar searches.

use std::sync::Arc;

use fearless_simd::{Level, dispatch};

use super::{MeshScratch, Reach, Rng, collide_mesh, cone, cuboid, grid};
use crate::base::math::{Vec3, vec3};
use crate::base::pose::Pose;
use crate::base::simd::wide::SimdLevel;
use crate::geometry::collide::MAX_PARTS;
use crate::geometry::hull::Hull;
use crate::geometry::manifold::Manifold;
use crate::geometry::solid::{Core, Solid};

/// The hull of some points of a ball, more than a group of eight.
fn pebble(rng: &mut Rng, radius: f32) -> Solid {
    let points: Vec<Vec3> =
        (0..20).map(|_| rng.vector(1.0).normalize_or(Vec3::Y) * radius).collect();
    Solid { core: Core::Hull(Arc::new(Hull::from_points(&points).unwrap())), radius: 0.0 }
}

#[test]
fn every_simd_level_gives_the_same_bits() {
    let mesh = grid(12, 3.0, false, |x, z| 0.3 * (x * 5.0).abs().min(1.0) - 0.2 * z.abs());
    let mut rng = Rng(11);
    let mut touching = 0;
    for _ in 0..300 {
        for solid in [pebble(&mut rng, 0.5), cuboid(0.3, 0.2, 0.5), cone(0.3, 0.4, 0.1)] {
            let (at, rotation) = (rng.vector(1.0), rng.rotation());
            let pose = Pose::new(at, rotation);
            let reach = Reach { displacement: rng.vector(0.1), corners: true, ..Reach::still(0.1) };
            let made = SimdLevel::available().into_iter().map(|level| {
                let (mut out, mut scratch) =
                    ([Manifold::default(); MAX_PARTS], MeshScratch::default());
                let n = collide_mesh(level.0, &mesh, &solid, &pose, &reach, &mut scratch, &mut out);
                // All numbers as text, which distinguishes any two of them.
                (n, format!("{:?}", &out[..n.max(1)]))
            });
            let mut made: Vec<_> = made.collect();
            touching += usize::from(made[0].0 > 0);
            made.dedup();
            assert_eq!(made.len(), 1, "{made:?}");
        }
    }
    assert!(touching > 300, "{touching}");
}

#[test]
fn the_box_from_lanes_is_the_box_from_supports() {
    let mut rng = Rng(5);
    for _ in 0..200 {
        let solid = pebble(&mut rng, 0.7);
        let pose = Pose::new(rng.vector(50.0), rng.rotation());
        for level in SimdLevel::available() {
            let bounds = dispatch!(level.0, simd => solid.aabb_with(simd, &pose, None));
            assert_eq!(bounds, solid.aabb(&pose));
        }
    }
}

#[test]
fn the_edge_of_a_polytope_that_separates_most_is_that_of_a_search_one_by_one() {
    // A ridge: an edge of the polytope lands across it.
    let mesh = grid(2, 1.0, false, |x, _| -x.abs());
    let mut rng = Rng(23);
    let mut on_edges = 0;
    for _ in 0..1000 {
        let solid = pebble(&mut rng, 0.5);
        let pose = Pose::new(vec3(0.0, 0.45, 0.0) + rng.vector(0.02), rng.rotation());
        let Core::Hull(hull) = &solid.core else { unreachable!() };
        // Extent of the polytope downwards along each direction between the two sides of the ridge.
        let low = |n: Vec3| {
            let reach = |v: &Vec3| n.dot(pose.point(*v));
            hull.vertices().iter().map(reach).fold(f32::INFINITY, f32::min)
        };
        let steps = (-1000_i16..=1000).map(|i| f32::from(i) / 1000.0);
        let best = steps.map(|t| low(vec3(t, 1.0, 0.0) * (1.0 / (1.0 + t * t).sqrt())));
        let best = best.fold(f32::NEG_INFINITY, f32::max);
        let mut out = [Manifold::default(); MAX_PARTS];
        let (reach, mut scratch) = (Reach::still(0.2), MeshScratch::default());
        let n = collide_mesh(Level::new(), &mesh, &solid, &pose, &reach, &mut scratch, &mut out);
        // A vertex in the middle of the ridge may be the result instead, with its own normal.
        let on_ridge = out[0].normal.x.abs() < 0.7 && out[0].normal.z.abs() < 1.0e-3;
        if n == 1 && best > 0.0 && out[0].count == 1 && on_ridge {
            // The directions are 0.001 apart, and the separation changes by at most the radius
            // times that.
            let found = out[0].points[0].separation;
            assert!((found - best).abs() < 1.0e-3 * 0.5 + 1.0e-5, "{found} {best}");
            on_edges += 1;
        }
    }
    assert!(on_edges > 50, "{on_edges}");
}
