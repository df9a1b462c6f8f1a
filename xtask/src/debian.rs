//! Debian's Rust compiler with the source of its standard library. It builds for targets that
//! rustup may lack.

use std::path::Path;
use std::process::Command;

use crate::{Outcome, root, run_to_end};

const CARGO: &str = "/usr/bin/cargo";
const RUSTC: &str = "/usr/bin/rustc";

/// Variables that an outer cargo or the user may have set, and that must not reach the build.
const CLEANED: [&str; 6] = [
    "CARGO",
    "RUSTUP_TOOLCHAIN",
    "RUSTC_WRAPPER",
    "RUSTFLAGS",
    "CARGO_ENCODED_RUSTFLAGS",
    "RUSTDOC",
];

/// Whether Debian's compiler is installed, new enough, and has the source of its standard library.
pub fn compiler() -> Outcome {
    let version = Command::new(RUSTC).arg("--version").output();
    let version = version.map(|o| String::from_utf8_lossy(&o.stdout).into_owned());
    // "rustc 1.96.0 (…)", and its source in /usr/src/rustc-1.96.0.
    let number = version.ok().and_then(|v| v.split(' ').nth(1).map(str::to_owned));
    let number = number.ok_or_else(|| format!("no {RUSTC}"))?;
    let asked = asked_version()?;
    if minor(&number) < minor(&asked) {
        return Err(format!("{RUSTC} is {number}, {asked} is asked for"));
    }
    let source = format!("/usr/src/rustc-{number}/library/std");
    match [CARGO, &source].into_iter().find(|path| !Path::new(path).exists()) {
        Some(missing) => Err(format!("no {missing}")),
        None => Ok(()),
    }
}

/// The oldest compiler that builds the workspace.
fn asked_version() -> Result<String, String> {
    let manifest = root().join("Cargo.toml");
    let text = std::fs::read_to_string(&manifest).map_err(|e| format!("Cargo.toml: {e}"))?;
    let version = text.split("\nrust-version = \"").nth(1).and_then(|rest| rest.split('"').next());
    version.map(str::to_owned).ok_or_else(|| "Cargo.toml: no rust-version".to_owned())
}

/// The minor version in 1.x.
fn minor(version: &str) -> u32 {
    version.split('.').nth(1).and_then(|minor| minor.parse().ok()).unwrap_or(0)
}

/// Whether the program runs with these arguments.
pub fn program(name: &str, args: &[&str]) -> Outcome {
    let output = Command::new(name).args(args).output();
    output.map(drop).map_err(|_| format!("no {name}"))
}

/// The linker for WebAssembly.
pub fn wasm_linker() -> Outcome {
    program("rust-lld", &["-flavor", "wasm", "--version"])
}

/// A `cargo build` with Debian's compiler for a target, including its standard library, into a
/// separate folder.
pub fn cargo_build(target: &str, profile: &str, folder: &Path) -> Command {
    // The first cargo on the path may not be Debian's.
    let mut cargo = Command::new(CARGO);
    cargo.current_dir(root()).args(["build", "--quiet", "--locked", "--profile", profile]);
    // -Z builds the standard library, which the packages for this target lack.
    cargo.args(["--target", target, "-Zbuild-std=std,panic_abort", "--target-dir"]).arg(folder);
    for name in CLEANED {
        cargo.env_remove(name);
    }
    cargo.env("RUSTC", RUSTC).env("RUSTC_BOOTSTRAP", "1");
    cargo
}

/// Runs a script that installs the parts that `found` reports as missing, if any.
pub fn install(script: &str, args: &[&str], found: impl Fn() -> Outcome) -> Outcome {
    let Err(missing) = found() else { return Ok(()) };
    println!("   {missing}: {script} {}", args.join(" "));
    run_to_end(Command::new(root().join(script)).args(args))?;
    found().map_err(|missing| format!("{missing} after {script}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_compared_as_numbers() {
        assert!(minor("1.100.0") > minor("1.96.0") && minor("1.89") < minor("1.96.0"));
        assert!(minor(&asked_version().unwrap()) >= 89);
    }
}
