//! drystone and its peers side by side. The engines alternate run by run, and each run has its own
//! process. The results are rows as JSON, rows kept under `results/`, and the tables of RESULTS.md.

mod cli;
mod results;
mod table;
mod workers;

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use drystone_bench::{Row, default_steps, expand, listing};
use drystone_scene::Scene;
use drystone_scene::file::WholeFile;

use cli::{Cli, Command, Engine, Measure};
use workers::{Run, Workers};

/// Minimum number of runs in a row that is kept.
const ENOUGH_RUNS: usize = 5;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let outcome = match &cli.command {
        Some(Command::Table(args)) => table::write(args.page.as_deref()),
        Some(Command::Validate(args)) => validate(args),
        None => measure(&cli.measure),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::FAILURE
        }
    }
}

/// Runs the tests with a known result on each engine, and prints them side by side.
fn validate(args: &cli::Validate) -> Result<(), String> {
    let workers = Workers::build(&args.engine)?;
    let mut tables = Vec::new();
    for &engine in &args.engine {
        tables.push(workers.validate(engine, args)?);
    }
    write_out(&drystone_validate::side_by_side(&tables))
}

fn measure(args: &Measure) -> Result<(), String> {
    let scenes = expand(&args.scene).map_err(|e| e.to_string())?;
    if let Some(path) = &args.json {
        // Fails now rather than after an hour.
        WholeFile::probe(path).map_err(|e| refused(path, &e))?;
    }
    let workers = Workers::build(&args.engines)?;
    warn_of_load();
    let mut rows = Vec::new();
    for (spec, scene) in &scenes {
        rows.extend(scene_rows(args, &workers, spec, scene)?);
        if let Some(path) = &args.json {
            let json = serde_json::to_string_pretty(&rows).map_err(|e| e.to_string())?;
            write_whole(path, &(json + "\n"))?;
        }
    }
    write_out(&listing(&rows))?;
    let full = |row: &Row| {
        let scene = scenes.iter().find(|(spec, _)| *spec == row.scene);
        row.runs >= ENOUGH_RUNS && scene.is_some_and(|(_, s)| default_steps(s) == row.steps)
    };
    let kept: Vec<Row> = rows.iter().filter(|row| full(row)).cloned().collect();
    if kept.is_empty() {
        eprintln!("not kept under bench/results: that takes {ENOUGH_RUNS} runs of full length");
    } else {
        eprintln!("kept in {}", results::append(&kept)?.display());
    }
    if rows.is_empty() { Err("no engine ran any of the scenes".to_owned()) } else { Ok(()) }
}

/// The rows of a scene, by number of threads and engine.
fn scene_rows(
    args: &Measure,
    workers: &Workers,
    spec: &str,
    scene: &Scene,
) -> Result<Vec<Row>, String> {
    let steps = args.steps.unwrap_or_else(|| default_steps(scene));
    let mut rows: Vec<Row> = Vec::new();
    for &threads in &args.threads {
        let run = Run { scene: spec, threads, steps };
        let mut engines: Vec<(Engine, Vec<Row>)> =
            args.engines.iter().map(|&engine| (engine, Vec::new())).collect();
        // Runs alternate (A B A B), so that a slow spell of the machine affects all engines.
        for number in 1..=args.runs {
            engines.retain_mut(|(engine, runs)| {
                let name = engine.name();
                match workers.run(*engine, &run) {
                    Ok(row) => {
                        let ms = row.ms_per_step.median;
                        eprintln!(
                            "{spec}, threads {threads}, run {number} of {}, {name}: {ms:.4} ms",
                            args.runs
                        );
                        runs.push(row);
                        true
                    }
                    Err(e) => {
                        eprintln!("{spec}, threads {threads}, {name} is left out: {e}");
                        false
                    }
                }
            });
        }
        for (engine, runs) in &engines {
            let Some((row, deviation)) = Row::merge(runs) else { continue };
            if let Some(d) = deviation {
                let what = format!(
                    "{spec}, threads {threads}: runs of {} ended in different states, {} and {}",
                    engine.name(),
                    d.first,
                    d.other
                );
                if *engine == Engine::Own {
                    return Err(what);
                }
                eprintln!("note: {what}");
            }
            rows.push(row);
        }
    }
    let mut own = rows.iter().filter(|row| row.engine == Engine::Own.name());
    if let Some(first) = own.next()
        && let Some(other) = own.find(|row| row.hash != first.hash)
    {
        return Err(format!(
            "{spec}: self ended in state {} on {} and {} on {} threads",
            first.hash, first.threads, other.hash, other.threads
        ));
    }
    Ok(rows)
}

/// Warns of other load, because times taken meanwhile are noise.
fn warn_of_load() {
    let load = fs::read_to_string("/proc/loadavg").ok();
    let load = load.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    if let Some(load) = load.filter(|load| *load > 0.5) {
        eprintln!(
            "note: the load of the machine is {load} (the build counts too): times may be noise"
        );
    }
}

fn write_out(text: &str) -> Result<(), String> {
    std::io::stdout().write_all(text.as_bytes()).map_err(|e| format!("stdout: {e}"))
}

/// Writes a file that gets its name only when it is complete.
fn write_whole(path: &Path, text: &str) -> Result<(), String> {
    let written = WholeFile::create(path).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.finish()
    });
    written.map(|_| ()).map_err(|e| refused(path, &e))
}

fn refused(path: &Path, e: &std::io::Error) -> String {
    format!("{}: cannot be written: {e}", path.display())
}
