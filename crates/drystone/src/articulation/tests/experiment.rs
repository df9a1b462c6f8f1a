use super::trees::*;
use crate::articulation::*;
use crate::base::random::Random;

fn total(tree: &Tree<f64>, s: &TreeState<f64>, w: &mut TreeWork<f64>) -> f64 {
    tree.place(&s.q, w);
    tree.move_links(&s.v, w);
    tree.kinetic_energy(&s.v, w) + tree.gravity_energy(w) + tree.spring_energy(&s.q)
}

fn run(name: &str, kind: &Kind, config: &TreeStepConfig, hz: f64, n: u64, speed: f64, seconds: f64) {
    let mut worst = 0.0_f64; let mut over = 0; let mut bad = 0; let mut fell = 0; let mut list = vec![]; let mut which = 0;
    for seed in 0..n {
        let mut r = Random::new(seed);
        let (def, q, v) = random_tree(&mut r, kind);
        let tree = Tree::new(&def, GRAVITY).unwrap();
        let mut w = TreeWork::new(&tree);
        let mut s = TreeState { q, v: v.iter().map(|x| x * speed).collect() };
        let tau = vec![0.0; tree.v_count()];
        let e0 = total(&tree, &s, &mut w);
        // Scale: kinetic energy at start plus the weight lifted by the size
        let mut scale: f64 = { let k = tree.kinetic_energy(&s.v, &w); k };
        let (m, _) = tree.center_of_mass(&w);
        scale = scale.max(m * 9.81 * 0.1);
        let mut gain = 0.0_f64; let mut rec = 0.0; let mut low = 0.0_f64;
        for _ in 0..(seconds * hz) as usize {
            let rep = tree.step(&mut s, &tau, 1.0 / hz, config, &mut w);
            rec += rep.recovery_work;
            let e = total(&tree, &s, &mut w) - rec;
            if !e.is_finite() { bad += 1; break; }
            gain = gain.max(e - e0); low = low.min(e - e0);
        }
        let g = gain / scale;
        list.push(g);
        if g > worst { worst = g; which = seed; }
        if g > 1e-3 { over += 1; }
        if low / scale < -1e-2 { fell += 1; }
    }
    list.sort_by(|a, b| a.partial_cmp(b).unwrap());
    println!("{name} {hz} Hz: worst gain {worst:.2e} (seed {which}), median {:.2e}, over 0.1%: {over}, lost>1%: {fell}, nonfinite {bad}", list[list.len() / 2]);
}

#[test]
fn experiment() {
    let full = Kind { armature: true, damping: true, springs: true, limits: true, friction: false, ..BARE };
    let n: u64 = std::env::var("N").ok().and_then(|s| s.parse().ok()).unwrap_or(60);
    let kept = TreeStepConfig::default();
    let plain = TreeStepConfig { keep_energy: false, keep_momentum: false, ..kept };
    
    let _ = plain;
    for hz in [30.0, 60.0, 240.0, 1000.0] {
        for (name, c) in [("kept", &kept)] {
            run(&format!("bare {name}"), &BARE, c, hz, n, 1.0, 1.0);
            run(&format!("full {name}"), &full, c, hz, n, 1.0, 1.0);
        }
    }
}

#[test]
fn single() {
    let full = Kind { armature: true, damping: true, springs: true, limits: true, friction: false, ..BARE };
    let kept = TreeStepConfig::default();
    for (kind, seed, hz) in [(&BARE, 162, 30.0), (&full, 164, 30.0), (&full, 115, 60.0), (&full, 19, 240.0)] {
        let mut r = Random::new(seed);
        let (def, q, v) = random_tree(&mut r, kind);
        let tree = Tree::new(&def, GRAVITY).unwrap();
        let mut w = TreeWork::new(&tree);
        let mut s = TreeState { q, v };
        let tau = vec![0.0; tree.v_count()];
        println!("SI seed {seed} links {} dofs {} floats {}", tree.link_count(), tree.v_count(), tree.floats());
        let mut last = total(&tree, &s, &mut w);
        let mut top = last;
        println!("SI start E {last:.5} K {:.5} V {:.5}", tree.kinetic_energy(&s.v, &w), tree.gravity_energy(&w));
        for i in 0..hz as usize {
            let old = s.clone();
            let rep = tree.step(&mut s, &tau, 1.0 / hz, &kept, &mut w);
            let e = total(&tree, &s, &mut w) - rep.recovery_work;
            if e > last + 1e-6 * last.abs() { println!("SI {i}: E {last:.5} -> {e:.5} K {:.5} V {:.5} S {:.5} -> {:.5} rec {:.6} rows {}", tree.kinetic_energy(&s.v, &w), tree.gravity_energy(&w), tree.spring_energy(&old.q), tree.spring_energy(&s.q), rep.recovery_work, w.rows.rows.len()); }
            last = e + rep.recovery_work; top = top.max(last);
        }
    }
}

#[test]
fn variants() {
    for (name, c) in [
        ("2 iterations", TreeStepConfig { iterations: 2, ..Default::default() }),
        ("3 iterations", TreeStepConfig { iterations: 3, ..Default::default() }),
        ("no energy", TreeStepConfig { keep_energy: false, keep_momentum: false, ..Default::default() }),
        ("2 iterations turn 0.1", TreeStepConfig { iterations: 2, substep_turn: 0.1, ..Default::default() }),
        ("turn 0.1", TreeStepConfig { substep_turn: 0.1, ..Default::default() }),
        ("turn 0.05", TreeStepConfig { substep_turn: 0.05, ..Default::default() }),
    ] {
        print!("{name}: ");
        for m in super::mujoco::references().iter().filter(|m| m.name.ends_with("-free")) {
            let e = [0.01, 0.002].map(|h| super::mujoco::swing_with(m, h, &c).0.to_degrees());
            print!("{} {:.3}/{:.4}; ", m.name, e[0], e[1]);
        }
        println!();
    }
}

#[test]
fn euler_variants() {
    let link = LinkDef::floating().with_mass(2.0, [0.1, -0.2, 0.05], [0.02, 0.05, 0.06, 0.0, 0.0, 0.0]);
    let tree = Tree::new(&TreeDef { links: vec![link], ..TreeDef::default() }, [0.0; 3]).unwrap();
    let i = [0.02, 0.05, 0.06];
    let mut w = [0.3, 4.0, 0.2];
    let f = |w: [f64; 3]| -> [f64; 3] { std::array::from_fn(|a| (i[(a + 1) % 3] - i[(a + 2) % 3]) * w[(a + 1) % 3] * w[(a + 2) % 3] / i[a]) };
    let h = 1e-4;
    for _ in 0..20000 { let a = f(w); let m: [f64; 3] = std::array::from_fn(|k| w[k] + 0.5 * h * a[k]); let b = f(m); for k in 0..3 { w[k] += h * b[k]; } }
    for (name, c) in [("default", TreeStepConfig::default()), ("plain", TreeStepConfig { keep_energy: false, keep_momentum: false, ..Default::default() }), ("mom", TreeStepConfig { keep_energy: false, ..Default::default() })] {
        for n in [1000, 2000, 4000] {
            let mut s = TreeState::new(&tree); s.v[3..].copy_from_slice(&[0.3, 4.0, 0.2]);
            let mut work = TreeWork::new(&tree);
            for _ in 0..n { tree.step(&mut s, &[0.0; 6], 2.0 / n as f64, &c, &mut work); }
            println!("EU {name} {n}: {:?} exact {w:?}", &s.v[3..]);
        }
    }
}
