//! Limits, friction, couplings, tendons, loops and contacts.

use crate::reduced::row::{Bound, Rows, Segment};
use crate::reduced::spatial::Vector;
use crate::reduced::step::TreeState;
use crate::reduced::tree::Tree;
use crate::reduced::work::TreeWork;
use crate::reduced::{
    LinkDef, RowSoftness, TreeCoupling, TreeDef, TreeJoint, TreeLoop, TreeStepConfig, TreeTendon,
};

use super::closed_forms::run;
use super::trees::GRAVITY;

/// A wheel about y with the inertia 0.5 kg m²; its center is on the axis.
fn wheel(parent: Option<usize>, joint: TreeJoint) -> LinkDef {
    LinkDef::on(parent).with_joint(joint).with_mass(1.0, [0.0; 3], [0.5, 0.5, 0.5, 0.0, 0.0, 0.0])
}

const Y: [f64; 3] = [0.0, 1.0, 0.0];

fn tree(links: Vec<LinkDef>) -> Tree<f64> {
    Tree::new(&TreeDef { links, ..TreeDef::default() }, [0.0; 3]).unwrap()
}

/// Steps a tree under constant forces.
fn drive(tree: &Tree<f64>, state: &mut TreeState<f64>, tau: &[f64], h: f64, steps: usize) {
    let mut work = TreeWork::new(tree);
    for _ in 0..steps {
        tree.step(state, tau, h, &TreeStepConfig::default(), &mut work);
    }
}

#[test]
fn limit_stops_a_joint_without_bounce_and_holds_it() {
    let tree = tree(vec![wheel(None, TreeJoint::hinge(Y).with_range(-0.3, 0.3))]);
    for h in [1.0 / 60.0, 1.0 / 240.0, 1.0 / 1000.0] {
        let mut state = TreeState::new(&tree);
        state.v[0] = 4.0;
        let mut work = TreeWork::new(&tree);
        for _ in 0..240 {
            tree.step(&mut state, &[1.0], h, &TreeStepConfig::default(), &mut work);
            // An arrival may pass by half a step's motion.
            assert!(state.q[0] < 0.3 + 0.5 * h * 4.5, "{h} {}", state.q[0]);
            assert!(state.v[0] > -1.0e-9, "{h} {}", state.v[0]);
        }
        assert!((state.q[0] - 0.3).abs() < 1.0e-3, "{h} {}", state.q[0]);
        assert!(state.v[0].abs() < 1.0e-6, "{h} {}", state.v[0]);
    }
}

#[test]
fn violated_limit_closes_at_a_bounded_speed_and_leaves_none() {
    let tree = tree(vec![wheel(None, TreeJoint::hinge(Y).with_range(0.0, 1.0))]);
    let start = -20.0_f64.to_radians();
    for h in [1.0 / 60.0, 1.0 / 1000.0] {
        let mut state = TreeState::new(&tree);
        state.q[0] = start;
        let mut work = TreeWork::new(&tree);
        let mut steps = 0;
        while state.q[0] < -1.0e-4 {
            let before = state.q[0];
            tree.step(&mut state, &[0.0], h, &TreeStepConfig::default(), &mut work);
            // 1 rad/s, plus ten times the depth a second.
            let maximum = h * (1.0 + 10.0 * before.abs());
            assert!(state.q[0] - before <= maximum * 1.000_001, "{h} {}", state.q[0] - before);
            assert!(state.v[0].abs() < 1.0e-12, "{}", state.v[0]);
            steps += 1;
            assert!(steps < 2000);
        }
        assert!(state.q[0] < 1.0e-9, "{}", state.q[0]);
    }
}

#[test]
fn dry_friction_holds_below_its_force_and_takes_it_from_more() {
    let tree = tree(vec![wheel(None, TreeJoint::hinge(Y).with_friction(2.0))]);
    let mut state = TreeState::new(&tree);
    drive(&tree, &mut state, &[1.9], 0.01, 100);
    assert!(state.q[0].abs() < 1.0e-12 && state.v[0].abs() < 1.0e-12, "{state:?}");
    drive(&tree, &mut state, &[2.5], 0.01, 100);
    // (2.5 − 2)/0.5 for a second.
    assert!((state.v[0] - 1.0).abs() < 1.0e-9, "{}", state.v[0]);
    drive(&tree, &mut state, &[0.0], 0.01, 100);
    assert!(state.v[0].abs() < 1.0e-12, "{}", state.v[0]);
}

#[test]
fn damping_beyond_the_step_gives_the_terminal_speed() {
    // A damping time of 2.5e-5 s at a step of 1/60 s.
    let light = LinkDef::on(None).with_joint(TreeJoint::hinge(Y).with_damping(1.0)).with_mass(
        0.036,
        [0.0; 3],
        [2.5e-5, 2.5e-5, 2.5e-5, 0.0, 0.0, 0.0],
    );
    let tree = tree(vec![light]);
    for h in [1.0 / 60.0, 1.0 / 1000.0] {
        let mut state = TreeState::new(&tree);
        state.v[0] = 5.0;
        drive(&tree, &mut state, &[0.3], h, 5);
        // Each step leaves 1/(1 + z + z²/2) of the distance, z = h/2.5e-5 ≥ 40.
        assert!((state.v[0] - 0.3).abs() < 1.0e-9, "{h} {}", state.v[0]);
    }
}

#[test]
fn coupled_joints_move_as_one_inertia() {
    let links =
        vec![wheel(None, TreeJoint::hinge(Y)), wheel(Some(0), TreeJoint::hinge([0.0, 0.0, 1.0]))];
    let coupling = TreeCoupling {
        follower: (1, 0),
        leader: Some((0, 0)),
        polynomial: [0.1, 2.0, 0.0, 0.0, 0.0],
        softness: RowSoftness::Rigid,
    };
    let def = TreeDef { links, couplings: vec![coupling], ..TreeDef::default() };
    let tree = Tree::new(&def, [0.0; 3]).unwrap();
    let mut state = TreeState::new(&tree);
    state.q[1] = 0.1;
    drive(&tree, &mut state, &[0.3, 0.0], 0.01, 100);
    // Balls with perpendicular axes: (0.5 + 0.5 + 2² 0.5) a = 0.3 for a second.
    assert!((state.v[0] - 0.1).abs() < 1.0e-6, "{}", state.v[0]);
    assert!((state.v[1] - 0.2).abs() < 1.0e-6, "{}", state.v[1]);
    assert!((state.q[1] - 0.1 - 2.0 * state.q[0]).abs() < 1.0e-6, "{:?}", state.q);
}

#[test]
fn coupling_follows_its_polynomial() {
    let links = vec![wheel(None, TreeJoint::hinge(Y)), wheel(Some(0), TreeJoint::hinge(Y))];
    let coupling = TreeCoupling {
        follower: (1, 0),
        leader: Some((0, 0)),
        polynomial: [0.0, 0.5, 0.3, -0.2, 0.1],
        softness: RowSoftness::Rigid,
    };
    let def = TreeDef { links, couplings: vec![coupling], ..TreeDef::default() };
    let tree = Tree::new(&def, [0.0; 3]).unwrap();
    let mut state = TreeState::new(&tree);
    for _ in 0..10 {
        drive(&tree, &mut state, &[1.0, 0.0], 0.01, 10);
        let x = state.q[0];
        let y = x * (0.5 + x * (0.3 + x * (-0.2 + x * 0.1)));
        // A step leaves half its square times the curvature and the square of the speed.
        assert!((state.q[1] - y).abs() < 1.0e-3, "{} {y}", state.q[1]);
    }
    assert!(state.q[0] > 0.2, "{}", state.q[0]);
}

#[test]
fn tendon_swings_its_joints_at_the_frequency_of_its_spring() {
    let links =
        vec![wheel(None, TreeJoint::hinge(Y)), wheel(Some(0), TreeJoint::hinge([0.0, 0.0, 1.0]))];
    let tendon = TreeTendon {
        terms: vec![((0, 0), 1.0), ((1, 0), -2.0)],
        range: None,
        stiffness: 30.0,
        damping: 0.0,
        rest: 0.0,
        friction: 0.0,
    };
    let def = TreeDef { links, tendons: vec![tendon], ..TreeDef::default() };
    let tree = Tree::new(&def, [0.0; 3]).unwrap();
    // x = q0 − 2 q1 has the inverse inertia 1/1 + 4/0.5, so ω² = 9 · 30.
    let quarter = core::f64::consts::FRAC_PI_2 / (9.0 * 30.0_f64).sqrt();
    let mut state = TreeState::new(&tree);
    state.q[0] = 0.1;
    run(&tree, &mut state, quarter / 1000.0, 1000);
    let stretch = state.q[0] - 2.0 * state.q[1];
    // The row is implicit: in a quarter of a swing it loses ωh/2 · π/2 of the amplitude.
    assert!(stretch.abs() < 0.1 * 2.0e-3, "{stretch}");
}

#[test]
fn tendon_keeps_its_range() {
    let links = vec![wheel(None, TreeJoint::hinge(Y)), wheel(Some(0), TreeJoint::hinge(Y))];
    let tendon = TreeTendon {
        terms: vec![((0, 0), 1.0), ((1, 0), 1.0)],
        range: Some([-0.2, 0.2]),
        stiffness: 0.0,
        damping: 0.0,
        rest: 0.0,
        friction: 0.0,
    };
    let def = TreeDef { links, tendons: vec![tendon], ..TreeDef::default() };
    let tree = Tree::new(&def, [0.0; 3]).unwrap();
    let mut state = TreeState::new(&tree);
    state.v[1] = 1.0;
    drive(&tree, &mut state, &[0.0, 0.5], 0.005, 400);
    let length = state.q[0] + state.q[1];
    assert!((length - 0.2).abs() < 1.0e-3, "{length}");
}

#[test]
fn four_bar_linkage_swings_as_its_one_equation() {
    // Cranks of mass m and length a, a coupler of mass c that only translates.
    let (m, a, c, width) = (1.0, 0.4, 2.0, 0.6);
    let across = m * a * a / 12.0;
    let crank = |parent: Option<usize>, position: [f64; 3]| {
        LinkDef::on(parent).with_position(position).with_joint(TreeJoint::hinge(Y)).with_mass(
            m,
            [0.0, 0.0, -0.5 * a],
            [across, across, 1.0e-5, 0.0, 0.0, 0.0],
        )
    };
    let bar = c * width * width / 12.0;
    let coupler = LinkDef::on(0)
        .with_position([0.0, 0.0, -a])
        .with_joint(TreeJoint::hinge(Y))
        .with_mass(c, [0.5 * width, 0.0, 0.0], [1.0e-3, bar, bar, 0.0, 0.0, 0.0]);
    let links = vec![crank(None, [0.0; 3]), coupler, crank(Some(1), [width, 0.0, 0.0])];
    // The second crank hangs from the ground by its upper end.
    let closure = TreeLoop {
        link_a: 2,
        link_b: None,
        point_a: [0.0, 0.0, a],
        point_b: [width, 0.0, 0.0],
        rotation: None,
        softness: RowSoftness::Rigid,
    };
    let mut links = links;
    links[2].center = [0.0, 0.0, 0.5 * a];
    let def = TreeDef { links, loops: vec![closure], ..TreeDef::default() };
    let tree = Tree::new(&def, GRAVITY).unwrap();
    let start = 0.8_f64;
    let mut state = TreeState::new(&tree);
    state.q.copy_from_slice(&[start, -start, start]);
    // (2/3 m + c) a² θ'' = −(m + c) g a sin θ
    let factor = (m + c) * 9.81 / ((2.0 / 3.0 * m + c) * a);
    let (mut angle, mut rate) = (start, 0.0);
    for _ in 0..100_000 {
        rate -= 1.0e-5 * factor * f64::sin(angle);
        angle += 1.0e-5 * rate;
    }
    run(&tree, &mut state, 1.0e-3, 1000);
    assert!((state.q[0] - angle).abs() < 0.01, "{} {angle}", state.q[0]);
    assert!((state.q[0] + state.q[1]).abs() < 1.0e-3, "{:?}", state.q);
}

#[test]
fn weld_holds_a_chain_at_its_end() {
    // Three links with ball joints from the world; the weld bears the other end.
    let link = |parent: Option<usize>| {
        let at = if parent.is_none() { [0.0; 3] } else { [0.3, 0.0, 0.0] };
        LinkDef::on(parent).with_position(at).with_joint(TreeJoint::ball()).with_mass(
            1.0,
            [0.15, 0.0, 0.0],
            [1.0e-3, 8.0e-3, 8.0e-3, 0.0, 0.0, 0.0],
        )
    };
    let closure = TreeLoop {
        link_a: 2,
        link_b: None,
        point_a: [0.3, 0.0, 0.0],
        point_b: [0.9, 0.0, 0.0],
        rotation: Some([1.0, 0.0, 0.0, 0.0]),
        softness: RowSoftness::Rigid,
    };
    let def = TreeDef {
        links: vec![link(None), link(Some(0)), link(Some(1))],
        loops: vec![closure],
        ..TreeDef::default()
    };
    let tree = Tree::new(&def, GRAVITY).unwrap();
    let mut state = TreeState::new(&tree);
    run(&tree, &mut state, 0.002, 500);
    let mut work = TreeWork::new(&tree);
    tree.place(&state.q, &mut work);
    let (position, rotation) = tree.pose(2, &work).unwrap();
    let end = position + rotation.rotate(Vector([0.3, 0.0, 0.0])) - Vector([0.9, 0.0, 0.0]);
    assert!(end.length() < 1.0e-3, "{}", end.length());
    assert!(rotation.vector().length() < 1.0e-2, "{}", rotation.vector().length());
}

#[test]
fn contact_of_a_tree_and_a_body_is_a_row_of_two_segments() {
    // The tip of a floating two-link tree meets a ball of 0.3 kg along x.
    let (ball, normal) = (0.3_f64, Vector([1.0, 0.0, 0.0]));
    let links = vec![
        LinkDef::floating(),
        LinkDef::on(0).with_position([0.2, 0.0, 0.0]).with_joint(TreeJoint::hinge(Y)).with_mass(
            0.5,
            [0.1, 0.0, 0.1],
            [1.0e-3; 3].map(|i| 2.0 * i).into_iter().chain([0.0; 3]).collect::<Vec<_>>()[..]
                .try_into()
                .unwrap(),
        ),
    ];
    let tree = tree(links);
    let mut work = TreeWork::new(&tree);
    let state = TreeState::new(&tree);
    let v = [2.0, 0.0, 0.5, 0.1, -0.3, 0.2, 1.0];
    tree.place(&state.q, &mut work);
    tree.fill_mass_matrix(&mut work);
    tree.factor(&mut work, 0.0);
    let n = tree.v_count();
    // Whitened: the tree's velocities, then √m times those of the ball.
    let mut y = vec![0.0; n + 3];
    tree.whiten_velocity(&work, &v, &mut y[..n]);
    let tip = Vector([0.45, 0.0, 0.2]);
    let mut rows = Rows::new();
    let row = |direction: Vector<f64>, bound: Bound<f64>, rows: &mut Rows<f64>| {
        let mut numbers = vec![0.0; n];
        // A positive impulse pushes the ball along the direction, and the tree back.
        tree.fill_direction(Some(1), tip, -direction, &work, &mut numbers);
        tree.whiten_row(&work, &mut numbers);
        let a = rows.segment(0, &numbers);
        let b: Segment = rows.segment(n, &(direction * (1.0 / ball.sqrt())).0);
        rows.add([a, b], bound);
    };
    row(normal, Bound::Push(1.0), &mut rows);
    row(Vector([0.0, 1.0, 0.0]), Bound::Friction(0, 0.2), &mut rows);
    row(Vector([0.0, 0.0, 1.0]), Bound::Friction(0, 0.2), &mut rows);
    for _ in 0..50 {
        rows.sweep(&mut y);
    }
    let mut after = vec![0.0; n];
    tree.color_velocity(&work, &y[..n], &mut after);
    let thrown = Vector([y[n], y[n + 1], y[n + 2]]) * (1.0 / ball.sqrt());
    let momentum = |v: &[f64], work: &mut TreeWork<f64>| {
        tree.move_links(v, work);
        tree.momentum(work).linear
    };
    let given = momentum(&v, &mut work) - momentum(&after, &mut work);
    assert!((given - thrown * ball).length() < 1.0e-12, "{given:?} {thrown:?}");
    let tip_velocity =
        tree.point_velocity(1, Vector([0.25, 0.0, 0.2]), &work).map(|s| s.linear).unwrap();
    assert!((thrown - tip_velocity).dot(normal).abs() < 1.0e-9);
    // Friction is at its bound or stops the sliding.
    let side = |k: usize| (rows.rows[k].impulse.abs() - 0.2 * rows.rows[0].impulse).abs();
    let slide = thrown - tip_velocity;
    assert!(rows.rows[0].impulse > 0.1);
    assert!(side(1) < 1.0e-9 || slide.0[1].abs() < 1.0e-9, "{slide:?}");
    assert!(side(2) < 1.0e-9 || slide.0[2].abs() < 1.0e-9, "{slide:?}");
}
