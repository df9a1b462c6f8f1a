//! Definitions and states that are refused, by name.

use crate::reduced::tree::Tree;
use crate::reduced::{
    LinkDef, RowSoftness, TreeCoupling, TreeDef, TreeJoint, TreeLoop, TreeTendon,
};

use super::trees::GRAVITY;

fn two() -> TreeDef {
    let hinge = || TreeJoint::hinge([0.0, 1.0, 0.0]);
    let links = vec![LinkDef::on(None).with_joint(hinge()), LinkDef::on(0).with_joint(hinge())];
    TreeDef { links, ..TreeDef::default() }
}

/// The place that the error names.
fn refused(change: impl Fn(&mut TreeDef)) -> String {
    let mut def = two();
    change(&mut def);
    Tree::new(&def, GRAVITY).unwrap_err().place().to_owned()
}

#[test]
fn wrong_definitions_are_refused_by_their_place() {
    assert!(Tree::new(&two(), GRAVITY).is_ok());
    assert_eq!(refused(|d| d.links.clear()), "links");
    assert_eq!(refused(|d| d.links[1].parent = Some(1)), "links[1].parent");
    assert_eq!(refused(|d| d.links[0].parent = Some(1)), "links[0].parent");
    assert_eq!(refused(|d| d.links[1].parent = None), "links[1].parent");
    assert_eq!(refused(|d| d.links[1].mass = -1.0), "links[1].mass");
    assert_eq!(refused(|d| d.links[1].mass = f64::NAN), "links[1].mass");
    assert_eq!(refused(|d| d.links[1].position[2] = f64::INFINITY), "links[1].position");
    assert_eq!(refused(|d| d.links[1].rotation = [0.0; 4]), "links[1].rotation");
    assert_eq!(refused(|d| d.links[1].inertia[1] = -0.1), "links[1].inertia");
    assert_eq!(refused(|d| d.links[1].inertia[3] = 1.0), "links[1].inertia");
    let joint = |change: fn(&mut TreeJoint)| refused(|d| change(&mut d.links[1].joints[0]));
    assert_eq!(joint(|j| j.axis = [0.0; 3]), "links[1].joints[0].axis");
    assert_eq!(joint(|j| j.damping = -1.0), "links[1].joints[0].damping");
    assert_eq!(joint(|j| j.armature = f64::NAN), "links[1].joints[0].armature");
    assert_eq!(joint(|j| j.range = Some([1.0, 0.0])), "links[1].joints[0].range");
    assert_eq!(joint(|j| *j = TreeJoint::free()), "links[1].joints[0].kind");
    let ball = |j: &mut TreeJoint| *j = TreeJoint::ball().with_range(0.1, 0.2);
    assert_eq!(joint(ball), "links[1].joints[0].range");
    assert!(Tree::new(&two(), [0.0, f64::NAN, 0.0]).is_err());
}

#[test]
fn joint_that_moves_no_inertia_needs_armature() {
    // A point mass on the axis of its hinge.
    let point = |def: &mut TreeDef| def.links[1].inertia = [0.0; 6];
    assert_eq!(refused(point), "links[1].joints[0]");
    let mut def = two();
    point(&mut def);
    def.links[1].joints[0].armature = 0.01;
    assert!(Tree::new(&def, GRAVITY).is_ok());
    // Two hinges about one axis move the same inertia: the first has none of its own.
    let twice = |def: &mut TreeDef| {
        let joint = def.links[1].joints[0].clone();
        def.links[1].joints.push(joint);
    };
    assert_eq!(refused(twice), "links[1].joints[0]");
}

#[test]
fn wrong_couplings_tendons_and_loops_are_refused() {
    let coupling = TreeCoupling {
        follower: (1, 0),
        leader: Some((0, 0)),
        polynomial: [0.0, 1.0, 0.0, 0.0, 0.0],
        softness: RowSoftness::Rigid,
    };
    let add = |c: TreeCoupling| refused(move |d| d.couplings.push(c.clone()));
    assert_eq!(add(TreeCoupling { leader: Some((1, 0)), ..coupling.clone() }), "couplings[0]");
    assert_eq!(add(TreeCoupling { follower: (1, 1), ..coupling.clone() }), "couplings[0]");
    let softness = RowSoftness::Spring { frequency: 0.0, ratio: 1.0 };
    assert_eq!(add(TreeCoupling { softness, ..coupling }), "couplings[0].softness.frequency");
    let tendon = TreeTendon {
        terms: vec![((7, 0), 1.0)],
        range: None,
        stiffness: 0.0,
        damping: 0.0,
        rest: 0.0,
        friction: 0.0,
    };
    assert_eq!(refused(|d| d.tendons.push(tendon.clone())), "tendons[0]");
    let closure = TreeLoop {
        link_a: 1,
        link_b: Some(1),
        point_a: [0.0; 3],
        point_b: [0.0; 3],
        rotation: None,
        softness: RowSoftness::Rigid,
    };
    assert_eq!(refused(|d| d.loops.push(closure.clone())), "loops[0]");
}

#[test]
fn wrong_states_are_refused() {
    let tree = Tree::new(&two(), GRAVITY).unwrap();
    assert!(tree.check_state(&[0.0, 1.0], &[0.0, 0.0]).is_ok());
    let place = |q: &[f64], v: &[f64]| tree.check_state(q, v).unwrap_err().place().to_owned();
    assert_eq!(place(&[0.0], &[0.0, 0.0]), "q");
    assert_eq!(place(&[0.0, f64::NAN], &[0.0, 0.0]), "q[1]");
    assert_eq!(place(&[0.0, 0.0], &[f64::INFINITY, 0.0]), "v[0]");
}
