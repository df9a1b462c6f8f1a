//! `cargo xtask attack`: a search for what breaks, by worlds, files, snapshots and command lines made from seeds.

use std::path::Path;
use std::process::Command;

use crate::{Outcome, WITHOUT_GRAPHICS, cargo, root, run_to_end, target};

/// The profile with the checks of a debug build that an optimized one leaves out.
const PROFILE: &str = "checked";

/// Builds the search and the command, and runs it with these words.
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

/// A campaign of half a minute on two cores, by the programs in this folder, which are built already. It is counted, so that a slower
/// machine finds the same.
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
