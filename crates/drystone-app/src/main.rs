//! The command `drystone`: simulates scenes, writes what happened, and tells what it knows.
//!
//! `cli` says what may be asked, `settings` makes of it what a world is told; `simulate` runs a scene and feeds `trace`, `events`, `bake`, `render`,
//! `record`, `snapshot` and `report`; `replay` runs what was recorded; `bench` takes its time; `compare` runs it by several methods; `validate` compares with known results; `info` tells about scenes and methods; `convert` writes a scene as a file. Only `output` writes to files and to stdout.

mod audit;
mod bake;
mod bench;
mod chunk;
mod cli;
mod compare;
mod compare_plot;
mod convert;
mod events;
mod info;
mod load;
mod measure;
mod output;
mod record;
#[cfg(feature = "render")]
mod render;
#[cfg(not(feature = "render"))]
#[path = "render_absent.rs"]
mod render;
mod replay;
mod report;
mod settings;
mod simulate;
mod snapshot;
mod trace;
mod validate;
#[cfg(feature = "view")]
mod view;
#[cfg(not(feature = "view"))]
#[path = "view_absent.rs"]
mod view;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use cli::{Cli, Command};
use output::Failure;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => {
            // Help and version too come this way, and go to stdout.
            let written = e.print().and_then(|()| std::io::stdout().flush());
            if !e.use_stderr()
                && let Err(failure) = output::printed(written)
            {
                output::complain(&failure);
                return failure.code();
            }
            return ExitCode::from(u8::try_from(e.exit_code()).unwrap_or(2));
        }
    };
    let result = match &cli.command {
        Command::Simulate(args) => simulate::simulate(args),
        Command::View(args) => view::view(args),
        Command::Replay(args) => replay::replay(args),
        Command::Bench(args) => bench::bench(args),
        Command::Compare(args) => compare::compare(args),
        Command::Scenes => info::scenes(),
        Command::Methods => info::methods(),
        Command::Info(args) => info::info(args),
        Command::Convert(args) => convert::convert(args),
        Command::Validate(args) => validate::validate(args),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            output::complain(&failure);
            failure.code()
        }
    }
}

/// What a command comes to: its exit status, or why it could not be done.
type Outcome = Result<ExitCode, Failure>;
