//! A robot arm in reduced coordinates: held against gravity, let go into its limits, and with a
//! coupling, a tendon and a closed loop.

use drystone::articulation::{
    Articulation, LinkDef, RowSoftness, TreeCoupling, TreeDef, TreeError, TreeJoint, TreeJointKind,
    TreeLoop, TreeStepConfig, TreeTendon,
};

const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), TreeError> {
    let hinge = || TreeJoint::hinge([0.0, 1.0, 0.0]).with_range(-1.0, 1.0).with_damping(0.05);
    let rod =
        |link: LinkDef| link.with_mass(1.0, [0.2, 0.0, 0.0], [1.0e-3, 0.014, 0.014, 0.0, 0.0, 0.0]);
    let upper = rod(LinkDef::on(None).with_joint(hinge()));
    let lower = rod(LinkDef::on(0).with_position([0.4, 0.0, 0.0]).with_joint(hinge()));
    assert!(lower.joints[0].kind == TreeJointKind::Hinge);
    let mut def = TreeDef { links: vec![upper, lower], ..TreeDef::default() };
    let mut arm = Articulation::new(&def, GRAVITY)?;

    // Horizontal, the shoulder bears 2 kg at 0.4 m, the elbow 1 kg at 0.2 m.
    let hold = arm.gravity_compensation();
    assert!((hold[0] + 2.0 * 9.81 * 0.4).abs() < 1.0e-9 && (hold[1] + 9.81 * 0.2).abs() < 1.0e-9);
    arm.set_forces(&hold)?;
    assert!(arm.accelerations().iter().all(|a| a.abs() < 1.0e-9));
    // The tip is 0.8 m from the shoulder and moves down when it turns.
    let tip = arm.jacobian(1, [0.4, 0.0, 0.0]).unwrap_or_default();
    assert!((tip[0][1][2] + 0.8).abs() < 1.0e-12);

    // Let go, it falls into its limits, which do not bounce.
    arm.set_forces(&[0.0; 2])?;
    for _ in 0..600 {
        arm.step(1.0 / 240.0)?;
    }
    println!("at rest: {:.3?} rad", arm.q());
    assert!((arm.q()[0] - 1.0).abs() < 0.01);

    // Now the elbow turns against the shoulder, a tendon holds the shoulder above 0.3 rad, and the
    // shoulder is pinned once more.
    let softness = RowSoftness::Rigid;
    let polynomial = [0.0, -1.0, 0.0, 0.0, 0.0];
    let (follower, leader) = ((1, 0), Some((0, 0)));
    def.couplings.push(TreeCoupling { follower, leader, polynomial, softness });
    let tendon = TreeTendon { terms: vec![((0, 0), 1.0)], ..TreeTendon::default() };
    def.tendons.push(TreeTendon { range: Some([-0.3, 0.3]), ..tendon });
    def.loops.push(TreeLoop::pin(0, [0.0; 3], None, [0.0; 3]));
    let mut arm = Articulation::new(&def, GRAVITY)?;
    arm.set_config(TreeStepConfig { sweeps: 20, ..TreeStepConfig::default() });
    for _ in 0..600 {
        arm.step(1.0 / 240.0)?;
    }
    println!("coupled: {:.3?} rad", arm.q());
    assert!((arm.q()[0] - 0.3).abs() < 0.01 && (arm.q()[1] + 0.3).abs() < 0.01);
    Ok(())
}
