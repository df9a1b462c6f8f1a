//! `drystone bench`: how long a step takes, with the hash and the quality of what was computed.

use std::path::Path;
use std::process::ExitCode;

use drystone_bench::{
    Order, Own, Row, default_steps, expand, listing, measure, scaling, scaling_listing,
};

use crate::cli::Bench;
use crate::output::{self, Failure, Outcome, Output, progress};

/// Measures the scenes one after the other.
pub(crate) fn bench(args: &Bench) -> Outcome {
    if args.scaling {
        return gains(args);
    }
    let scenes = expand(&args.scene).map_err(Failure::failed)?;
    let to_stdout = args.json.as_deref() == Some(Path::new("-"));
    output::leave_on_interrupt();
    let file = args.json.as_deref().filter(|_| !to_stdout).map(Output::create).transpose()?;
    let mut threads: Vec<usize> = args.threads.iter().map(|&n| usize::from(n)).collect();
    threads.dedup();

    let count = scenes.len() * threads.len() * usize::from(args.runs);
    let bar = progress(count as u64, "{wide_bar} run {pos} of {len}, {eta} left");
    let mut rows: Vec<Row> = Vec::new();
    for (spec, scene) in &scenes {
        let steps = args.steps.unwrap_or_else(|| default_steps(scene));
        let mut runs: Vec<Vec<Row>> = vec![Vec::new(); threads.len()];
        // In turn, so that a slow spell of the machine meets all of them.
        for _ in 0..args.runs {
            for (&threads, runs) in threads.iter().zip(&mut runs) {
                let order = Order { spec, scene, threads, steps };
                let row = measure::<Own>(&order)
                    .map_err(|e| Failure::failed(format_args!("{spec}: {e}")))?;
                runs.push(row);
                bar.inc(1);
            }
        }
        same_end(spec, &runs)?;
        rows.extend(runs.iter().filter_map(|runs| Row::merge(runs)).map(|(row, _)| row));
    }
    bar.finish_and_clear();

    let mut json = serde_json::to_vec_pretty(&rows).map_err(Failure::failed)?;
    json.push(b'\n');
    if to_stdout {
        output::print(&String::from_utf8_lossy(&json))?;
    } else {
        output::print(&listing(&rows))?;
    }
    if let Some(mut file) = file {
        file.write(&json)?;
        file.finish()?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The gain of threads in each scene.
fn gains(args: &Bench) -> Outcome {
    let scenes = expand(&args.scene).map_err(Failure::failed)?;
    let mut threads: Vec<usize> = args.threads.iter().map(|&n| usize::from(n)).collect();
    threads.retain(|&n| n > 1);
    threads.dedup();
    if threads.is_empty() {
        return Err(Failure::failed("--scaling needs a number of threads above 1"));
    }
    let bar = progress(
        (scenes.len() * threads.len()) as u64,
        "{wide_bar} scene {pos} of {len}, {eta} left",
    );
    let mut found = Vec::new();
    for (spec, scene) in &scenes {
        let steps = args.steps.unwrap_or_else(|| default_steps(scene));
        for &threads in &threads {
            let order = Order { spec, scene, threads, steps };
            let gain = scaling(&order);
            found.push(gain.map_err(|e| Failure::failed(format_args!("{spec}: {e}")))?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    output::print(&scaling_listing(&found))?;
    Ok(ExitCode::SUCCESS)
}

/// All runs of a scene, with whatever number of threads, end in the same state.
fn same_end(spec: &str, runs: &[Vec<Row>]) -> Result<(), Failure> {
    let mut all = runs.iter().flatten();
    let Some(first) = all.next() else { return Ok(()) };
    all.find(|row| row.hash != first.hash).map_or(Ok(()), |other| {
        Err(Failure::failed(format_args!(
            "{spec}: runs ended in different states, hash {} on {} and {} on {} threads",
            first.hash, first.threads, other.hash, other.threads
        )))
    })
}
