//! Builds the folder that a web server serves.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::folder;
use crate::{Outcome, debian, root, run_to_end, target};

/// Maximum size of all files together, compressed as a web server sends them [bytes].
const MOST_BYTES: usize = 5_000_000;

const TRIPLE: &str = "wasm32-unknown-unknown";

/// Installs the required tools.
pub(super) fn prepare() -> Outcome {
    packages()?;
    bindgen().map(drop)
}

pub(super) fn run() -> Outcome {
    packages()?;
    let bindgen = bindgen()?;
    println!("   building for {TRIPLE}");
    let built = target().join("web-build");
    let mut cargo = debian::cargo_build(TRIPLE, "web", &built);
    cargo.args(["--package", "drystone-web", "--lib"]);
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

/// Installs missing packages of Debian.
fn packages() -> Outcome {
    debian::install("scripts/web-packages.sh", &[], || {
        debian::compiler()?;
        debian::wasm_linker()?;
        debian::program(super::browser::PROGRAM, &["--version"])
    })
}

/// The command wasm-bindgen in the version of the lock file, compiled once into the target folder.
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

/// Prints the compressed sizes of the files, and fails if they are too large.
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
        Err(format!("the page has {total} bytes compressed, the maximum is {MOST_BYTES}"))
    }
}
