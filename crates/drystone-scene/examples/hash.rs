//! The hash of the state at the end of a run, for targets without the command: `cargo xtask
//! targets` runs it on aarch64 and in WebAssembly.
//!
//! `hash SCENE STEPS [THREADS [LEVEL]]` writes the hash and the name of the SIMD level; LEVEL is
//! the best by default.

use std::env;
use std::error::Error;
use std::io::{Write, stdout};
use std::sync::Arc;

use drystone::threads::{Executor, SimdLevel};

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let (scene, steps, threads, level) = match words.as_slice() {
        [scene, steps] => (scene, steps, "1", None),
        [scene, steps, threads] => (scene, steps, *threads, None),
        [scene, steps, threads, level] => (scene, steps, *threads, Some(*level)),
        _ => return Err("usage: hash SCENE STEPS [THREADS [LEVEL]]".into()),
    };
    let steps: u32 = steps.parse().map_err(|_| format!("{steps}: no number of steps"))?;
    let threads: usize = threads.parse().map_err(|_| format!("{threads}: no number of threads"))?;
    let scene = drystone_scene::named(scene)?;
    let mut running = scene.build()?;
    if threads > 1 {
        running.world.set_executor(team(threads)?);
    }
    if let Some(level) = level {
        let known = SimdLevel::named(level).ok_or_else(|| unknown(level))?;
        running.world.set_simd_level(known);
    }
    for _ in 0..steps {
        running.step(scene.hz.recip())?;
    }
    let world = &running.world;
    writeln!(stdout(), "{:016x} {}", world.state_hash(), world.simd_level().name())?;
    Ok(())
}

#[cfg(not(target_family = "wasm"))]
fn team(threads: usize) -> Result<Arc<dyn Executor>, String> {
    Ok(Arc::new(drystone::threads::Team::with_threads(threads)))
}

/// Debian's C library for WebAssembly does not even name what starts a thread, so nothing may call
/// it.
#[cfg(target_family = "wasm")]
fn team(threads: usize) -> Result<Arc<dyn Executor>, String> {
    Err(format!("{threads} threads: WebAssembly has one here"))
}

fn unknown(level: &str) -> String {
    let names: Vec<&str> = SimdLevel::available().into_iter().map(SimdLevel::name).collect();
    format!("no level `{level}` here; there are {}", names.join(", "))
}
