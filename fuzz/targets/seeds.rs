//! Seeds that cannot be written by hand, generated for the current format: small worlds, and a run.

use std::path::PathBuf;
use std::{env, fs};

use drystone_scene::Running;

/// The folder for the seeds, if set: libFuzzer reads it after this call.
pub fn folder() -> Option<PathBuf> {
    env::var_os("DRYSTONE_FUZZ_SEEDS").map(PathBuf::from)
}

/// A scene of the catalog after half a second.
pub fn running(name: &str) -> Running {
    let scene = drystone_scene::named(name).expect("it is in the catalog");
    let mut running = scene.build().expect("scenes of the catalog can be built");
    for _ in 0..30 {
        running.before_step(1.0 / 60.0).expect("scripts of the catalog do what can be done");
        running.world.step(1.0 / 60.0);
        running.after_step();
    }
    running
}

/// Writes a seed.
pub fn write(folder: &PathBuf, name: &str, bytes: &[u8]) {
    let name = name.replace([':', '='], "_");
    fs::write(folder.join(name), bytes).expect("the folder was made for it");
}
