//! `cargo xtask fuzz`: libFuzzer on every format that drystone reads, with the stable compiler.
//!
//! The flags are the same that `cargo fuzz` passes to a nightly compiler. Inputs found by the
//! fuzzer are kept in `target/fuzz`, beside inputs that made a target fail. The small handwritten
//! inputs in `fuzz/corpus` are read and not changed.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::{Outcome, cargo, root, run_to_end, target};

/// Counts edges and records the operands of comparisons.
const COVERAGE: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                        -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
                        -Cllvm-args=-sanitizer-coverage-pc-table \
                        -Cllvm-args=-sanitizer-coverage-trace-compares";

/// The targets, and the maximum input length of each [bytes].
const TARGETS: [(&str, u32); 10] = [
    ("gltf", 8192),
    ("image", 4096),
    ("mjcf", 4096),
    ("obj", 4096),
    ("own", 8192),
    ("rigid_ipc", 4096),
    ("saved_run", 65536),
    ("stl", 4096),
    ("urdf", 4096),
    ("world", 65536),
];

/// Limits for an input: time [s] and memory [MB]; exceeding one is a failure.
const SLOWEST: u32 = 20;
const LARGEST: u32 = 2048;

/// Runs the named target, or all targets one after the other, for `seconds` each.
pub fn run(words: &[&str]) -> Outcome {
    let (only, seconds) = parse(words)?;
    if let Some(why) = missing() {
        println!("SKIPPED: {why}");
        return Ok(());
    }
    let folder = target().join("fuzz");
    let mut build = cargo();
    build
        .args(["build", "--release", "--manifest-path"])
        .arg(root().join("fuzz/Cargo.toml"))
        .arg("--target-dir")
        .arg(&folder)
        // With an explicit target, build scripts and macros are built without coverage.
        .args(["--target", &host()?])
        .env("RUSTFLAGS", COVERAGE);
    run_to_end(&mut build)?;
    let programs = folder.join(host()?).join("release");
    for (name, longest) in TARGETS {
        if only.is_none_or(|only| only == name) {
            fuzz(name, longest, seconds, &programs, &folder)?;
        }
    }
    Ok(())
}

fn parse<'a>(words: &[&'a str]) -> Result<(Option<&'a str>, u32), String> {
    let (mut only, mut seconds) = (None, 60);
    let mut words = words.iter();
    while let Some(word) = words.next() {
        if *word == "--seconds" {
            let number = words.next().and_then(|n| n.parse().ok()).filter(|n| *n > 0);
            seconds = number.ok_or("--seconds wants a number of at least 1")?;
        } else if TARGETS.iter().any(|(name, _)| name == word) {
            only = Some(*word);
        } else {
            let known: Vec<&str> = TARGETS.iter().map(|(name, _)| *name).collect();
            return Err(format!("no target `{word}`; there are {}", known.join(", ")));
        }
    }
    Ok((only, seconds))
}

/// The reason why this machine cannot fuzz, if any.
fn missing() -> Option<String> {
    if !cfg!(target_os = "linux") {
        return Some("the flags were tried on Linux alone".to_owned());
    }
    let compiler = std::env::var("CXX").unwrap_or_else(|_| "c++".to_owned());
    let found = Command::new(&compiler)
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    (!found).then(|| format!("libFuzzer is built by a C++ compiler, and `{compiler}` is none"))
}

/// The triple of this machine.
fn host() -> Result<String, String> {
    let output = Command::new("rustc").arg("-vV").output().map_err(|e| format!("rustc: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = text.lines().find_map(|line| line.strip_prefix("host: "));
    line.map(str::to_owned).ok_or_else(|| "rustc -vV names no host".to_owned())
}

fn fuzz(name: &str, longest: u32, seconds: u32, programs: &Path, folder: &Path) -> Outcome {
    println!("── {name}");
    let [found, failed, seeds] =
        ["corpus", "failed", "seeds"].map(|kind| folder.join(kind).join(name));
    for folder in [&found, &failed, &seeds] {
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    let mut command = Command::new(programs.join(name));
    command
        .arg(format!("-max_len={longest}"))
        .arg(format!("-max_total_time={seconds}"))
        .arg(format!("-timeout={SLOWEST}"))
        .arg(format!("-rss_limit_mb={LARGEST}"))
        .arg(format!("-artifact_prefix={}/", failed.display()))
        .args(["-print_final_stats=1", "-verbosity=0"])
        .arg(&found);
    let words = root().join("fuzz/dictionaries").join(name).with_extension("txt");
    if words.is_file() {
        command.arg(format!("-dict={}", words.display()));
    }
    let by_hand = root().join("fuzz/corpus").join(name);
    command.args([by_hand].iter().filter(|folder| folder.is_dir()));
    // Seeds that only a program can make are written to this folder before libFuzzer reads it.
    command.arg(&seeds).env("DRYSTONE_FUZZ_SEEDS", &seeds);
    run_to_end(&mut command).map_err(|why| format!("{why}\nwhat failed is in {}", failed.display()))
}
