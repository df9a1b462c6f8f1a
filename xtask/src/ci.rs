//! `cargo xtask ci`: everything a change must pass, cheapest first; the first failure ends it.

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Instant;

use crate::tidy::is_reference_key;
use crate::{
    Outcome, WITHOUT_GRAPHICS, attack, cargo, golden, graphics, hunt, instructions, root,
    run_to_end, target, targets, tidy, web,
};

type Stage = (&'static str, fn() -> Outcome);

const STAGES: &[Stage] = &[
    ("fmt", || run_to_end(cargo().args(["fmt", "--all", "--check"]))),
    ("tidy", tidy::run),
    ("clippy", clippy),
    ("features", features),
    ("doc", doc),
    ("graphics", graphics::prepare),
    ("test", || run_to_end(&mut tests(false))),
    ("test-release", || run_to_end(&mut tests(true))),
    ("examples", examples),
    ("validate", validate),
    ("attack", || attack::short(&programs(true)?)),
    ("hunt", || hunt::short(&programs(true)?)),
    ("golden", || golden_hashes(false)),
    ("golden-release", || golden_hashes(true)),
    ("aarch64", || on_request("aarch64")),
    ("wasm", || on_request("wasm")),
    ("instructions", || instructions::run(false, &programs(true)?.join("drystone"))),
    ("web", web::check),
    ("python", python),
];

/// Runs the named stages, or all stages, in the order of the list.
pub fn run(only: &[&str]) -> Outcome {
    if let Some(unknown) = only.iter().find(|name| STAGES.iter().all(|(known, _)| known != *name)) {
        let known: Vec<&str> = STAGES.iter().map(|(name, _)| *name).collect();
        return Err(format!("no stage `{unknown}`; there are {}", known.join(", ")));
    }
    let start = Instant::now();
    for (name, stage) in STAGES.iter().filter(|(name, _)| only.is_empty() || only.contains(name)) {
        println!("── {name}");
        let stage_start = Instant::now();
        let outcome = stage();
        let seconds = stage_start.elapsed().as_secs_f64();
        let verdict = if outcome.is_ok() { "ok" } else { "FAILED" };
        println!("── {name}: {verdict}, {seconds:.1} s");
        outcome.map_err(|why| format!("{why}\nagain: cargo xtask ci {name}"))?;
    }
    println!("── all passed, {:.1} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// Whether a stage that is off by default was requested, by its name or by a variable of the
/// environment.
pub fn wanted(name: &str, variable: &str) -> bool {
    std::env::args().any(|word| word == name) || std::env::var_os(variable).is_some()
}

/// The Python package needs an interpreter to be compiled, so it has a stage of its own.
const WITHOUT_PYTHON: [&str; 2] = ["--exclude", "drystone-python"];

fn clippy() -> Outcome {
    let mut command = cargo();
    command.args(["clippy", "--quiet", "--workspace"]).args(WITHOUT_PYTHON);
    run_to_end(command.args(["--all-targets", "--", "-D", "warnings"]))
}

/// Checks the engine alone, with fewer and with more features than the programs here use. Its tests
/// and examples run without any.
fn features() -> Outcome {
    for (features, targets) in
        [("", "--all-targets"), ("serde", "--lib"), ("snapshot,glam,mint", "--lib")]
    {
        let mut command = cargo();
        command.args(["clippy", "--quiet", "--package", "drystone", targets]);
        command.args(["--no-default-features", "--features", features, "--", "-D", "warnings"]);
        run_to_end(&mut command)?;
    }
    Ok(())
}

/// Units and frames that stand alone in brackets, as `[m]`; rustdoc mistakes them for links.
const UNITS: [&str; 16] = [
    "m", "m²", "m³", "s", "ms", "kg", "N", "J", "W", "Pa", "rad", "Hz", "px", "world", "body",
    "local",
];

/// Documents libraries only: the command's binary has the engine's name, and the two pages would
/// collide.
fn doc() -> Outcome {
    let mut command = cargo();
    command.args(["doc", "--quiet", "--workspace"]).args(WITHOUT_PYTHON);
    command.args(["--no-deps", "--lib"]);
    let flags = "-D warnings --force-warn rustdoc::broken_intra_doc_links";
    let output = command.env("RUSTDOCFLAGS", flags).stdout(Stdio::inherit()).output();
    let output = output.map_err(|error| format!("cargo doc: {error}"))?;
    let messages = String::from_utf8_lossy(&output.stderr);
    let real: Vec<&str> =
        messages.split("\n\n").filter(|message| !is_unit_or_key(message)).collect();
    let broken = real.iter().any(|message| message.contains(UNRESOLVED));
    if output.status.success() && !broken { Ok(()) } else { Err(real.join("\n\n")) }
}

const UNRESOLVED: &str = "unresolved link to `";

/// Whether rustdoc's message is about a unit or a reference key that it mistook for a link.
fn is_unit_or_key(message: &str) -> bool {
    let name = message.split(UNRESOLVED).nth(1).and_then(|rest| rest.split('`').next());
    name.is_some_and(|name| UNITS.contains(&name) || is_reference_key(name))
}

/// Runs all tests, in debug or in release. Release runs check hashes again. They leave out
/// pictures, which have no hash: optimizing the graphics stack would take longer than all tests.
/// They leave out the plugin for Bevy, whose own tests compare hashes in debug.
fn tests(release: bool) -> Command {
    let mut command = cargo();
    command.args(["test", "--quiet", "--workspace"]).args(WITHOUT_PYTHON);
    if release {
        command.arg("--release").args(WITHOUT_GRAPHICS);
        command.args(["--exclude", "drystone-render", "--exclude", "drystone-view"]);
        command.args(["--exclude", "bevy_drystone"]);
    }
    command
}

/// The folder of the programs that the tests build: the command and the examples. After the tests
/// this builds nothing. Any other selection of packages would enable other features and rebuild
/// much.
fn programs(release: bool) -> Result<PathBuf, String> {
    run_to_end(tests(release).arg("--no-run"))?;
    Ok(target().join(if release { "release" } else { "debug" }))
}

/// Lints the Python package, builds its wheel and runs its checks. The script reports `SKIPPED`
/// without pip or a network.
fn python() -> Outcome {
    if wanted("python", "DRYSTONE_CI_PYTHON") {
        let mut command = cargo();
        command.args(["clippy", "--quiet", "--package", "drystone-python", "--all-targets"]);
        run_to_end(command.args(["--", "-D", "warnings"]))?;
        return run_to_end(&mut Command::new(root().join("bindings/python/ci.sh")));
    }
    println!(
        "   SKIPPED: the Python bindings; `cargo xtask ci python` or DRYSTONE_CI_PYTHON=1 runs them"
    );
    Ok(())
}

fn golden_hashes(release: bool) -> Outcome {
    let command = Some(programs(release)?.join("drystone"));
    golden::run(&golden::Options { release, bless: None, command })
}

/// Compares the golden hashes on another kind of machine. Runs only on request: it builds the
/// engine once or twice more, and an emulator takes half an hour on a busy machine.
fn on_request(target: &str) -> Outcome {
    if wanted(target, "DRYSTONE_CI_TARGETS") {
        return targets::check(target);
    }
    println!(
        "   SKIPPED: the golden hashes on {target}; `cargo xtask ci {target}` or DRYSTONE_CI_TARGETS=1 runs it"
    );
    Ok(())
}

/// Runs the short simulations with a known answer. None may be worse than in the list of known
/// failures.
fn validate() -> Outcome {
    let mut command = Command::new(programs(true)?.join("drystone"));
    command.current_dir(root()).args(["validate", "--short", "--failures"]);
    let list = ["--known", "crates/drystone-validate/known-failures.txt"];
    run_to_end(command.args(list))
}

/// Runs every file in the engine's `examples/`, and in those of the plugin for Bevy, which has no
/// release build here.
fn examples() -> Outcome {
    run_examples("crates/drystone/examples", true)?;
    run_examples("bindings/bevy/examples", false)
}

fn run_examples(folder: &str, release: bool) -> Outcome {
    let folder = root().join(folder);
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut names: Vec<String> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect();
    names.sort();
    let built = programs(release)?.join("examples");
    for name in &names {
        println!("   {name}");
        run_to_end(Command::new(built.join(name)).current_dir(root()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_keys_are_no_broken_links() {
        let message = |name: &str| format!("warning: {UNRESOLVED}{name}`\n --> a.rs:1:2\n  |");
        assert!(is_unit_or_key(&message("m")) && is_unit_or_key(&message("Catto11")));
        assert!(!is_unit_or_key(&message("Pose::gone")) && !is_unit_or_key("error: other"));
    }
}
