//! `cargo xtask hunt`: see `docs/hunt.md`.

use std::path::Path;
use std::process::Command;

use crate::{Outcome, cargo, root, run_to_end, target};

/// Builds the search, and runs it with these words.
pub fn run(words: &[&str]) -> Outcome {
    run_to_end(cargo().args(["build", "--release", "--package", "drystone-attack"]))?;
    start(&target().join("release"), words)
}

/// Some of it, by the program that is built already, which is in this folder: always the same worlds.
pub fn short(programs: &Path) -> Outcome {
    start(programs, &["--worlds", WORLDS, "--seed", "2026"])
}

/// Worlds of the stage of `ci`, of all kinds of scenes in equal parts.
const WORLDS: &str = "320";

fn start(programs: &Path, words: &[&str]) -> Outcome {
    let mut command = Command::new(programs.join("drystone-attack"));
    command.current_dir(root()).arg("hunt").args(words).arg("--root").arg(root());
    command.arg("--out").arg(target().join("hunt"));
    run_to_end(&mut command)
}
