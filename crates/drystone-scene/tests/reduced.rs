//! Robots of files as articulations in reduced coordinates.

use std::path::{Path, PathBuf};

use drystone_scene::{Running, Scene, mjcf, urdf};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "xml" || e == "urdf") {
            found.push(path);
        }
    }
    found.sort();
}

/// The scene of a file with its trees reduced; `None` if it has none or is no robot.
fn reduced(path: &Path) -> Option<Scene> {
    let is_robot = path.extension().is_some_and(|e| e == "urdf");
    let read =
        if is_robot { urdf::load(path, &urdf::Options::default()) } else { mjcf::load(path) };
    let mut scene = read.ok()?;
    drystone_scene::reduce(&mut scene).then_some(scene)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few thousand")]
fn steps(scene: &Scene, seconds: f32) -> usize {
    (seconds * scene.hz) as usize
}

fn energy(run: &Running) -> f64 {
    let trees = run.world.articulations().map(|of| {
        let model = of.model();
        model.kinetic_energy() + model.potential_energy()
    });
    trees.sum()
}

/// Runs a scene without a fault; tells the energy, and what it gained at most in a step [J].
fn run(scene: &Scene, seconds: f32) -> Result<String, String> {
    let mut run = scene.build().map_err(|e| e.to_string())?;
    let steps = steps(scene, seconds);
    let start = energy(&run);
    let (mut last, mut gain) = (start, 0.0_f64);
    for _ in 0..steps {
        run.step(scene.hz.recip()).map_err(|e| e.to_string())?;
        if let Some(fault) = run.world.events().faults.first() {
            return Err(format!("{fault:?}"));
        }
        let now = energy(&run);
        gain = gain.max(now - last);
        last = now;
    }
    Ok(format!("{start:.3} to {last:.3} J, at most {gain:.4} J in a step"))
}

#[test]
fn robots_of_files_run_in_reduced_coordinates() {
    let mut found = Vec::new();
    match std::env::var_os("ROBOTS") {
        Some(folder) => files(Path::new(&folder), &mut found),
        None => {
            for name in ["mujoco", "robots", "mjcf-own"] {
                files(&data(name), &mut found);
            }
        }
    }
    let mut bad = Vec::new();
    let mut count = 0;
    for path in &found {
        let Some(scene) = reduced(path) else { continue };
        count += 1;
        let name = path.display();
        match run(&scene, 1.0) {
            Err(e) => bad.push(format!("{name}: {e}")),
            Ok(told) => eprintln!("{name}: {told}"),
        }
    }
    assert!(count > 0 && bad.is_empty(), "{count} files:\n{}", bad.join("\n"));
}

#[test]
fn a_humanoid_lands_and_lies_still() {
    let scene = reduced(&data("mujoco/humanoid.xml")).unwrap();
    let mut run = scene.build().unwrap();
    let start = energy(&run);
    for _ in 0..steps(&scene, 6.0) {
        run.step(scene.hz.recip()).unwrap();
        assert!(run.world.events().faults.is_empty());
        assert!(energy(&run) < start + 1.0, "{} J from {start} J", energy(&run));
    }
    let of = run.world.articulations().next().unwrap();
    let fastest = of.v().iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    assert!(fastest < 0.1, "{fastest}: {:?}", of.v());
    assert!((0.05..1.0).contains(&of.q()[2]), "{:?}", of.q());
}
