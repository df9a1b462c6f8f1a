//! Passive trees gain no energy, whatever their masses, joints, limits and steps.

use crate::base::random::Random;
use crate::reduced::TreeStepConfig;
use crate::reduced::step::TreeState;
use crate::reduced::tree::Tree;
use crate::reduced::work::TreeWork;

use super::trees::{BARE, GRAVITY, Kind, random_tree};

/// Kinetic energy, and the energy of gravity and springs [J].
fn energies(tree: &Tree<f64>, state: &TreeState<f64>, work: &mut TreeWork<f64>) -> [f64; 2] {
    tree.place(&state.q, work);
    tree.move_links(&state.v, work);
    let kinetic = tree.kinetic_energy(&state.v, work);
    [kinetic, tree.gravity_energy(work) + tree.spring_energy(&state.q)]
}

/// Runs a random tree for a time [s]; gives its largest gain of energy as a part of the kinetic
/// energy that it starts with, or of its weight times 0.1 m where that is more.
fn gain(seed: u64, kind: &Kind, hertz: f64, time: f64, config: &TreeStepConfig) -> f64 {
    let mut random = Random::new(seed);
    let (def, q, v) = random_tree(&mut random, kind);
    let tree = Tree::new(&def, GRAVITY).unwrap();
    let mut work = TreeWork::new(&tree);
    let mut state = TreeState { q, v };
    let tau = vec![0.0; tree.v_count()];
    let [kinetic, potential] = energies(&tree, &state, &mut work);
    let scale = kinetic.max(9.81 * 0.1 * tree.center_of_mass(&work).0);
    let start = kinetic + potential;
    let (mut maximum, mut recovered, mut left) = (0.0_f64, 0.0, time * hertz);
    while left > 0.5 {
        let report = tree.step(&mut state, &tau, 1.0 / hertz, config, &mut work);
        recovered += report.recovery_work;
        let energy: f64 = energies(&tree, &state, &mut work).iter().sum();
        assert!(energy.is_finite(), "seed {seed} at {hertz} Hz");
        maximum = maximum.max(energy - recovered - start);
        left -= 1.0;
    }
    maximum / scale
}

/// Checks that none of the trees gains more than a thousandth.
fn none_gains(seeds: core::ops::Range<u64>, kind: &Kind, hertz: f64, time: f64) {
    let config = TreeStepConfig::default();
    for seed in seeds {
        let gain = gain(seed, kind, hertz, time, &config);
        assert!(gain < 1.0e-3, "seed {seed} at {hertz} Hz gains {gain:e}");
    }
}

const FULL: Kind = Kind {
    links: [2, 40],
    armature: true,
    damping: true,
    springs: true,
    limits: true,
    friction: true,
};

#[test]
fn five_hundred_trees_with_all_forces_gain_no_energy_at_60_hz() {
    none_gains(0..500, &FULL, 60.0, 0.5);
}

#[test]
fn bare_chains_of_light_and_heavy_links_gain_no_energy_from_30_to_1000_hz() {
    none_gains(0..250, &BARE, 60.0, 0.5);
    none_gains(250..400, &BARE, 30.0, 0.5);
    none_gains(400..450, &BARE, 240.0, 0.2);
    none_gains(450..500, &BARE, 1000.0, 0.1);
}

#[test]
fn trees_with_all_forces_gain_no_energy_at_short_steps() {
    none_gains(500..560, &FULL, 240.0, 0.2);
    none_gains(560..600, &FULL, 1000.0, 0.1);
}

#[test]
fn closing_a_limit_that_costs_kinetic_energy_gains_none_at_all() {
    let config = TreeStepConfig { pays_recovery: true, ..TreeStepConfig::default() };
    for seed in 0..60 {
        let gain = gain(seed, &FULL, 60.0, 0.5, &config);
        assert!(gain < 1.0e-3, "seed {seed} gains {gain:e}");
    }
}

#[test]
fn chains_that_spin_fast_do_not_blow_up() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let (def, q, v) = random_tree(&mut random, &Kind { links: [5, 10], ..BARE });
        let tree = Tree::new(&def, [0.0; 3]).unwrap();
        let mut work = TreeWork::new(&tree);
        let v = v.iter().map(|x| x * 500.0).collect();
        let mut state = TreeState { q, v };
        let start: f64 = energies(&tree, &state, &mut work).iter().sum();
        let tau = vec![0.0; tree.v_count()];
        for _ in 0..60 {
            tree.step(&mut state, &tau, 1.0 / 60.0, &TreeStepConfig::default(), &mut work);
            let energy: f64 = energies(&tree, &state, &mut work).iter().sum();
            assert!(energy < start * 1.001, "{seed}: {energy} of {start}");
        }
    }
}
