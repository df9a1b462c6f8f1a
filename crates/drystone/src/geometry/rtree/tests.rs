//! Compares the tree with brute force, through every kind of change.

use super::RTree;
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, vec3};
use crate::base::threads::jobs::Jobs;
use crate::base::threads::team::Team;
use crate::geometry::boxes::Ray;

fn boxes(n: u32, seed: u32) -> Vec<Aabb> {
    let mut s = seed;
    let mut next = || {
        s = s.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (s >> 8) as f32 / 16_777_216.0 * 20.0
    };
    (0..n)
        .map(|i| {
            let p = vec3(next(), next(), next());
            // One in fifty is much larger than the others.
            let size = if i % 50 == 7 { 0.5 * next() } else { 0.1 + 0.05 * next() };
            Aabb::new(p, p + Vec3::splat(size))
        })
        .collect()
}

fn check(tree: &RTree, boxes: &[Option<Aabb>]) {
    for probe in self::boxes(40, 99) {
        let mut found = Vec::new();
        tree.query(&probe, |i| {
            found.push(i);
            true
        });
        found.sort_unstable();
        let brute: Vec<u32> = (0_u32..)
            .zip(boxes)
            .filter(|(_, b)| b.is_some_and(|b| b.overlaps(&probe)))
            .map(|(i, _)| i)
            .collect();
        assert_eq!(found, brute);
        let (origin, delta) = (probe.min - Vec3::splat(5.0), vec3(12.0, 11.0, 9.0));
        let inv = vec3(1.0 / delta.x, 1.0 / delta.y, 1.0 / delta.z);
        let mut met = Vec::new();
        tree.ray(&Ray::new(origin, delta), 1.0, |i| {
            met.push(i);
            1.0
        });
        met.sort_unstable();
        let brute: Vec<u32> = (0_u32..)
            .zip(boxes)
            .filter(|(_, b)| b.is_some_and(|b| b.meets_ray(origin, inv, 1.0)))
            .map(|(i, _)| i)
            .collect();
        assert_eq!(met, brute);
    }
    let mut pairs = Vec::new();
    for block in 0..tree.blocks() {
        tree.pairs_of(block, |a, b| pairs.push((a.min(b), a.max(b))));
    }
    pairs.sort_unstable();
    // Expected pairs come from the queries, checked above: brute force over all pairs of 5,000 is
    // slow.
    let mut expected = Vec::new();
    for (i, bounds) in (0_u32..).zip(boxes) {
        if let Some(bounds) = bounds {
            tree.query(bounds, |j| {
                if i < j {
                    expected.push((i, j));
                }
                true
            });
        }
    }
    expected.sort_unstable();
    assert_eq!(pairs, expected);
    assert_eq!(tree.len(), boxes.iter().flatten().count());
    let mut items: Vec<u32> = tree.items().collect();
    items.sort_unstable();
    let all: Vec<u32> = (0_u32..).zip(boxes).filter(|(_, b)| b.is_some()).map(|(i, _)| i).collect();
    assert_eq!(items, all);
}

#[test]
fn queries_find_what_brute_force_finds_through_every_change() {
    let team = Team::with_threads(3);
    for jobs in [Jobs::Inline, Jobs::Team(&team)] {
        let all = boxes(5000, 12345);
        let mut tree = RTree::default();
        let mut expected: Vec<Option<Aabb>> = Vec::new();
        check(&tree, &expected);
        for (k, (item, b)) in (0_u32..).zip(&all).enumerate() {
            tree.insert(b, item);
            expected.push(Some(*b));
            if [0, 6, 7, 8, 63, 64, 700, 4095].contains(&k) {
                check(&tree, &expected);
                tree.tidy(&jobs);
                check(&tree, &expected);
            }
        }
        tree.tidy(&jobs);
        check(&tree, &expected);
        for item in (0_u32..5000).step_by(3) {
            tree.remove(item);
            expected[item as usize] = None;
        }
        tree.tidy(&jobs);
        check(&tree, &expected);
        // A few move a little, then some jump, then all move, then most are removed.
        let others = boxes(5000, 777);
        for item in (1_u32..5000).step_by(3) {
            let b = all[item as usize].grown(0.1);
            tree.replace(item, &b);
            expected[item as usize] = Some(b);
        }
        check(&tree, &expected);
        for item in (2_u32..5000).step_by(33) {
            tree.replace(item, &others[item as usize]);
            expected[item as usize] = Some(others[item as usize]);
        }
        check(&tree, &expected);
        tree.tidy(&jobs);
        check(&tree, &expected);
        let moved: Vec<(u32, Aabb)> =
            tree.items().map(|item| (item, others[item as usize])).collect();
        for (item, b) in &moved {
            expected[*item as usize] = Some(*b);
        }
        tree.replace_all(&moved, &jobs);
        check(&tree, &expected);
        tree.replace_all(&moved[..5], &jobs);
        tree.tidy(&jobs);
        check(&tree, &expected);
        for item in (0_u32..5000).filter(|i| i % 3 != 0 && i % 11 != 0) {
            tree.remove(item);
            expected[item as usize] = None;
        }
        tree.tidy(&jobs);
        check(&tree, &expected);
        tree.insert(&all[0], 0);
        expected[0] = Some(all[0]);
        check(&tree, &expected);
    }
}

#[test]
fn a_ray_meets_near_boxes_first() {
    let mut tree = RTree::default();
    for item in 0..1000_u32 {
        let p = vec3(item as f32 * 2.0, 0.0, 0.0);
        tree.insert(&Aabb::new(p, p + Vec3::splat(1.0)), item);
    }
    tree.tidy(&Jobs::Inline);
    let mut visits = 0;
    let ray = Ray::new(vec3(-1.0, 0.5, 0.5), vec3(3000.0, 0.0, 0.0));
    tree.ray(&ray, 1.0, |item| {
        visits += 1;
        (item as f32 * 2.0 + 1.0) / 3000.0
    });
    assert!(visits <= 2, "{visits}");
}
