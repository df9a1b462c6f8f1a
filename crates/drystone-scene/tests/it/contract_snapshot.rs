//! Snapshots: what is restored goes on with the same bits for any number of threads, and is the
//! same bytes again.

use std::sync::Arc;

use drystone::World;
use drystone::threads::Team;
use drystone_scene::{ResumeError, Running, named};

const DT: f32 = 1.0 / 60.0;

/// A run, and when it was saved.
struct Twin(u32, Running);

fn goes_on(name: &str, saves: &[u32], steps: u32) {
    let scene = named(name).unwrap();
    let mut running = scene.build().unwrap();
    let mut twins: Vec<Twin> = Vec::new();
    for step in 0..steps {
        if saves.contains(&step) {
            let bytes = running.world.snapshot();
            let again = World::restore(&bytes).unwrap();
            assert!(again.snapshot() == bytes, "{name} at {step}: other bytes");
            let mut twin = scene.resume(&scene.save(&running).unwrap()).unwrap();
            twin.world.set_executor(Arc::new(Team::new(2)));
            twins.push(Twin(step, twin));
        }
        running.step(DT).unwrap();
        for Twin(from, twin) in &mut twins {
            twin.step(DT).unwrap();
            let (a, b) = (running.world.state_hash(), twin.world.state_hash());
            assert_eq!(a, b, "{name} at {step}, saved at {from}");
        }
    }
    for Twin(_, twin) in &twins {
        assert_eq!((&twin.names, &twin.bodies), (&running.names, &running.bodies), "{name}");
    }
}

/// Before the first step, after it, and amid impacts.
const EARLY: &[u32] = &[0, 1, 20, 34];

#[test]
fn piles_and_what_falls_asleep_go_on_from_a_snapshot_with_the_same_bits() {
    goes_on("pile:n=150", EARLY, 70);
    goes_on("domino", EARLY, 60);
    goes_on("bouncy_cube_incline", EARLY, 60);
    // Some sleep, all sleep, and a ball wakes them.
    goes_on("wall:ball=1", &[0, 5, 30], 60);
    goes_on("stack:n=5", &[30, 100, 150], 200);
}

#[test]
fn meshes_joints_and_scripts_go_on_from_a_snapshot_with_the_same_bits() {
    goes_on("ragdolls:n=6,muscles=50", EARLY, 60);
    // Bodies come before steps 16 and 64.
    goes_on("rain", &[10, 40], 70);
    goes_on("gears", EARLY, 60);
    goes_on("vehicle", EARLY, 60);
    goes_on("conveyor", EARLY, 60);
    goes_on("trees100", &[1, 20], 30);
}

#[test]
fn what_breaks_and_particles_go_on_from_a_snapshot_with_the_same_bits() {
    goes_on("wrecking_ball", &[1, 40, 80], 120);
    goes_on("fracture", &[1, 30, 50], 70);
    goes_on("rope", EARLY, 60);
    goes_on("cloth", &[1, 20], 40);
}

#[test]
fn a_run_goes_on_with_its_own_scene_only() {
    let [wall, other] = ["wall", "wall:ball=1"].map(|name| named(name).unwrap());
    let saved = wall.save(&wall.build().unwrap()).unwrap();
    assert!(matches!(other.resume(&saved), Err(ResumeError::OtherScene)));
    let mut moved = wall.clone();
    moved.bodies[3].def.position.y += 1.0e-5;
    assert!(matches!(moved.resume(&saved), Err(ResumeError::OtherScene)));
    assert!(wall.resume(&saved).is_ok());
}
