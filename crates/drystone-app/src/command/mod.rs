//! The commands, a file each.

mod bench;
mod compare;
mod compare_plot;
mod convert;
mod info;
mod replay;
mod simulate;
mod validate;
#[cfg(feature = "view")]
mod view;
#[cfg(not(feature = "view"))]
#[path = "view_absent.rs"]
mod view;

use crate::cli::Command;
use crate::output::Outcome;

/// Runs a command.
pub(crate) fn run(command: &Command) -> Outcome {
    match command {
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
    }
}
