//! `cargo xtask targets`: the runs of golden.txt on other kinds of machines, which must give the
//! same bits.

mod aarch64;
mod wasm;

use std::path::PathBuf;
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;

use crate::golden::{self, Golden};
use crate::{Outcome, debian, run_to_end, target};

/// A kind of machine to run scenes on.
struct Target {
    /// Its name for the user and for scripts/target-packages.sh.
    name: &'static str,
    /// Reports missing tools that are in no package.
    given: fn() -> Outcome,
    /// Reports the first missing package.
    found: fn() -> Outcome,
    /// Builds the program; returns the configurations to run it in.
    build: fn() -> Result<Vec<Way>, String>,
}

const TARGETS: [Target; 2] = [aarch64::TARGET, wasm::TARGET];

/// A configuration to run the scenes in on a target.
struct Way {
    /// The program, with the emulator that runs it.
    program: Vec<PathBuf>,
    /// The SIMD level's name, as in [`drystone::threads::SimdLevel::name`].
    level: &'static str,
    threads: u32,
}

/// Compares the hashes on the named targets, or on all targets.
pub fn run(words: &[&str]) -> Outcome {
    let unknown = words.iter().find(|word| TARGETS.iter().all(|target| target.name != **word));
    if let Some(unknown) = unknown {
        return Err(format!("cargo xtask targets {unknown}: expected aarch64 or wasm"));
    }
    for target in TARGETS.iter().filter(|t| words.is_empty() || words.contains(&t.name)) {
        prepare(target)?;
        compare(target)?;
    }
    Ok(())
}

/// The stage of `cargo xtask ci`. It is skipped without the packages, which another Debian may
/// lack.
pub fn check(name: &str) -> Outcome {
    let target = TARGETS.iter().find(|target| target.name == name);
    let target = target.ok_or_else(|| format!("no target `{name}`"))?;
    if let Err(why) = prepare(target) {
        println!(
            "   SKIPPED: the golden hashes on {name}; what builds and runs them cannot be had: {why}"
        );
        return Ok(());
    }
    compare(target)
}

fn prepare(target: &Target) -> Outcome {
    (target.given)()?;
    debian::install("scripts/target-packages.sh", &[target.name], target.found)
}

fn compare(target: &Target) -> Outcome {
    let goldens = golden::listed()?;
    println!("   building for {}", target.name);
    let start = Instant::now();
    let ways = (target.build)()?;
    println!("   built, {:.0} s", start.elapsed().as_secs_f64());
    let mut differ = Vec::new();
    for way in &ways {
        let start = Instant::now();
        let title = way.title(target);
        let found = way.hashes(&goldens)?;
        let changes = golden::differing(&goldens, &found);
        let same = goldens.len() - changes.len();
        let seconds = start.elapsed().as_secs_f64();
        println!("   {title}: {same} of {} the same, {seconds:.0} s", goldens.len());
        differ.extend(changes.iter().map(|(golden, hash)| {
            format!("  {}: {hash} on {title}, golden.txt has {}", golden.scene, golden.hash)
        }));
    }
    if differ.is_empty() {
        return Ok(());
    }
    Err(format!("hashes differ from golden.txt:\n{}", differ.join("\n")))
}

impl Way {
    fn title(&self, target: &Target) -> String {
        let threads = match self.threads {
            1 => "1 thread".to_owned(),
            n => format!("{n} threads"),
        };
        format!("{}, {}, {threads}", target.name, self.level)
    }

    /// The hash of each run; runs are parallel as far as the cores suffice for their threads.
    fn hashes(&self, goldens: &[Golden]) -> Result<Vec<String>, String> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let workers = (cores / self.threads as usize).max(1);
        let left = Mutex::new(goldens.iter().enumerate());
        let work = || -> Result<Vec<(usize, String)>, String> {
            let mut found = Vec::new();
            while let Some((i, golden)) = next(&left) {
                found.push((i, self.hash(golden)?));
            }
            Ok(found)
        };
        let mut found = std::thread::scope(|scope| {
            let running: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
            let ended = running.into_iter().map(|worker| worker.join());
            let parts = ended.map(|part| part.unwrap_or_else(|_| Err("a worker panicked".into())));
            parts.collect::<Result<Vec<_>, String>>()
        })?
        .concat();
        found.sort();
        Ok(found.into_iter().map(|(_, hash)| hash).collect())
    }

    fn hash(&self, golden: &Golden) -> Result<String, String> {
        let (runner, rest) = self.program.split_first().ok_or("no program")?;
        let mut command = Command::new(runner);
        command.args(rest).args([&golden.scene, &golden.steps.to_string()]);
        command.args([&self.threads.to_string(), self.level]);
        let output = command.output().map_err(|e| format!("{}: {e}", runner.display()))?;
        let said = String::from_utf8_lossy(&output.stdout);
        let words: Vec<&str> = said.split_whitespace().collect();
        match words.as_slice() {
            [hash, level] if output.status.success() && *level == self.level => {
                Ok((*hash).to_owned())
            }
            _ => {
                let errors = String::from_utf8_lossy(&output.stderr);
                Err(format!("{}: {}\n{said}{errors}", crate::spelled(&command), output.status))
            }
        }
    }
}

fn next<T>(left: &Mutex<impl Iterator<Item = T>>) -> Option<T> {
    left.lock().ok()?.next()
}

/// The folder of all these builds, so that common parts are built once.
fn folder() -> PathBuf {
    target().join("targets")
}

/// Builds the program that prints the hash of a run, with the target's environment variables;
/// returns its path.
fn build_program(triple: &str, wanted: [&str; 2]) -> Result<PathBuf, String> {
    let mut cargo = debian::cargo_build(triple, "targets", &folder());
    cargo.args(["--package", "drystone-scene", "--example", "hash"]);
    let [variable, value] = wanted;
    run_to_end(cargo.env(variable, value))?;
    Ok(folder().join(triple).join("targets/examples/hash"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A program that prints a result for a scene and a number of steps, at the level `neon`.
    fn way(level: &'static str, script: &str) -> Way {
        Way { program: vec!["sh".into(), "-c".into(), script.into()], level, threads: 1 }
    }

    fn goldens(count: u32) -> Vec<Golden> {
        let golden = |steps| Golden { scene: "wall".into(), steps, hash: format!("wall-{steps}") };
        (0..count).map(golden).collect()
    }

    #[test]
    fn hashes_keep_the_order_of_the_list_whoever_is_done_first() {
        let goldens = goldens(20);
        let found = way("neon", "echo $0-$1 neon").hashes(&goldens).unwrap();
        assert_eq!(golden::differing(&goldens, &found), []);
    }

    #[test]
    fn a_run_at_another_level_or_without_a_hash_is_no_result() {
        let message = way("neon", "echo $0-$1 scalar").hashes(&goldens(1)).unwrap_err();
        assert!(
            message.contains("wall 0 1 neon") && message.contains("wall-0 scalar"),
            "{message}"
        );
        let message = way("neon", "echo hash neon; echo why >&2; exit 1").hashes(&goldens(1));
        assert!(message.unwrap_err().ends_with("why\n"));
    }

    #[test]
    fn other_targets_are_refused() {
        assert!(run(&["mips"]).unwrap_err().contains("aarch64 or wasm"));
        assert!(check("mips").is_err());
    }
}
