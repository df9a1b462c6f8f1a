//! One run of a peer: scene, engine, threads and steps in, one row as JSON out. `bench` starts a process of
//! it for every run.

#[cfg(test)]
mod agreement;
#[cfg(feature = "box3d")]
mod box3d;
#[cfg(any(feature = "rapier", feature = "box3d"))]
mod hulls;
#[cfg(feature = "rapier")]
mod rapier;
mod versions;

use std::io::Write as _;
use std::process::ExitCode;

use clap::Parser;
use drystone_bench::{EngineError, Order, Row};

/// Runs one peer on one scene once.
#[derive(Debug, Parser)]
struct Cli {
    /// The engine.
    #[arg(long)]
    engine: String,
    /// A scene of the catalog.
    #[arg(long)]
    scene: String,
    /// Threads, the caller included.
    #[arg(long)]
    threads: u16,
    /// Steps.
    #[arg(long, value_parser = clap::value_parser!(u64).range(2..))]
    steps: u64,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let row = run(&cli).map_err(|e| e.to_string());
    let text = row.and_then(|row| serde_json::to_string(&row).map_err(|e| e.to_string()));
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
