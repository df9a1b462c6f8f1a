//! The interface for users: nothing that they pass panics, and errors change nothing.

use crate::reduced::{Articulation, LinkDef, TreeDef, TreeJoint, TreeStepConfig};

use super::trees::GRAVITY;

fn arm() -> Articulation {
    let hinge = || TreeJoint::hinge([0.0, 1.0, 0.0]);
    let links = vec![LinkDef::floating(), LinkDef::on(0).with_joint(hinge())];
    Articulation::new(&TreeDef { links, ..TreeDef::default() }, GRAVITY).unwrap()
}

#[test]
fn wrong_sizes_links_and_numbers_are_refused_and_change_nothing() {
    let mut arm = arm();
    let q = arm.q().to_vec();
    assert_eq!(arm.set_state(&q[1..], &[0.0; 7]).unwrap_err().place(), "q");
    assert_eq!(arm.set_state(&q, &[0.0; 8]).unwrap_err().place(), "v");
    assert_eq!(arm.set_state(&[0.0; 8], &[0.0; 7]).unwrap_err().place(), "q[3..7]");
    assert_eq!(arm.set_forces(&[0.0; 6]).unwrap_err().place(), "tau");
    assert_eq!(arm.set_forces(&[f64::NAN; 7]).unwrap_err().place(), "tau[0]");
    assert_eq!(arm.inverse_dynamics(&[]).unwrap_err().place(), "a");
    assert!(arm.add_force(2, [0.0; 3], [1.0; 3], [0.0; 3]).is_err());
    assert!(arm.add_force(1, [f64::NAN; 3], [1.0; 3], [0.0; 3]).is_err());
    assert!(arm.pose(2).is_none() && arm.jacobian(2, [0.0; 3]).is_none());
    assert!(arm.velocity(2, [0.0; 3]).is_none() && arm.joint_start(1, 1).is_none());
    for h in [0.0, -1.0, f64::NAN, f64::INFINITY, 2.0] {
        assert_eq!(arm.step(h).unwrap_err().place(), "h");
    }
    assert_eq!(arm.q(), q);
}

#[test]
fn absurd_tuning_and_huge_states_end_in_a_step_or_in_an_error() {
    let mut arm = arm();
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY, 1.0e300] {
        arm.set_config(TreeStepConfig {
            iterations: usize::MAX,
            sweeps: 0,
            recovery_speed: wrong,
            substep_turn: wrong,
            substeps: 0,
            ..TreeStepConfig::default()
        });
        for rate in [1.0, 1.0e3, 1.0e9] {
            let q = arm.q().to_vec();
            arm.set_state(&q, &[rate; 7]).unwrap();
            if arm.step(0.01).is_err() {
                continue;
            }
            assert!(arm.q().iter().chain(arm.v()).all(|x| x.is_finite()));
        }
    }
}

#[test]
fn tree_without_a_joint_stands_where_it_is() {
    let links = vec![LinkDef::on(None).with_position([1.0, 2.0, 3.0]), LinkDef::on(0)];
    let mut post = Articulation::new(&TreeDef { links, ..TreeDef::default() }, GRAVITY).unwrap();
    post.step(0.01).unwrap();
    assert_eq!(post.pose(1).map(|pose| pose.0), Some([1.0, 2.0, 3.0]));
    assert!(post.v().is_empty() && post.bias().is_empty() && post.mass_matrix().is_empty());
}

#[test]
fn force_at_a_point_moves_the_center_of_mass_by_its_impulse() {
    let mut arm = arm();
    arm.add_force(1, [0.1, 0.2, 0.3], [2.0, 0.0, 2.0 * 9.81], [0.1, 0.0, 0.0]).unwrap();
    assert!((arm.center_of_mass().0 - 2.0).abs() < 1.0e-12);
    arm.step(0.001).unwrap();
    let [_, linear] = arm.momentum();
    // The weight of 2 kg is borne.
    let expected = [0.002, 0.0, 0.0];
    let off = (0..3).map(|k| (linear[k] - expected[k]).abs()).fold(0.0, f64::max);
    assert!(off < 1.0e-12, "{linear:?}");
    assert!(arm.kinetic_energy() > 0.0 && arm.potential_energy().is_finite());
    assert!(arm.recovery_work().abs() < 1.0e-300);
}
