//! A tree in a lane has the bits of the tree alone, and bits repeat.

use crate::base::random::Random;
use crate::reduced::TreeStepConfig;
use crate::reduced::number::{Lanes, Number};
use crate::reduced::step::TreeState;
use crate::reduced::tree::Tree;
use crate::reduced::work::TreeWork;

use super::trees::{BARE, GRAVITY, Kind, between, random_tree};

/// Steps a tree in eight lanes with different states and forces, and each of them alone.
fn compare<T: Number>(seed: u64)
where
    Lanes<T, 8>: Number,
{
    let kind = Kind {
        links: [2, 10],
        armature: true,
        damping: true,
        springs: true,
        limits: true,
        friction: true,
    };
    let mut random = Random::new(seed);
    let (def, q, v) = random_tree(&mut random, &kind);
    let single = Tree::new(&def, GRAVITY).unwrap();
    let wide: Tree<Lanes<T, 8>> = single.spread();
    let alone: Tree<T> = single.spread();
    let mut state = TreeState::new(&wide);
    let mut tau = vec![Lanes::<T, 8>::zero(); wide.v_count()];
    for lane in 0..8 {
        // Lane 0 rests, the last ones are fast: their substeps, rows and closures differ.
        let speed = [0.0, 0.1, 0.5, 1.0, 2.0, 4.0, 10.0, 30.0][lane];
        for (x, &start) in state.q.iter_mut().zip(&q) {
            *x = x.with_lane(lane, start);
        }
        for (x, &start) in state.v.iter_mut().zip(&v) {
            *x = x.with_lane(lane, start * speed);
        }
        for x in &mut tau {
            *x = x.with_lane(lane, between(&mut random, -0.1, 0.1) * speed);
        }
    }
    let pick = |list: &[Lanes<T, 8>], lane: usize| {
        list.iter().map(|x| T::splat(x.lane(lane))).collect::<Vec<T>>()
    };
    let mut lone: Vec<TreeState<T>> =
        (0..8).map(|lane| TreeState { q: pick(&state.q, lane), v: pick(&state.v, lane) }).collect();
    let config = TreeStepConfig::default();
    let mut work = TreeWork::new(&wide);
    let mut own = TreeWork::new(&alone);
    for step in 0..40 {
        wide.step(&mut state, &tau, 0.01, &config, &mut work);
        for (lane, lone) in lone.iter_mut().enumerate() {
            alone.step(lone, &pick(&tau, lane), 0.01, &config, &mut own);
            let all = lone.q.iter().chain(&lone.v);
            for (i, (a, b)) in all.zip(state.q.iter().chain(&state.v)).enumerate() {
                let b = T::splat(b.lane(lane));
                assert!(a.same_bits(b), "seed {seed} step {step} lane {lane} [{i}]: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn tree_in_a_lane_has_the_bits_of_the_tree_alone() {
    for seed in 0..20 {
        compare::<f64>(seed);
        compare::<f32>(seed);
    }
}

#[test]
fn steps_do_not_depend_on_the_memory_that_they_use() {
    let mut random = Random::new(3);
    let kind = Kind { limits: true, springs: true, ..BARE };
    let (def, q, v) = random_tree(&mut random, &kind);
    let tree = Tree::new(&def, GRAVITY).unwrap();
    let tau = vec![0.0; tree.v_count()];
    let config = TreeStepConfig::default();
    let mut kept = TreeWork::new(&tree);
    let mut a = TreeState { q, v };
    let mut b = a.clone();
    for _ in 0..30 {
        tree.step(&mut a, &tau, 0.01, &config, &mut kept);
        tree.step(&mut b, &tau, 0.01, &config, &mut TreeWork::new(&tree));
        assert_eq!(a, b);
    }
}
