//! The programs that do the runs: `drystone` as its users build it, and the peers in their fastest
//! builds.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use drystone_bench::Row;
use drystone_validate::Table;
use serde_json::Value;

use crate::cli::{Engine, Validate};

/// Parameters of one run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run<'a> {
    /// The scene.
    pub(crate) scene: &'a str,
    /// Threads.
    pub(crate) threads: u16,
    /// Steps.
    pub(crate) steps: u64,
}

/// Paths of the built programs.
#[derive(Debug, Default)]
pub(crate) struct Workers {
    own: Option<PathBuf>,
    peers: Option<PathBuf>,
}

/// The folder `bench/` of the repository.
pub(crate) fn bench_folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The root of the repository.
pub(crate) fn root() -> &'static Path {
    bench_folder().parent().unwrap_or(bench_folder())
}

impl Workers {
    /// Builds the programs for these engines.
    pub(crate) fn build(engines: &[Engine]) -> Result<Self, String> {
        let mut workers = Self::default();
        if engines.contains(&Engine::Own) {
            let mut cargo = cargo("build");
            cargo.arg("--manifest-path").arg(root().join("Cargo.toml"));
            cargo.args(["--package", "drystone-app"]);
            // As a user's `cargo build --release` builds it, without flags from the environment.
            cargo.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
            workers.own = Some(built(cargo, "drystone")?);
        }
        let peers: Vec<&str> =
            engines.iter().filter(|e| **e != Engine::Own).map(|e| e.name()).collect();
        if !peers.is_empty() {
            if engines.contains(&Engine::Box3d) {
                need("cmake")?;
                need("clang")?;
            }
            let mut cargo = cargo("build");
            cargo.arg("--manifest-path").arg(bench_folder().join("Cargo.toml"));
            cargo.args(["--package", "bench-peers", "--features", &peers.join(",")]);
            cargo.env_remove("CARGO_ENCODED_RUSTFLAGS").env("RUSTFLAGS", "-C target-cpu=native");
            cargo.env("CARGO_PROFILE_RELEASE_LTO", "fat");
            cargo.env("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "1");
            cargo.arg("--target-dir").arg(native_folder());
            workers.peers = Some(built(cargo, "bench-peers")?);
        }
        Ok(workers)
    }

    /// Runs the tests with a known result on an engine, in its own process.
    pub(crate) fn validate(&self, engine: Engine, args: &Validate) -> Result<Table, String> {
        let program = if engine == Engine::Own { &self.own } else { &self.peers };
        let program = program.as_ref().ok_or_else(|| format!("{} is not built", engine.name()))?;
        let mut command = Command::new(program);
        if engine == Engine::Own {
            command.args(["validate", "--json"]);
        } else {
            command.args(["--engine", engine.name(), "--validate"]);
        }
        if let Some(only) = &args.only {
            command.args(["--only", only]);
        }
        if args.short {
            command.arg("--short");
        }
        let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output();
        let output = output.map_err(|e| e.to_string())?;
        let said = String::from_utf8_lossy(&output.stdout);
        // Box3D also prints to stdout, but a peer's table is on its own line. drystone's exit
        // status reports failed rows.
        let line = said.lines().find(|line| line.starts_with("{\"")).unwrap_or(&said);
        let bad = |e| format!("{} wrote no table ({}): {e}", engine.name(), output.status);
        serde_json::from_str(line).map_err(bad)
    }

    /// Runs an engine in its own process.
    pub(crate) fn run(&self, engine: Engine, run: &Run<'_>) -> Result<Row, String> {
        let program = if engine == Engine::Own { &self.own } else { &self.peers };
        let program = program.as_ref().ok_or_else(|| format!("{} is not built", engine.name()))?;
        let mut command = Command::new(program);
        if engine == Engine::Own {
            command.args(["bench", "--runs", "1", "--json", "-"]);
        } else {
            command.args(["--engine", engine.name()]);
        }
        command.args(["--scene", run.scene]);
        command.args(["--threads", &run.threads.to_string(), "--steps", &run.steps.to_string()]);
        let output = command.stdin(Stdio::null()).output().map_err(|e| e.to_string())?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let line = said.lines().last().unwrap_or_default().trim_start_matches("error: ");
            return Err(format!("{line} ({})", output.status));
        }
        let bad = |e| format!("{} wrote no row: {e}", engine.name());
        if engine == Engine::Own {
            let rows: Vec<Row> = serde_json::from_slice(&output.stdout).map_err(bad)?;
            return rows.into_iter().next().ok_or_else(|| "drystone wrote no row".to_owned());
        }
        // Box3D also prints to stdout; the row is on its own line.
        let said = String::from_utf8_lossy(&output.stdout);
        let line = said.lines().find(|line| line.starts_with('{')).unwrap_or_default();
        serde_json::from_str(line).map_err(bad)
    }
}

fn cargo(what: &str) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let mut command = Command::new(cargo);
    command.args([what, "--release", "--message-format", "json-render-diagnostics"]);
    command
}

/// Build folder of the peers, beside this program's own folder, because the flags differ.
fn native_folder() -> PathBuf {
    let own = std::env::current_exe().ok();
    let target = own.as_deref().and_then(Path::parent).and_then(Path::parent);
    target.map_or_else(|| bench_folder().join("target"), Path::to_path_buf).join("native")
}

/// Builds, and returns the program of this name from the build's artifacts.
fn built(mut cargo: Command, name: &str) -> Result<PathBuf, String> {
    eprintln!("building {name}");
    let output = cargo.stderr(Stdio::inherit()).output().map_err(|e| format!("cargo: {e}"))?;
    if !output.status.success() {
        return Err(format!("{name} cannot be built, see above"));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let path = text.lines().find_map(|line| executable(line, name));
    path.ok_or_else(|| format!("cargo built no {name}"))
}

/// The program of this name, if this line of cargo's messages reports it.
fn executable(line: &str, name: &str) -> Option<PathBuf> {
    let message: Value = serde_json::from_str(line).ok()?;
    let is_it = message["target"]["name"] == name && message["reason"] == "compiler-artifact";
    let path = message["executable"].as_str().filter(|_| is_it)?;
    Some(PathBuf::from(path))
}

fn need(program: &str) -> Result<(), String> {
    let run = Command::new(program).arg("--version").stdout(Stdio::null()).status();
    run.map(|_| ())
        .map_err(|_| format!("{program} is not installed, box3d needs it: run bench/install.sh"))
}

#[cfg(test)]
mod tests {
    use super::executable;

    #[test]
    fn the_program_is_found_in_cargos_messages() {
        let line = r#"{"reason":"compiler-artifact","target":{"name":"x"},"executable":"/a/x"}"#;
        assert_eq!(executable(line, "x").unwrap().to_str(), Some("/a/x"));
        assert!(executable(line, "y").is_none() && executable("", "x").is_none());
        let library = r#"{"reason":"compiler-artifact","target":{"name":"x"},"executable":null}"#;
        assert!(executable(library, "x").is_none());
    }
}
