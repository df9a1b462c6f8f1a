//! The command `drystone`: simulates scenes, writes their trajectories, events and reports, and
//! lists scenes and methods.
//!
//! [`cli`] defines the command line and [`settings`] applies it to a world. [`command`] has a file
//! for each command. [`load`] reads scenes. [`file`] has the formats of a run's files, [`report`]
//! its measurements, [`render`] its pictures. Only [`output`] writes to files and to stdout.

mod cli;
mod command;
mod file;
mod load;
mod output;
mod render;
mod report;
mod settings;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use cli::Cli;

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
    match command::run(&cli.command) {
        Ok(code) => code,
        Err(failure) => {
            output::complain(&failure);
            failure.code()
        }
    }
}
