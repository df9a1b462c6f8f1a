//! `cargo xtask attack`: searches for failures with worlds, files, snapshots and command lines made
//! from seeds.

use std::path::Path;
use std::process::Command;

use crate::{Outcome, WITHOUT_GRAPHICS, cargo, root, run_to_end, target};

/// An optimized profile with the checks of a debug build.
const PROFILE: &str = "checked";

/// Builds the search and the command, and runs it with these arguments.
pub fn run(words: &[&str]) -> Outcome {
    let build = [
        "build",
        "--profile",
        PROFILE,
        "--package",
        "drystone-attack",
        "--package",
        "drystone-app",
    ];
    run_to_end(cargo().args(build).args(WITHOUT_GRAPHICS))?;
    start(&target().join(PROFILE), words)
}

/// Runs a campaign of half a minute on two cores with the programs in this folder, which must
/// exist. Its size is a number of worlds, so that a slower machine finds the same failures.
pub fn short(programs: &Path) -> Outcome {
    start(programs, &["--worlds", "1000", "--seed", "2026"])
}

fn start(programs: &Path, words: &[&str]) -> Outcome {
    let mut command = Command::new(programs.join("drystone-attack"));
    command.current_dir(root()).args(words).arg("--root").arg(root());
    command.arg("--command").arg(programs.join("drystone"));
    command.arg("--out").arg(target().join("attack"));
    run_to_end(&mut command)
}
