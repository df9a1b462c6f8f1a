//! One run of a peer: the input is scene, engine, threads and steps, the output one row as JSON.
//! Alternatively it runs the tests with a known result and prints their table as JSON. `bench`
//! starts a process for every run.

#[cfg(test)]
mod agreement;
#[cfg(feature = "box3d")]
mod box3d;
#[cfg(any(feature = "rapier", feature = "box3d"))]
mod hulls;
mod queries;
#[cfg(feature = "rapier")]
mod rapier;
mod versions;

use std::io::Write as _;
use std::process::ExitCode;

use clap::Parser;
use drystone_bench::{EngineError, Order, Row};
use drystone_validate::{Candidate, Lab, Protocol, Table};

/// Runs one peer on one scene once.
#[derive(Debug, Parser)]
struct Cli {
    /// The engine.
    #[arg(long, default_value = "", hide_default_value = true)]
    engine: String,
    /// Prints a table of the cost of queries, for all built-in engines, instead of a scene.
    #[arg(long)]
    queries: bool,
    /// A scene of the catalog.
    #[arg(long, default_value = "hello")]
    scene: String,
    /// Threads, the caller included.
    #[arg(long, default_value_t = 1)]
    threads: u16,
    /// Steps.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u64).range(2..))]
    steps: u64,
    /// The tests with a known result in place of a scene.
    #[arg(long)]
    validate: bool,
    /// Only these of them.
    #[arg(long, value_delimiter = ',', requires = "validate")]
    only: Vec<String>,
    /// Only those of them that are short.
    #[arg(long, requires = "validate")]
    short: bool,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let text = if cli.queries {
        queries::table()
    } else if cli.validate {
        validate(&cli).and_then(json)
    } else {
        run(&cli).and_then(json)
    };
    match text {
        Ok(text) => {
            let written = writeln!(std::io::stdout(), "{text}");
            ExitCode::from(u8::from(written.is_err()))
        }
        Err(e) => {
            eprintln!("error: {} on {}: {e}", cli.engine, cli.scene);
            ExitCode::FAILURE
        }
    }
}

fn json(made: impl serde::Serialize) -> Result<String, EngineError> {
    serde_json::to_string(&made).map_err(|e| EngineError(e.to_string()))
}

fn validate(cli: &Cli) -> Result<Table, EngineError> {
    let candidate = match cli.engine.as_str() {
        #[cfg(feature = "rapier")]
        "rapier" => Candidate::of::<rapier::Rapier>(),
        #[cfg(feature = "box3d")]
        "box3d" => Candidate::of::<box3d::Box3d>(),
        _ => return Err(EngineError(format!("it was built without {}", cli.engine))),
    };
    let threads = usize::from(cli.threads.max(1));
    let protocol = Protocol { threads, short: cli.short, ..Protocol::default() };
    let tests = drystone_validate::select(&cli.only).map_err(EngineError)?;
    let tell = |test: &drystone_validate::Test| eprintln!("{}: {}", cli.engine, test.id);
    Ok(drystone_validate::run(&Lab { candidate, protocol }, &tests, tell))
}

fn run(cli: &Cli) -> Result<Row, EngineError> {
    let scene = drystone_scene::named(&cli.scene).map_err(|e| EngineError(e.to_string()))?;
    let order = Order {
        spec: &cli.scene,
        scene: &scene,
        threads: usize::from(cli.threads.max(1)),
        steps: cli.steps,
    };
    match cli.engine.as_str() {
        #[cfg(feature = "rapier")]
        "rapier" => drystone_bench::measure::<rapier::Rapier>(&order),
        #[cfg(feature = "box3d")]
        "box3d" => drystone_bench::measure::<box3d::Box3d>(&order),
        _ => Err(EngineError(format!("it was built without {}", cli.engine))),
    }
}
