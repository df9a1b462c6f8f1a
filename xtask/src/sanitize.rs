//! `cargo xtask sanitize`: tests that use threads, under AddressSanitizer.
//!
//! ThreadSanitizer is left out: it needs a standard library built with it, and reports false
//! positives for code it does not see in ours.

use std::process::Command;

use crate::{Outcome, cargo, run_to_end, target};

/// The runs: arguments of `cargo test`, and the names of the tests.
const RUNS: [(&[&str], &[&str]); 2] = [
    (&["--lib"], &["base::", "state::contacts", "geometry::rtree"]),
    (&["--test", "it"], &["contract_executor", "scenario_threads", "scenario_groups"]),
];

/// Builds and runs the tests; reports it if the compiler has no sanitizer.
pub fn run() -> Outcome {
    let host = host()?;
    if let Err(reason) = has_sanitizer(&host) {
        println!("SKIPPED: AddressSanitizer: {reason}");
        return Ok(());
    }
    for (which, tests) in RUNS {
        let mut command = cargo();
        command.args(["test", "--release", "--package", "drystone", "--target", &host]);
        command.arg("--target-dir").arg(target().join("asan")).args(which).arg("--").args(tests);
        run_to_end(with_sanitizer(&mut command).env("RUSTFLAGS", SANITIZER))?;
    }
    Ok(())
}

const SANITIZER: &str = "-Zsanitizer=address";

/// Enables a flag of unstable features, which a stable compiler accepts with this variable. Leak
/// detection is off, because a team leaks the panic payload of the second of two tasks.
fn with_sanitizer(command: &mut Command) -> &mut Command {
    command.env("RUSTC_BOOTSTRAP", "1").env("ASAN_OPTIONS", "detect_leaks=0")
}

fn rustc() -> Command {
    Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
}

/// The machine's target triple.
fn host() -> Result<String, String> {
    let output = rustc().arg("-vV").output().map_err(|error| format!("rustc: {error}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "rustc does not say for what machine it is".into())
}

/// Whether an empty program can be built with the sanitizer.
fn has_sanitizer(host: &str) -> Outcome {
    let folder = target().join("asan");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let source = folder.join("probe.rs");
    std::fs::write(&source, "fn main() {}\n").map_err(|error| error.to_string())?;
    let mut command = rustc();
    command.args([SANITIZER, "--target", host, "-o"]).arg(folder.join("probe")).arg(&source);
    let output = with_sanitizer(&mut command).output().map_err(|error| error.to_string())?;
    if output.status.success() {
        return Ok(());
    }
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    Err(text.lines().next().unwrap_or("the compiler cannot build with it").to_owned())
}
