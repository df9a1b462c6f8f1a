//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

const EXAMPLES: &str = "\
Examples (after bench/install.sh):
  cargo run --release --manifest-path bench/Cargo.toml -- --scene large_pyramid --engines self,rapier
  cargo run --release --manifest-path bench/Cargo.toml -- --scene box3d,jolt --json rows.json
  cargo run --release --manifest-path bench/Cargo.toml -- table";

/// drystone and its peers side by side on the same scenes.
#[derive(Debug, Parser)]
#[command(name = "bench", version, about, after_help = EXAMPLES, args_conflicts_with_subcommands = true)]
pub(crate) struct Cli {
    /// The measurement.
    #[command(flatten)]
    pub(crate) measure: Measure,
    /// Another command.
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

/// Commands besides the measurement.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Write the tables of bench/RESULTS.md from the rows under bench/results
    Table(Table),
    /// Run the tests with a known result on the engines, and write their errors side by side as
    /// Markdown
    Validate(Validate),
}

/// The tests with a known result.
#[derive(Args, Debug)]
pub(crate) struct Validate {
    /// Engines, a column each
    #[arg(
        long,
        alias = "engines",
        value_name = "E[,E...]",
        default_value = "self,rapier,box3d",
        value_delimiter = ','
    )]
    pub(crate) engine: Vec<Engine>,

    /// Only these tests, by their ids
    #[arg(long, value_name = "ID[,ID...]")]
    pub(crate) only: Option<String>,

    /// Leave out the tests that take long
    #[arg(long)]
    pub(crate) short: bool,
}

/// The tables.
#[derive(Args, Debug)]
pub(crate) struct Table {
    /// The page to write them in, between `<!-- bench:begin -->` and `<!-- bench:end -->`; - writes
    /// them to stdout [default: bench/RESULTS.md]
    #[arg(long, value_name = "FILE.md")]
    pub(crate) page: Option<PathBuf>,
}

/// An engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Engine {
    /// drystone
    #[value(name = "self")]
    Own,
    /// rapier3d
    Rapier,
    /// Box3D
    Box3d,
}

impl Engine {
    /// Its name in rows, and the feature of the crate of peers that has it.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Own => "self",
            Self::Rapier => "rapier",
            Self::Box3d => "box3d",
        }
    }
}

/// The measurement.
#[derive(Args, Debug)]
pub(crate) struct Measure {
    /// Scenes (`drystone scenes`), separated by commas; box3d, jolt, quality and all stand for
    /// groups of them
    #[arg(long, value_name = "S[,S...]", default_value = "all")]
    pub(crate) scene: String,

    /// Engines, in the order in which they take turns
    #[arg(
        long,
        value_name = "E[,E...]",
        default_value = "self,rapier,box3d",
        value_delimiter = ','
    )]
    pub(crate) engines: Vec<Engine>,

    /// Numbers of threads, the caller included
    #[arg(long, value_name = "N[,N...]", default_value = "1,2", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: Vec<u16>,

    /// Steps of a run [default: as many as the scene is measured for]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=1_000_000_000))]
    pub(crate) steps: Option<u64>,

    /// Runs of each scene, engine and number of threads
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(crate) runs: u16,

    /// Write the rows
    #[arg(long, value_name = "FILE.json")]
    pub(crate) json: Option<PathBuf>,
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::{Cli, Engine};

    #[test]
    fn the_command_line_is_consistent_and_lists_are_read() {
        Cli::command().debug_assert();
        let line =
            "bench --scene washer --engines self,box3d --threads 1,2 --steps 9 --json a.json";
        let cli = Cli::try_parse_from(line.split(' ')).unwrap();
        assert_eq!(cli.measure.engines, [Engine::Own, Engine::Box3d]);
        assert_eq!((cli.measure.threads, cli.measure.steps), (vec![1, 2], Some(9)));
        for bad in ["--engines bullet", "--threads 0", "--steps 1", "--runs 0", "tabel"] {
            let line = format!("bench {bad}");
            let result = Cli::try_parse_from(line.split(' '));
            assert_eq!(result.unwrap_err().exit_code(), 2, "{bad}");
        }
    }
}
