//! A robot arm in reduced coordinates: held against gravity, let go into its limit, and eight of
//! them side by side.

use drystone::articulation::{
    ArticulatedWork, Lanes, LinkDef, Number, Rotation, RowSoftness, Spatial, Tree, TreeCoupling,
    TreeDef, TreeError, TreeJoint, TreeJointKind, TreeLoop, TreeState, TreeStepConfig,
    TreeStepReport, TreeTendon, TreeWork, Vector,
};

fn main() -> Result<(), TreeError> {
    let hinge = || TreeJoint::hinge([0.0, 1.0, 0.0]).with_range(-1.0, 1.0).with_damping(0.05);
    let rod =
        |link: LinkDef| link.with_mass(1.0, [0.2, 0.0, 0.0], [1.0e-3, 0.014, 0.014, 0.0, 0.0, 0.0]);
    let links = vec![
        rod(LinkDef::on(None).with_joint(hinge())),
        rod(LinkDef::on(0).with_position([0.4, 0.0, 0.0]).with_joint(hinge())),
    ];
    assert!(links.iter().all(|link| link.joints[0].kind == TreeJointKind::Hinge));
    let mut def = TreeDef { links, ..TreeDef::default() };
    let tree = Tree::new(&def, [0.0, 0.0, -9.81])?;
    let mut work = TreeWork::new(&tree);
    let mut state = TreeState::new(&tree);

    // Horizontal, the shoulder bears 2 kg at 0.4 m, the elbow 1 kg at 0.2 m.
    let hold = tree.gravity_compensation(&state.q, &mut work).to_vec();
    assert!((hold[0] + 2.0 * 9.81 * 0.4).abs() < 1.0e-9 && (hold[1] + 9.81 * 0.2).abs() < 1.0e-9);
    tree.move_links(&state.v, &mut work);
    let mut rates = [0.0; 2];
    tree.accelerate(&hold, &[0.0; 2], &mut work, &mut ArticulatedWork::new(&tree), &mut rates);
    assert!(rates.iter().all(|rate| rate.abs() < 1.0e-9));

    // The tip moves down when the shoulder turns.
    let mut jacobian = [Spatial { angular: Vector([0.0; 3]), linear: Vector([0.0; 3]) }; 2];
    tree.jacobian(1, Vector([0.4, 0.0, 0.0]), &work, &mut jacobian);
    assert!((jacobian[0].linear.0[2] + 0.8).abs() < 1.0e-12);

    // Let go, it falls into its limits. They do not bounce, and give no energy.
    for _ in 0..600 {
        let config = TreeStepConfig::default();
        let report: TreeStepReport<f64> =
            tree.step(&mut state, &[0.0; 2], 1.0 / 240.0, &config, &mut work);
        assert!(report.recovery_work.abs() < 0.1);
    }
    println!("arm at rest: {:.3?} rad", state.q);
    assert!((state.q[0] - 1.0).abs() < 0.01);

    // A coupling, a tendon and a closure are parts of the definition.
    let softness = RowSoftness::Rigid;
    let polynomial = [0.0, -1.0, 0.0, 0.0, 0.0];
    def.couplings.push(TreeCoupling {
        follower: (1, 0),
        leader: Some((0, 0)),
        polynomial,
        softness,
    });
    let terms = vec![((0, 0), 1.0)];
    let [range, stiffness, damping, rest, friction] = [0.3, 0.0, 0.0, 0.0, 0.0];
    let range = Some([-range, range]);
    def.tendons.push(TreeTendon { terms, range, stiffness, damping, rest, friction });
    let (point_a, point_b) = ([0.0; 3], [0.0; 3]);
    def.loops.push(TreeLoop {
        link_a: 0,
        link_b: None,
        point_a,
        point_b,
        rotation: None,
        softness,
    });
    let eight: Tree<Lanes<f64, 8>> = Tree::new(&def, [0.0, 0.0, -9.81])?.spread();
    let mut state = TreeState::new(&eight);
    let (mut work, none) = (TreeWork::new(&eight), [Lanes::zero(); 2]);
    for _ in 0..600 {
        eight.step(&mut state, &none, 1.0 / 240.0, &TreeStepConfig::default(), &mut work);
    }
    eight.place(&state.q, &mut work);
    let turned: Option<Rotation<_>> = eight.pose(1, &work).map(|(_, rotation)| rotation);
    println!("coupled, in lane 0: {:.3} {:.3} rad", state.q[0].lane(0), state.q[1].lane(0));
    assert!((state.q[0].lane(7) - 0.3).abs() < 0.01 && turned.is_some());
    Ok(())
}
