//! `cargo xtask hunt`: see `docs/hunt.md`.

use std::path::Path;
use std::process::Command;

use crate::{Outcome, cargo, root, run_to_end, target};

/// Builds the search, and runs it with these arguments.
pub fn run(words: &[&str]) -> Outcome {
    run_to_end(cargo().args(["build", "--release", "--package", "drystone-attack"]))?;
    start(&target().join("release"), words)
}

/// Runs a short search with the program in this folder, which must exist; the worlds are always the
/// same.
pub fn short(programs: &Path) -> Outcome {
    start(programs, &["--worlds", WORLDS, "--seed", "2026"])
}

/// Number of worlds in the stage of `ci`, distributed evenly over the kinds of scenes.
const WORLDS: &str = "320";

fn start(programs: &Path, words: &[&str]) -> Outcome {
    let mut command = Command::new(programs.join("drystone-attack"));
    command.current_dir(root()).arg("hunt").args(words).arg("--root").arg(root());
    command.arg("--out").arg(target().join("hunt"));
    run_to_end(&mut command)
}
