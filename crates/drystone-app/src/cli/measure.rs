//! Commands that measure: `bench`, `compare`, `validate`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use drystone::method::Method;

use super::parse::{assignment, hz};
use super::source::{Length, Source};

const BENCH_EXAMPLES: &str = "\
Examples:
  drystone bench
  drystone bench --scene stack:n=30,top_mass_ratio=100,washer --threads 1,2,4
  drystone bench --scene quality --runs 1 --json rows.json
  drystone bench --scene joint_grid --scaling

What is timed are the steps alone. A run's figure is the mean over its steps; the first step, in
which contacts and trees are built, is left out except in the scenes of Jolt's performance test.
ms/step is the median of the runs' figures, min the smallest, p99 the 99th percentile over steps.
Penetration is measured from poses copied after eight steps of a run, the last one included. The
hash is that of `drystone simulate`: a time without it is no result.

--scaling takes one run of a scene for each number of threads above 1: a world on one thread and its
twin on several take their steps in turn. What a loop without memory gains by the same threads is
what the machine has to give.

Other engines on the same scenes: bench/README.md in the source tree.

Exit status:
  0  done
  1  a scene is not known, a file cannot be written, or two runs ended in different states
  2  wrong usage";

/// `drystone bench`.
#[derive(Args, Debug)]
#[command(after_help = BENCH_EXAMPLES)]
pub(crate) struct Bench {
    /// Built-in scenes, separated by commas; box3d, jolt, quality and all stand for groups of them
    #[arg(long, value_name = "S[,S...]", default_value = "large_pyramid")]
    pub(crate) scene: String,

    /// Numbers of worker threads, the caller included
    #[arg(long, value_name = "N[,N...]", default_value = "1,2", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: Vec<u16>,

    /// Steps of a run [default: as many as the scene is measured for]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=1_000_000_000))]
    pub(crate) steps: Option<u64>,

    /// Runs of each scene and number of threads
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(crate) runs: u16,

    /// Write the rows; - writes them to stdout, without the table
    #[arg(long, value_name = "FILE.json")]
    pub(crate) json: Option<PathBuf>,

    /// Measure the gain of threads, in steps that one world and its twin take by turns
    #[arg(long, conflicts_with_all = ["json", "runs"])]
    pub(crate) scaling: bool,
}

const COMPARE_EXAMPLES: &str = "\
Examples:
  drystone compare stack:n=20
  drystone compare cradle --methods soft-step,guendelman,naive
  drystone compare stack --with soft-step --with soft-step:substeps=16 --seconds 10
  drystone compare wall --with soft-step --with soft-step-relax --csv wall.csv --svg wall.svg

Without --methods and --with every method runs (`drystone methods` lists them). deepest and end are the deepest overlap
in any step and after the last; speed that of the fastest body at the end; gained what kinetic and
potential energy were above the start at most; drift and sink the farthest that a body is from where it
was, across gravity and along it; off analytic the greatest difference of a body's velocity after one more
step from what the method analytic makes of the same state, in parts of what gravity gives in a step.

Exit status:
  0  done
  1  the scene cannot be read or is invalid, or a file cannot be written
  2  wrong usage, or settings that do not go together";

/// `drystone compare`.
#[derive(Args, Debug)]
#[command(after_help = COMPARE_EXAMPLES)]
pub(crate) struct Compare {
    /// Which scene.
    #[command(flatten)]
    pub(crate) source: Source,

    /// Runs by these methods
    #[arg(long, value_name = "NAME[,NAME...]", value_delimiter = ',', value_parser = PossibleValuesParser::new(Method::NAMES))]
    pub(crate) methods: Vec<String>,

    /// A run: a method, with fields of the world's configuration after a colon; repeatable, and
    /// together with --methods
    #[arg(long, value_name = "METHOD[:KEY=VALUE,...]")]
    pub(crate) with: Vec<String>,

    /// How long.
    #[command(flatten)]
    pub(crate) length: Length,

    /// Steps per second [default: the scene's own, else 60]
    #[arg(long, value_name = "F", value_parser = hz)]
    pub(crate) hz: Option<f32>,

    /// A field of the world's configuration for all runs; repeatable
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment)]
    pub(crate) set: Vec<(String, String)>,

    /// Worker threads, the caller included
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: u16,

    /// Judge whether the scene stands even if it is not one that is known to
    #[arg(long)]
    pub(crate) stands: bool,

    /// Write the rows as JSON
    #[arg(long, value_name = "FILE.json")]
    pub(crate) json: Option<PathBuf>,

    /// Write the rows as comma-separated values
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) csv: Option<PathBuf>,

    /// Write a plot of overlap and kinetic energy over time
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) svg: Option<PathBuf>,

    /// Write the same plot as PNG
    #[arg(long, value_name = "FILE.png")]
    pub(crate) png: Option<PathBuf>,
}

const VALIDATE_EXAMPLES: &str = "\
Examples:
  drystone validate --short
  drystone validate --only A16,A17 --substeps 4
  drystone validate --only S1 --sweep
  drystone validate --markdown > docs/accuracy.md
  drystone validate --sweep --markdown > docs/convergence.md

Exit status:
  0  every test is within what it must
  1  one is not, or could not run; with --known: one is worse than listed
  2  wrong usage";

/// `drystone validate`.
#[derive(Args, Debug)]
#[command(after_help = VALIDATE_EXAMPLES)]
pub(crate) struct Validate {
    /// Only these tests, by their ids
    #[arg(long, value_name = "ID[,ID...]", value_delimiter = ',')]
    pub(crate) only: Vec<String>,

    /// Leave out the tests that take long
    #[arg(long)]
    pub(crate) short: bool,

    /// Run the tests whose error should fall with the step at 1, 2, 4 and 8 substeps and at 30, 60
    /// and 120 Hz, and print the errors and the order in which they fall (as text, or with
    /// --markdown)
    #[arg(long)]
    pub(crate) sweep: bool,

    /// Solver substeps per step [default: the method's own]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub(crate) substeps: Option<u32>,

    /// Steps per second
    #[arg(long, value_name = "F", default_value_t = 60.0, value_parser = hz)]
    pub(crate) hz: f32,

    /// A field of the world's configuration, such as contact.hertz=60; repeatable
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment)]
    pub(crate) set: Vec<(String, String)>,

    /// Worker threads, the caller included [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: Option<u16>,

    /// Failures that are known, a line an error and a row (as --failures writes them): only what is
    /// worse counts
    #[arg(long, value_name = "FILE", conflicts_with = "sweep")]
    pub(crate) known: Option<PathBuf>,

    /// How the table is printed.
    #[command(flatten)]
    pub(crate) format: Format,
}

/// How a table is printed, if not for a terminal.
#[derive(Args, Debug)]
#[group(multiple = false)]
#[expect(clippy::struct_excessive_bools, reason = "flags that exclude each other")]
pub(crate) struct Format {
    /// Print JSON
    #[arg(long, conflicts_with = "sweep")]
    pub(crate) json: bool,
    /// Print comma-separated values
    #[arg(long, conflicts_with = "sweep")]
    pub(crate) csv: bool,
    /// Print a Markdown page
    #[arg(long)]
    pub(crate) markdown: bool,
    /// Print the rows that fail, as --known reads them
    #[arg(long, conflicts_with = "sweep")]
    pub(crate) failures: bool,
}
