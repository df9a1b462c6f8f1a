//! From source to the folder that a web server serves.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::folder;
use crate::{Outcome, root, run_to_end, target};

/// All files together, compressed as a web server sends them [bytes].
const MOST_BYTES: usize = 5_000_000;

const TRIPLE: &str = "wasm32-unknown-unknown";

/// Sees to it that the tools are there.
pub(super) fn prepare() -> Outcome {
    packages()?;
    bindgen().map(drop)
}

pub(super) fn run() -> Outcome {
    packages()?;
    let bindgen = bindgen()?;
    println!("   building for {TRIPLE}");
    let built = target().join("web-build");
    // The first cargo on the path may be another one than Debian's.
    let mut cargo = Command::new(DEBIAN_CARGO);
    cargo.current_dir(root()).args(["build", "--quiet", "--profile", "web", "--locked"]);
    cargo.args(["--package", "drystone-web", "--lib", "--target", TRIPLE]);
    cargo.args(["-Zbuild-std=std,panic_abort", "--target-dir"]).arg(&built);
    // Of those that a cargo above this one sets, none must reach it.
    for name in ["CARGO", "RUSTUP_TOOLCHAIN", "RUSTC_WRAPPER", "CARGO_ENCODED_RUSTFLAGS", "RUSTDOC"]
    {
        cargo.env_remove(name);
    }
    // -Z for the standard library, which is no part of the packages for this target.
    cargo.env("RUSTC", DEBIAN_RUSTC).env("RUSTC_BOOTSTRAP", "1");
    cargo.env("RUSTFLAGS", "-Ctarget-feature=+simd128");
    run_to_end(&mut cargo)?;

    let folder = folder();
    let _ = fs::remove_dir_all(&folder);
    let wasm = built.join(TRIPLE).join("web/drystone_web.wasm");
    let mut bind = Command::new(bindgen);
    bind.args([
        "--target",
        "web",
        "--no-typescript",
        "--remove-name-section",
        "--out-name",
        "drystone",
        "--out-dir",
    ]);
    run_to_end(bind.arg(&folder).arg(wasm))?;
    let page = root().join("crates/drystone-web/page");
    for entry in fs::read_dir(&page).map_err(|e| format!("{}: {e}", page.display()))?.flatten() {
        let to = folder.join(entry.file_name());
        fs::copy(entry.path(), &to).map_err(|e| format!("{}: {e}", to.display()))?;
    }
    weigh(&folder)
}

const DEBIAN_CARGO: &str = "/usr/bin/cargo";
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";

/// Whether Debian's compiler is there with the source of its standard library.
fn compiler() -> bool {
    let version = Command::new(DEBIAN_RUSTC).arg("--version").output();
    let version = version.map(|o| String::from_utf8_lossy(&o.stdout).into_owned());
    // "rustc 1.96.0 (…)", and its source in /usr/src/rustc-1.96.0.
    let number = version.ok().and_then(|v| v.split(' ').nth(1).map(str::to_owned));
    let source = number.map(|n| PathBuf::from(format!("/usr/src/rustc-{n}/library/std")));
    let linker = Command::new("rust-lld").arg("-flavor").arg("wasm").arg("--version").output();
    source.is_some_and(|s| s.exists()) && Path::new(DEBIAN_CARGO).exists() && linker.is_ok()
}

/// Installs Debian's packages where they are missing.
fn packages() -> Outcome {
    let browser = || Command::new(super::browser::PROGRAM).arg("--version").output().is_ok();
    if compiler() && browser() {
        return Ok(());
    }
    println!("   scripts/web-packages.sh");
    run_to_end(&mut Command::new(root().join("scripts/web-packages.sh")))?;
    if !compiler() {
        return Err("the packages hold no compiler for the web".to_owned());
    }
    if browser() { Ok(()) } else { Err("the packages hold no browser".to_owned()) }
}

/// The command wasm-bindgen in the version of the lock file; compiled once into the target folder.
fn bindgen() -> Result<PathBuf, String> {
    let lock = root().join("Cargo.lock");
    let text = fs::read_to_string(&lock).map_err(|e| format!("{}: {e}", lock.display()))?;
    let version = text.split("name = \"wasm-bindgen\"\nversion = \"").nth(1);
    let version = version.and_then(|rest| rest.split('"').next());
    let version = version.ok_or("Cargo.lock: no wasm-bindgen")?;
    let tools = target().join("web-tools");
    let program = tools.join("bin/wasm-bindgen");
    let found = Command::new(&program).arg("--version").output();
    if found.is_ok_and(|o| String::from_utf8_lossy(&o.stdout).contains(version)) {
        return Ok(program);
    }
    println!("   installing wasm-bindgen-cli {version}");
    let mut install = crate::cargo();
    install.args(["install", "--quiet", "wasm-bindgen-cli", "--version", version, "--debug"]);
    install.arg("--root").arg(&tools).arg("--target-dir").arg(tools.join("build"));
    run_to_end(&mut install)?;
    Ok(program)
}

/// Says how large the files are as a web server sends them, and fails if that is too much.
fn weigh(folder: &Path) -> Outcome {
    let mut total = 0;
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let zip =
            Command::new("gzip").args(["-9", "-c"]).arg(&path).stderr(Stdio::inherit()).output();
        let size = zip.map_err(|e| format!("gzip: {e}"))?.stdout.len();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        println!("   {name}: {} kB compressed", size.div_ceil(1000));
        total += size;
    }
    println!("   {}: {} kB compressed", folder.display(), total.div_ceil(1000));
    if total <= MOST_BYTES {
        Ok(())
    } else {
        Err(format!("the page has {total} bytes compressed, allowed are {MOST_BYTES}"))
    }
}
