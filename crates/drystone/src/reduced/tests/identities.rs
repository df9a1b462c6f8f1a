//! Identities between the algorithms, on random trees.

use crate::base::random::Random;
use crate::reduced::TreeStepConfig;
use crate::reduced::bodies::ArticulatedWork;
use crate::reduced::spatial::{Spatial, Vector};
use crate::reduced::step::TreeState;
use crate::reduced::tree::Tree;
use crate::reduced::work::TreeWork;

use super::trees::{BARE, GRAVITY, Kind, between, random_tree, vector};

const SMALL: Kind = Kind { links: [2, 12], armature: true, damping: true, springs: true, ..BARE };

/// A tree, random coordinates and velocities, and memory.
fn sample(seed: u64, kind: &Kind) -> (Tree<f64>, Vec<f64>, Vec<f64>, Random) {
    let mut random = Random::new(seed);
    let (def, mut q, v) = random_tree(&mut random, kind);
    let tree = Tree::new(&def, GRAVITY).unwrap();
    for x in &mut q {
        *x += between(&mut random, -1.0, 1.0);
    }
    tree.normalize(&mut q);
    (tree, q, v, random)
}

/// The largest number of a list.
fn maximum(list: &[f64]) -> f64 {
    list.iter().fold(0.0, |maximum, x| maximum.max(x.abs()))
}

#[test]
fn columns_of_the_mass_matrix_are_inverse_dynamics_of_unit_accelerations() {
    for seed in 0..100 {
        let (tree, q, v, _) = sample(seed, &SMALL);
        let n = tree.v_count();
        let mut work = TreeWork::new(&tree);
        tree.place(&q, &mut work);
        let matrix = tree.mass_matrix(&mut work);
        let none = tree.inverse_dynamics(&q, &v, &vec![0.0; n], &mut work).to_vec();
        for k in 0..n {
            let mut unit = vec![0.0; n];
            unit[k] = 1.0;
            let column = tree.inverse_dynamics(&q, &v, &unit, &mut work).to_vec();
            // Both are sums of at most 12 links' terms; the bias cancels.
            let scale = maximum(&matrix) + maximum(&none);
            for i in 0..n {
                let difference = column[i] - none[i] - matrix[i * n + k];
                assert!(difference.abs() < 1.0e-12 * scale, "{seed} {i} {k}: {difference}");
            }
        }
    }
}

#[test]
fn articulated_bodies_factor_and_inverse_dynamics_agree() {
    for seed in 0..100 {
        let (tree, q, v, mut random) = sample(seed, &SMALL);
        let n = tree.v_count();
        let mut work = TreeWork::new(&tree);
        let tau: Vec<f64> = (0..n).map(|_| between(&mut random, -1.0, 1.0)).collect();
        tree.place(&q, &mut work);
        tree.move_links(&v, &mut work);
        let mut articulated = vec![0.0; n];
        let mut memory = ArticulatedWork::new(&tree);
        tree.accelerate(&tau, &vec![0.0; n], &mut work, &mut memory, &mut articulated);
        tree.bias(&mut work);
        let mut solved: Vec<f64> = (0..n).map(|i| tau[i] - work.tau[i]).collect();
        tree.fill_mass_matrix(&mut work);
        tree.factor(&mut work, 0.0);
        let smallest = work.pivots.iter().fold(f64::MAX, |a, &b| a.min(b));
        let condition = maximum(&work.pivots) / smallest;
        tree.solve(&work, &mut solved);
        let scale = maximum(&solved);
        for i in 0..n {
            let difference = (articulated[i] - solved[i]).abs();
            assert!(difference < 1.0e-14 * condition * scale, "{seed} {i}: {difference} {scale}");
        }
        // Forces of this acceleration are the given ones, up to the digits of the bias.
        let back = tree.inverse_dynamics(&q, &v, &solved, &mut work).to_vec();
        let bias = tree.inverse_dynamics(&q, &v, &vec![0.0; n], &mut work).to_vec();
        for i in 0..n {
            let limit = 1.0e-13 * (maximum(&bias) + condition);
            assert!((back[i] - tau[i]).abs() < limit, "{seed} {i}: {} {}", back[i], tau[i]);
        }
    }
}

#[test]
fn jacobians_are_differences_of_poses() {
    for seed in 0..60 {
        let (tree, q, v, mut random) = sample(seed, &SMALL);
        let mut work = TreeWork::new(&tree);
        let link = tree.link_count() - 1;
        let point = Vector(vector(&mut random));
        let mut jacobian = vec![Spatial::zero(); tree.v_count()];
        tree.place(&q, &mut work);
        tree.move_links(&v, &mut work);
        tree.jacobian(link, point, &work, &mut jacobian);
        let rate = tree.point_velocity(link, point, &work).unwrap();
        let sum = jacobian.iter().zip(&v).fold(Spatial::zero(), |sum, (&s, &v)| sum + s * v);
        let difference = sum - rate;
        assert!(difference.dot(difference) < 1.0e-20 * (1.0 + rate.dot(rate)), "{seed}");
        let h = 1.0e-5;
        let at = |h: f64, work: &mut TreeWork<f64>| {
            let mut moved = q.clone();
            tree.advance(&mut moved, &v, h);
            tree.place(&moved, work);
            let (position, rotation) = tree.pose(link, work).unwrap();
            (position + rotation.rotate(point), rotation)
        };
        let ((a, turn_a), (b, turn_b)) = (at(-h, &mut work), at(h, &mut work));
        let linear = (b - a) * (0.5 / h);
        let angular = turn_b.times(turn_a.inverse()).vector() * (0.5 / h);
        // The error of the difference is h²/6 times a third derivative, of the size of the cube
        // of rates: below 20 rad/s here.
        let size = 1.0 + rate.dot(rate).sqrt();
        let limit = 1.0e-9 * size * size * size;
        assert!((linear - rate.linear).length() < limit, "{seed}");
        assert!((angular - rate.angular).length() < limit, "{seed}");
    }
}

#[test]
fn forces_of_a_wrench_have_its_power() {
    for seed in 0..60 {
        let (tree, q, v, mut random) = sample(seed, &SMALL);
        let mut work = TreeWork::new(&tree);
        tree.place(&q, &mut work);
        tree.move_links(&v, &mut work);
        let link = tree.link_count() / 2;
        let point = Vector(vector(&mut random));
        let wrench =
            Spatial { angular: Vector(vector(&mut random)), linear: Vector(vector(&mut random)) };
        let mut tau = vec![0.0; tree.v_count()];
        tree.add_wrench(link, point, wrench, &work, &mut tau);
        let power: f64 = tau.iter().zip(&v).map(|(t, v)| t * v).sum();
        let expected = wrench.dot(tree.point_velocity(link, point, &work).unwrap());
        assert!((power - expected).abs() < 1.0e-12 * (1.0 + expected.abs()), "{seed}");
    }
}

#[test]
fn held_against_gravity_a_tree_does_not_accelerate() {
    let kind = Kind { links: [2, 12], armature: true, ..BARE };
    for seed in 0..60 {
        let (tree, q, _, _) = sample(seed, &kind);
        let n = tree.v_count();
        let mut work = TreeWork::new(&tree);
        let tau = tree.gravity_compensation(&q, &mut work).to_vec();
        let mut a = vec![0.0; n];
        tree.forward_dynamics(&q, &vec![0.0; n], &tau, &mut work, &mut a);
        let smallest = work.pivots.iter().fold(f64::MAX, |a, &b| a.min(b));
        let limit = 1.0e-14 * maximum(&tau) / smallest;
        assert!(maximum(&a) < limit, "{seed}: {} {limit}", maximum(&a));
    }
}

#[test]
fn floating_tree_keeps_its_momentum_under_inner_forces() {
    let kind = Kind { armature: true, damping: true, springs: true, limits: true, ..BARE };
    let mut floating = 0;
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let (def, q, v) = random_tree(&mut random, &kind);
        let tree = Tree::new(&def, [0.0; 3]).unwrap();
        if !tree.floats() {
            continue;
        }
        floating += 1;
        let mut tau = vec![0.0; tree.v_count()];
        for force in &mut tau[6..] {
            *force = between(&mut random, -1.0, 1.0);
        }
        let mut work = TreeWork::new(&tree);
        let mut state = TreeState { q, v };
        let sums = |state: &TreeState<f64>, work: &mut TreeWork<f64>| {
            tree.place(&state.q, work);
            tree.move_links(&state.v, work);
            (tree.momentum(work), tree.center_of_mass(work))
        };
        let (start, (mass, center)) = sums(&state, &mut work);
        for _ in 0..60 {
            tree.step(&mut state, &tau, 1.0 / 60.0, &TreeStepConfig::default(), &mut work);
        }
        let (end, (_, moved)) = sums(&state, &mut work);
        // Momentum is restored in each of up to 16 · 60 substeps, to the digits of its terms.
        let size = start.linear.length() + mass;
        assert!((end.linear - start.linear).length() < 1.0e-9 * size, "{seed}");
        let size = start.angular.length() + mass;
        assert!((end.angular - start.angular).length() < 1.0e-8 * size, "{seed}");
        let way = start.linear * (1.0 / mass);
        assert!((moved - center - way).length() < 1.0e-9 * (1.0 + way.length()), "{seed}");
    }
    assert!(floating > 10, "{floating}");
}
