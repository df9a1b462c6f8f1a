//! WebAssembly, as in browsers, run in node: with SIMD, and without.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::{Target, Way, build_program, folder};
use crate::{Outcome, debian, root};

const TRIPLE: &str = "wasm32-wasip1";
/// Debian's C library for WebAssembly.
const LIBRARY: &str = "/usr/lib/wasm32-wasi";
/// The first version of node that has `node:wasi` without a flag.
const NODE: u32 = 20;

pub(super) const TARGET: Target = Target { name: "wasm", given: node, found, build };

/// Checks the version of node; Debian 12 has an older one.
fn node() -> Outcome {
    let output = Command::new("node").arg("--version").output();
    let version = output.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned());
    let version = version.map_err(|_| format!("no node, {NODE} or newer is needed"))?;
    // "v20.20.2"
    let major = version.trim_start_matches('v').split('.').next().and_then(|n| n.parse().ok());
    if major.is_some_and(|n: u32| n >= NODE) {
        return Ok(());
    }
    Err(format!("node is {version}, {NODE} or newer is needed"))
}

fn found() -> Outcome {
    debian::compiler()?;
    debian::wasm_linker()?;
    let start = Path::new(LIBRARY).join("crt1-command.o");
    if start.exists() { Ok(()) } else { Err(format!("no {}", start.display())) }
}

/// Makes two builds, because a module's SIMD instructions are fixed at build time.
fn build() -> Result<Vec<Way>, String> {
    let simd = way("simd128", "-Ctarget-feature=+simd128")?;
    Ok(vec![simd, way("scalar", "-Ctarget-feature=-simd128")?])
}

fn way(level: &'static str, features: &str) -> Result<Way, String> {
    let start = format!("-Clink-arg={LIBRARY}/crt1-command.o");
    // rustup's compiler includes the C library, Debian's does not.
    let flags = format!("{features} -Clink-self-contained=no {start} -Lnative={LIBRARY}");
    let program = build_program(TRIPLE, ["RUSTFLAGS", &flags])?.with_extension("wasm");
    // The next build has the same name.
    let kept = folder().join(format!("hash-{level}.wasm"));
    fs::copy(&program, &kept).map_err(|e| format!("{}: {e}", kept.display()))?;
    let run = root().join("xtask/src/targets/run.mjs");
    let program = vec!["node".into(), "--no-warnings".into(), run, kept];
    Ok(Way { program, level, threads: 1 })
}
