//! `cargo xtask model`: runs the worker team's own code under a model checker (shuttle), which
//! tries thousands of schedules.

use crate::{Outcome, cargo, run_to_end, target};

/// Runs the tests of `base/threads/team/model.rs`, built with the model's threads and locks instead
/// of the system's.
pub fn run() -> Outcome {
    let mut command = cargo();
    command.args(["test", "--package", "drystone", "--lib", "--target-dir"]);
    command.arg(target().join("model")).args(["base::threads::team::model", "--", "--nocapture"]);
    // Cargo.toml has the checker as a dependency under this cfg only.
    run_to_end(command.env("RUSTFLAGS", "--cfg drystone_model"))
}
