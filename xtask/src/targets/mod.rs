//! `cargo xtask targets`: the runs of golden.txt on machines that this one is not, to the same bits.

mod aarch64;
mod wasm;

use std::path::PathBuf;
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;

use crate::golden::{self, Golden};
use crate::{Outcome, debian, run_to_end, target};

/// A kind of machine that scenes are run for.
struct Target {
    /// As the user and scripts/target-packages.sh call it.
    name: &'static str,
    /// Names what is missing and in no package.
    given: fn() -> Outcome,
    /// Names the first thing that is missing of the packages.
    found: fn() -> Outcome,
    /// Builds the program; returns the ways to run it.
    build: fn() -> Result<Vec<Way>, String>,
}

const TARGETS: [Target; 2] = [aarch64::TARGET, wasm::TARGET];

/// A way to run the scenes on a target.
struct Way {
    /// The program, and what runs it.
    program: Vec<PathBuf>,
    /// The SIMD level, as [`drystone::threads::SimdLevel::name`] has it.
    level: &'static str,
    threads: u32,
}

/// Compares the hashes on the named targets, or on all.
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

/// The stage of `cargo xtask ci`: without the packages it is left out, since another Debian may not have them.
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

    /// The hash of each run; as many at once as there are cores for their threads.
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

/// The folder of all builds here: what they have in common is built once.
fn folder() -> PathBuf {
    target().join("targets")
}

/// Builds the program that says the hash of a run, with what the target wants in the environment; returns where it is.
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

    /// A program that answers with its scene and steps for a hash, at the level `neon`.
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
        assert!(run(&["mips"]).unwrap_err().contains("aarch64 and wasm"));
        assert!(check("mips").is_err());
    }
}
