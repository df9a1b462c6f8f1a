//! Snapshots: the world that is restored goes on with the same bits.

use drystone::World;
use drystone_scene::{catalog, named};

/// Of every scene, at moments in which bodies fly, meet and rest.
#[test]
fn every_scene_goes_on_from_a_snapshot_with_the_same_bits() {
    for entry in catalog() {
        if matches!(entry.name, "large_world" | "washer" | "junkyard" | "convex_pile" | "large_pyramid" | "many_pyramids" | "joint_grid") { continue; }
        if std::env::var("ONLY").is_ok_and(|o| !o.split(",").any(|n| n == entry.name)) { continue; }
        let scene = named(entry.name).unwrap();
        let mut running = scene.build().unwrap();
        let mut others: Vec<(u32, World)> = Vec::new();
        for step in 0..150 {
            if [0, 1, 20, 60].contains(&step) {
                let bytes = running.world.snapshot();
                let world = World::restore(&bytes).unwrap_or_else(|e| panic!("{} {step}: {e}", entry.name));
                assert!(world.snapshot() == bytes, "{} {step}", entry.name);
                others.push((step, world));
                if step == 60 { println!("{} {} bytes a body {}", entry.name, bytes.len(), bytes.len() / running.world.bodies().count().max(1)); }
            }
            let script = running.clone();
            running.step(1.0 / 60.0).unwrap();
            for (from, other) in &mut others {
                let mut twin = script.clone();
                core::mem::swap(&mut twin.world, other);
                twin.step(1.0 / 60.0).unwrap();
                core::mem::swap(&mut twin.world, other);
                assert_eq!(other.state_hash(), running.world.state_hash(), "{} from {from} at {step}", entry.name);
            }
        }
        for (from, other) in &others {
            if other.snapshot() != running.world.snapshot() { println!("{} {from}: bytes differ", entry.name); }
        }
    }
}
