//! Motions with a known solution: pendulums, tops, free bodies.

use crate::reduced::step::TreeState;
use crate::reduced::tree::Tree;
use crate::reduced::work::TreeWork;
use crate::reduced::{LinkDef, TreeDef, TreeJoint, TreeStepConfig};

use super::trees::GRAVITY;

/// Steps a tree without given forces.
pub(super) fn run(tree: &Tree<f64>, state: &mut TreeState<f64>, h: f64, steps: usize) {
    let mut work = TreeWork::new(tree);
    let tau = vec![0.0; tree.v_count()];
    for _ in 0..steps {
        tree.step(state, &tau, h, &TreeStepConfig::default(), &mut work);
    }
}

/// A number of steps as a float.
fn count(steps: usize) -> f64 {
    f64::from(u32::try_from(steps).unwrap())
}

/// A classical Runge-Kutta step of a system of first-order equations.
fn runge_kutta<const N: usize>(x: &mut [f64; N], h: f64, f: impl Fn(&[f64; N]) -> [f64; N]) {
    let at = |x: &[f64; N], k: &[f64; N], h: f64| core::array::from_fn(|i| x[i] + h * k[i]);
    let a = f(x);
    let b = f(&at(x, &a, 0.5 * h));
    let c = f(&at(x, &b, 0.5 * h));
    let d = f(&at(x, &c, h));
    for i in 0..N {
        x[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
    }
}

/// A rod that swings in the plane of x and z about its end; angle 0 hangs down.
fn rod(parent: Option<usize>, mass: f64, length: f64) -> LinkDef {
    let across = mass * length * length / 12.0;
    let position = if parent.is_none() { [0.0; 3] } else { [0.0, 0.0, -length] };
    LinkDef::on(parent)
        .with_position(position)
        .with_joint(TreeJoint::hinge([0.0, 1.0, 0.0]))
        .with_mass(mass, [0.0, 0.0, -0.5 * length], [across, across, 1.0e-6, 0.0, 0.0, 0.0])
}

#[test]
fn pendulum_returns_after_its_period_and_the_step_is_of_second_order() {
    let (mass, length, start) = (2.0, 0.5, 2.0);
    let def = TreeDef { links: vec![rod(None, mass, length)], ..TreeDef::default() };
    let tree = Tree::new(&def, GRAVITY).unwrap();
    // T = 2π √(I/mgl) / agm(1, cos(θ/2)), with I about the end.
    let (mut a, mut b) = (1.0_f64, f64::cos(start / 2.0));
    for _ in 0..10 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    let inertia = mass * length * length / 3.0;
    let period = core::f64::consts::TAU * (inertia / (mass * 9.81 * 0.5 * length)).sqrt() / a;
    // The speed at a quarter of the period is that of the whole fall.
    let speed = (2.0 * mass * 9.81 * 0.5 * length * (1.0 - f64::cos(start)) / inertia).sqrt();
    let error = |steps: usize| {
        let mut state = TreeState::new(&tree);
        state.q[0] = start;
        run(&tree, &mut state, period / 4.0 / count(steps), steps);
        assert!((state.v[0] + speed).abs() < 1.0e-4 * speed, "{}", state.v[0]);
        state.q[0]
    };
    let (coarse, fine) = (error(100), error(200));
    // At 100 steps in a quarter of the period, (ωh)² is 2e-4.
    assert!(coarse.abs() < 1.0e-3, "{coarse}");
    assert!((3.0..5.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

#[test]
fn double_pendulum_moves_as_its_equations_in_absolute_angles() {
    let (m1, l1, m2, l2) = (1.5, 0.4, 0.7, 0.6);
    let mut second = rod(Some(0), m2, l2);
    second.position = [0.0, 0.0, -l1];
    let def = TreeDef { links: vec![rod(None, m1, l1), second], ..TreeDef::default() };
    let tree = Tree::new(&def, GRAVITY).unwrap();
    // T = ½ (m1/3 + m2) l1² a'² + ½ (m2/3) l2² b'² + ½ m2 l1 l2 a' b' cos(a − b)
    // V = −(m1/2 + m2) g l1 cos a − m2/2 g l2 cos b
    let f = |x: &[f64; 4]| {
        let [a, b, u, w] = *x;
        let (s, c) = (a - b).sin_cos();
        let (maa, mbb) = ((m1 / 3.0 + m2) * l1 * l1, m2 / 3.0 * l2 * l2);
        let coupling = 0.5 * m2 * l1 * l2;
        let mab = coupling * c;
        let ra = -coupling * s * w * w - (0.5 * m1 + m2) * 9.81 * l1 * a.sin();
        let rb = coupling * s * u * u - 0.5 * m2 * 9.81 * l2 * b.sin();
        let det = maa * mbb - mab * mab;
        [u, w, (mbb * ra - mab * rb) / det, (maa * rb - mab * ra) / det]
    };
    let mut exact = [1.2, 0.4, 0.5, -1.0];
    for _ in 0..20_000 {
        runge_kutta(&mut exact, 5.0e-5, f);
    }
    let error = |steps: usize| {
        let mut state = TreeState::new(&tree);
        state.q.copy_from_slice(&[1.2, 0.4 - 1.2]);
        state.v.copy_from_slice(&[0.5, -1.0 - 0.5]);
        run(&tree, &mut state, 1.0 / count(steps), steps);
        let got = [state.q[0], state.q[0] + state.q[1]];
        (got[0] - exact[0]).abs().max((got[1] - exact[1]).abs())
    };
    let (coarse, fine) = (error(500), error(1000));
    assert!(coarse < 1.0e-3, "{coarse}");
    assert!((3.0..5.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// A floating body with three different moments.
fn brick() -> Tree<f64> {
    let link =
        LinkDef::floating().with_mass(2.0, [0.1, -0.2, 0.05], [0.02, 0.05, 0.06, 0.0, 0.0, 0.0]);
    Tree::new(&TreeDef { links: vec![link], ..TreeDef::default() }, [0.0; 3]).unwrap()
}

#[test]
fn free_body_turns_by_the_equations_of_euler() {
    let tree = brick();
    let moments = [0.02, 0.05, 0.06];
    let start = [0.3, 4.0, 0.2];
    let mut exact = start;
    for _ in 0..20_000 {
        runge_kutta(&mut exact, 1.0e-4, |w| {
            core::array::from_fn(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                (moments[j] - moments[k]) * w[j] * w[k] / moments[i]
            })
        });
    }
    let error = |steps: usize| {
        let mut state = TreeState::new(&tree);
        state.v[3..].copy_from_slice(&start);
        run(&tree, &mut state, 2.0 / count(steps), steps);
        (0..3).map(|i| (state.v[3 + i] - exact[i]).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(1000), error(2000));
    assert!(coarse < 0.02, "{coarse}");
    assert!((3.0..5.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

#[test]
fn fast_free_body_keeps_its_momentum_and_its_energy() {
    let tree = brick();
    for h in [1.0 / 30.0, 1.0 / 240.0] {
        let mut state = TreeState::new(&tree);
        state.v.copy_from_slice(&[1.0, 2.0, 3.0, 2.0, 60.0, 3.0]);
        let mut work = TreeWork::new(&tree);
        let sums = |state: &TreeState<f64>, work: &mut TreeWork<f64>| {
            tree.place(&state.q, work);
            tree.move_links(&state.v, work);
            (tree.momentum(work), tree.kinetic_energy(&state.v, work))
        };
        let (momentum, energy) = sums(&state, &mut work);
        for _ in 0..300 {
            tree.step(&mut state, &[0.0; 6], h, &TreeStepConfig::default(), &mut work);
            let (m, e) = sums(&state, &mut work);
            let change = (m.angular - momentum.angular).length();
            assert!(change < 1.0e-9 * momentum.angular.length(), "{change}");
            let change = (m.linear - momentum.linear).length();
            assert!(change < 1.0e-9 * momentum.linear.length(), "{change}");
            assert!((e / energy - 1.0).abs() < 1.0e-6, "{h} {}", e / energy);
        }
    }
}

#[test]
fn top_precesses_steadily_at_its_rate() {
    // A wheel on a rod from its point: mass m at distance l along z.
    let (m, l, across, along) = (0.5, 0.1, 4.0e-4, 7.0e-4);
    let link = LinkDef::on(None).with_joint(TreeJoint::ball()).with_mass(
        m,
        [0.0, 0.0, l],
        [across, across, along, 0.0, 0.0, 0.0],
    );
    let def = TreeDef { links: vec![link], ..TreeDef::default() };
    let tree = Tree::new(&def, GRAVITY).unwrap();
    // A Ω² cos θ − C s Ω + m g l = 0, with A about the point, C and s along the axis.
    let (tilt, spin) = (0.6_f64, 200.0);
    let a = across + m * l * l;
    let (x, y, z) = (a * tilt.cos(), along * spin, m * 9.81 * l);
    let rate = (y - (y * y - 4.0 * x * z).sqrt()) / (2.0 * x);
    let mut state = TreeState::new(&tree);
    state.q.copy_from_slice(&[(tilt / 2.0).cos(), (tilt / 2.0).sin(), 0.0, 0.0]);
    // Ω about the vertical is (0, sin θ, cos θ) Ω in the top's axes.
    state.v.copy_from_slice(&[0.0, rate * tilt.sin(), spin]);
    let time = 0.5;
    run(&tree, &mut state, 2.5e-4, 2000);
    let [w, i, j, k] = [state.q[0], state.q[1], state.q[2], state.q[3]];
    let axis = [2.0 * (i * k + w * j), 2.0 * (j * k - w * i), 1.0 - 2.0 * (i * i + j * j)];
    assert!((axis[2].acos() - tilt).abs() < 1.0e-3, "{}", axis[2].acos());
    // It starts tilted towards −y.
    let turned = axis[0].atan2(-axis[1]);
    let expected = rate * time;
    assert!((turned - expected).abs() < 2.0e-3 * expected.max(1.0), "{turned} {expected}");
}
