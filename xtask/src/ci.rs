//! `cargo xtask ci`: everything a change must pass, cheapest first; the first failure ends it.

use std::process::Stdio;
use std::time::Instant;

use crate::tidy::is_reference_key;
use crate::{
    Outcome, WITHOUT_GRAPHICS, cargo, golden, graphics, instructions, root, run_to_end, tidy, web,
};

type Stage = (&'static str, fn() -> Outcome);

const STAGES: &[Stage] = &[
    ("fmt", || run_to_end(cargo().args(["fmt", "--all", "--check"]))),
    ("tidy", tidy::run),
    ("clippy", clippy),
    ("doc", doc),
    ("graphics", graphics::prepare),
    ("test", || run_to_end(cargo().args(["test", "--quiet", "--workspace"]))),
    ("test-release", test_release),
    ("examples", examples),
    ("validate", validate),
    ("golden", || golden::run(&golden::Options { release: false, bless: None })),
    ("golden-release", || golden::run(&golden::Options { release: true, bless: None })),
    ("instructions", || instructions::run(false)),
    ("web", web::check),
];

/// Runs the named stages, or all, in the order of the list.
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

fn clippy() -> Outcome {
    run_to_end(cargo().args([
        "clippy",
        "--quiet",
        "--workspace",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ]))
}

/// Units and frames that stand alone in brackets, as `[m]`; rustdoc takes them for links.
const UNITS: [&str; 16] = [
    "m", "m²", "m³", "s", "ms", "kg", "N", "J", "W", "Pa", "rad", "Hz", "px", "world", "body",
    "local",
];

/// Libraries only: the command's binary has the engine's name, and the two pages would collide.
fn doc() -> Outcome {
    let mut command = cargo();
    command.args(["doc", "--quiet", "--workspace", "--no-deps", "--lib"]);
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

/// Whether rustdoc's message is about a unit or a reference key that it took for a link.
fn is_unit_or_key(message: &str) -> bool {
    let name = message.split(UNRESOLVED).nth(1).and_then(|rest| rest.split('`').next());
    name.is_some_and(|name| UNITS.contains(&name) || is_reference_key(name))
}

/// Once more optimized, for the hashes: pictures have none, and to optimize the graphics stack would take longer
/// than all tests.
fn test_release() -> Outcome {
    let mut command = cargo();
    command.args(["test", "--quiet", "--workspace", "--release"]).args(WITHOUT_GRAPHICS);
    run_to_end(command.args(["--exclude", "drystone-render", "--exclude", "drystone-view"]))
}

/// The short simulations with a known answer: none may be worse than what its list of known failures says.
fn validate() -> Outcome {
    let mut command = cargo();
    command.args(["run", "--quiet", "--release", "--package", "drystone-app"]);
    command.args(WITHOUT_GRAPHICS).args(["--", "validate", "--short", "--failures"]);
    let list = ["--known", "crates/drystone-validate/known-failures.txt"];
    run_to_end(command.args(list))
}

/// Runs every file in the engine's `examples/`.
fn examples() -> Outcome {
    let folder = root().join("crates/drystone/examples");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut names: Vec<String> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect();
    names.sort();
    for name in &names {
        println!("   {name}");
        let run = ["run", "--quiet", "--release", "--package", "drystone", "--example"];
        run_to_end(cargo().args(run).arg(name))?;
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
