//! The same bits for any number of threads and any SIMD level.

use std::sync::Arc;

use drystone::threads::{SimdLevel, Team};
use drystone_scene::{Scene, catalog};

/// Scenes short enough to be run eight times in CI: the large ones in small.
fn moderate(name: &'static str) -> Option<&'static str> {
    match name {
        "large_world" => Some("tiles=30"),
        "high_speed" => Some("n=300"),
        "rain" => Some("rows=3"),
        "cloth" => Some("n=20"),
        "dust" => Some("n=3000"),
        "hail" => Some("n=1000,bodies=60"),
        "large_pyramid" | "many_pyramids" | "convex_pile" | "joint_grid" | "junkyard"
        | "washer" | "trees50" | "trees25" => None,
        _ => Some(""),
    }
}

fn hash_after(scene: &Scene, steps: u32, threads: usize, level: SimdLevel) -> u64 {
    let mut running = scene.build().unwrap();
    running.world.set_executor(Arc::new(Team::with_threads(threads)));
    running.world.set_simd_level(level);
    for _ in 0..steps {
        running.step(1.0 / scene.hz).unwrap();
    }
    assert!(running.world.events().faults.is_empty(), "{}", scene.name);
    running.world.state_hash()
}

fn check(scene: &Scene, steps: u32) {
    let best = SimdLevel::best();
    let expected = hash_after(scene, steps, 1, best);
    for threads in 2..=4 {
        let found = hash_after(scene, steps, threads, best);
        assert_eq!(found, expected, "{}: {threads} threads", scene.name);
    }
    for level in SimdLevel::available().into_iter().skip(1) {
        let found = hash_after(scene, steps, 1, level);
        assert_eq!(found, expected, "{}: {}", scene.name, level.name());
    }
}

#[test]
fn sixty_steps_give_the_same_bits_for_all_threads_and_levels() {
    for entry in catalog() {
        if let Some(parameters) = moderate(entry.name) {
            let scene = entry.scene((!parameters.is_empty()).then_some(parameters)).unwrap();
            check(&scene, 60);
        }
    }
}

#[test]
fn what_breaks_gives_the_same_bits_for_all_threads_and_levels() {
    // The ball meets the wall after 87 steps.
    for parameters in ["bond=1", "bond=2"] {
        let entry = catalog().iter().find(|e| e.name == "wrecking_ball").unwrap();
        check(&entry.scene(Some(parameters)).unwrap(), 110);
    }
}

#[test]
#[ignore = "minutes in release: every scene at its own size, 300 steps"]
fn three_hundred_steps_of_every_scene_give_the_same_bits() {
    for entry in catalog() {
        check(&entry.scene(None).unwrap(), 300);
    }
}
