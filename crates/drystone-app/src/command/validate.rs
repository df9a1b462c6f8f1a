//! `drystone validate`: the accuracy table.

use std::path::Path;
use std::process::ExitCode;

use drystone::WorldConfig;
use drystone_bench::Own;
use drystone_scene::file;
use drystone_validate::{Candidate, Known, Lab, Protocol, Table, Test, run, select, sweep};

use crate::cli::Validate;
use crate::output::{self, Failure, Outcome, progress};
use crate::settings::{cores_but, set_all};

/// Runs the tests and prints the table.
pub(crate) fn validate(args: &Validate) -> Outcome {
    let tests = select(&args.only).map_err(Failure::usage)?;
    let known = args.known.as_deref().map(read_known).transpose()?;
    let lab = Lab { candidate: Candidate::of::<Own>(), protocol: protocol(args) };
    // A setting that no world has is wrong usage, not a failed test.
    set_all(&mut WorldConfig::default(), &args.set)?;
    let bar = progress(tests.len() as u64, "{wide_bar} {msg}, test {pos} of {len}, {eta} left");
    let tell = |test: &Test| {
        bar.set_message(test.id);
        bar.inc(1);
    };
    if args.sweep {
        let sweep = sweep(&lab, &tests, tell);
        bar.finish_and_clear();
        let page = if args.format.markdown { sweep.markdown() } else { sweep.text() };
        output::print(&page)?;
        return Ok(ExitCode::SUCCESS);
    }
    let table = run(&lab, &tests, tell);
    bar.finish_and_clear();
    output::print(&printed(args, &table)?)?;
    Ok(match known {
        Some(known) => judge(&known, &table),
        None => ExitCode::from(u8::from(!table.passes())),
    })
}

fn protocol(args: &Validate) -> Protocol {
    Protocol {
        hz: f64::from(args.hz),
        substeps: args.substeps.unwrap_or(0),
        threads: args.threads.map_or_else(|| cores_but(0), usize::from),
        set: args.set.clone(),
        short: args.short,
    }
}

fn printed(args: &Validate, table: &Table) -> Result<String, Failure> {
    let format = &args.format;
    Ok(if format.json {
        serde_json::to_string_pretty(table).map_err(Failure::failed)? + "\n"
    } else if format.csv {
        table.csv()
    } else if format.markdown {
        table.markdown()
    } else if format.failures {
        Known::of(table)
    } else {
        table.text()
    })
}

fn read_known(path: &Path) -> Result<Known, Failure> {
    let named =
        |e: &dyn std::fmt::Display| Failure::failed(format_args!("{}: {e}", path.display()));
    let bytes = file::read_any(path, file::Kind::List, &[]).map_err(Failure::failed)?;
    let text = String::from_utf8(bytes).map_err(|_| named(&"it is not UTF-8 text"))?;
    Known::parse(&text).map_err(|e| named(&e))
}

/// Prints the notes of a list of known failures on stderr.
fn judge(known: &Known, table: &Table) -> ExitCode {
    let found = known.compare(table);
    for line in &found.mended {
        eprintln!("mended, take it off the list: {line}");
    }
    for line in &found.worse {
        eprintln!("worse: {line}");
    }
    ExitCode::from(u8::from(!found.worse.is_empty()))
}
