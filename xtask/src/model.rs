//! `cargo xtask model`: the worker team's own code under a model checker (shuttle), which tries thousands of schedules.

use crate::{Outcome, cargo, run_to_end, target};

/// Runs the tests of `base/threads/team/model.rs`, built with the model's threads and locks in place of the system's.
pub fn run() -> Outcome {
    let mut command = cargo();
    command.args(["test", "--package", "drystone", "--lib", "--target-dir"]);
    command.arg(target().join("model")).args(["base::threads::team::model", "--", "--nocapture"]);
    // In Cargo.toml the checker is a dependency under this cfg only.
    run_to_end(command.env("RUSTFLAGS", "--cfg drystone_model"))
}
