//! The project's chores, run as `cargo xtask COMMAND`.

mod attack;
mod ci;
mod debian;
mod fuzz;
mod gallery;
mod golden;
mod graphics;
mod hunt;
mod instructions;
mod model;
mod roofline;
mod sanitize;
mod stability;
mod targets;
mod tidy;
mod web;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const USAGE: &str = "usage: cargo xtask COMMAND

  ci [STAGE…]                     everything a change must pass, cheapest first (or only the named stages)
  attack [OPTIONS]                search for what breaks: worlds, files, snapshots, command lines from seeds (a minute;
                                  --hours 9 for a night); docs/attack.md
  attack repeat SEED              run one of them again
  attack minimize SEED            shrink it, and write it as a test
  hunt [OPTIONS]                  search small worlds for motion that no physics has (a minute; --minutes N); docs/hunt.md
  hunt repeat SEED                run one of them again
  hunt minimize SEED              shrink it, and write it as a test
  tidy                            layers, circles of imports, stage order, owners, reference keys, doc paths, sizes
  owners                          write the tables of access of ARCHITECTURE.md from the code
  determinism                     300 steps of every scene by 1 to 4 threads and every SIMD level (minutes)
  golden [--release]              run the scenes of golden.txt and compare their hashes
  golden [--release] --bless WHY  write the new hashes, and old, new and WHY into docs/log
  targets [aarch64] [wasm]        the scenes of golden.txt on aarch64 in an emulator and in WebAssembly in node
  model                           the worker team under a model checker (some minutes)
  sanitize                        tests of threads and executors under AddressSanitizer (some minutes)
  instructions [--bless]          count the instructions of the runs of instructions.txt by callgrind
  fuzz [TARGET] [--seconds N]     libFuzzer on all that is read, a minute a target; what failed is kept in target/fuzz/failed
  gallery [SCENE…]                draw the pictures and films of docs/gallery, and write its page
  stability                       long runs of what must stand or fall, into docs/stability.md (a quarter of an hour)
  web [build|test [PART…]|serve [PORT]]
                                  build the viewer for browsers into target/web, and test it in one (many minutes at first)
  roofline                        bandwidth and arithmetic of this machine (run xtask with --release)";

/// Result of a command: nothing, or a message about the failure.
type Outcome = Result<(), String>;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        ["ci", stages @ ..] => ci::run(stages),
        ["attack", words @ ..] => attack::run(words),
        ["hunt", words @ ..] => hunt::run(words),
        ["tidy"] => tidy::run(),
        ["owners"] => tidy::write_owners(),
        ["determinism"] => determinism(),
        ["fuzz", words @ ..] => fuzz::run(words),
        ["gallery", names @ ..] => gallery::run(names),
        ["instructions"] => release_command().and_then(|built| instructions::run(false, &built)),
        ["instructions", "--bless"] => {
            release_command().and_then(|built| instructions::run(true, &built))
        }
        ["model"] => model::run(),
        ["sanitize"] => sanitize::run(),
        ["stability"] => stability::run(),
        ["targets", names @ ..] => targets::run(names),
        ["web", words @ ..] => web::run(words),
        ["roofline"] => {
            roofline::run();
            Ok(())
        }
        ["golden", options @ ..] => golden::Options::parse(options).and_then(|o| golden::run(&o)),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

/// The long form of the determinism test, too slow for every change.
fn determinism() -> Outcome {
    let test = "three_hundred_steps_of_every_scene_give_the_same_bits";
    run_to_end(
        cargo().args(["test", "--release", "--package", "drystone-scene", "--test", "it"]).args([
            "--",
            "--ignored",
            "--nocapture",
            test,
        ]),
    )
}

/// Cargo's target folder.
fn target() -> PathBuf {
    let set = std::env::var_os("CARGO_TARGET_DIR").filter(|folder| !folder.is_empty());
    set.map_or_else(|| root().join("target"), |folder| root().join(folder))
}

/// Builds the engine's command, optimized, and returns its path.
fn release_command() -> Result<PathBuf, String> {
    let build = ["build", "--quiet", "--release", "--package", "drystone-app"];
    run_to_end(cargo().args(build).args(WITHOUT_GRAPHICS))?;
    Ok(target().join("release/drystone"))
}

/// The repository's root. Determined at run time, because a target folder may serve two checkouts.
fn root() -> PathBuf {
    let manifest = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let mut root = manifest.unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")));
    root.pop();
    root
}

/// Measurements and hashes need no graphics; without it the build takes a fraction of the time.
const WITHOUT_GRAPHICS: &[&str] = &["--no-default-features"];

/// The cargo that runs this program, started in the root.
fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root());
    command
}

/// Runs a command to its end; an exit status other than 0 is an error with the command line.
fn run_to_end(command: &mut Command) -> Outcome {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{}: {status}", spelled(command))),
        Err(error) => Err(format!("{}: {error}", spelled(command))),
    }
}

/// Writes a file of the project; the old one stays until the new one is complete.
fn write_whole(path: &Path, text: &str) -> Outcome {
    let partial = path.with_extension("partial");
    std::fs::write(&partial, text)
        .and_then(|()| std::fs::rename(&partial, path))
        .map_err(|e| format!("{}: {e}", path.display()))
}

/// The command line as one would type it.
fn spelled(command: &Command) -> String {
    let program = command.get_program().to_string_lossy();
    let mut line = program.rsplit('/').next().unwrap_or(&program).to_owned();
    for arg in command.get_args() {
        line.push(' ');
        line.push_str(&arg.to_string_lossy());
    }
    line
}
