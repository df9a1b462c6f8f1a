//! `drystone replay`: runs a log or a journal again, and reports where the results differ.

use std::process::ExitCode;

use drystone::journal::Journal;
use drystone::{Stage, World};
use drystone_scene::Running;

use crate::cli::{Replay, is_rate};
use crate::file::chunk;
use crate::file::record::{BodyHashes, Header, KIND, StepHashes, is_end};
use crate::file::snapshot::begin;
use crate::load::refused;
use crate::output::{self, Failure, Outcome, one_line, progress, read};
use crate::report::page::count;

/// Runs it again.
pub(crate) fn replay(args: &Replay) -> Outcome {
    let wrong = |e: &str| Failure::failed(format_args!("{}: {e}", args.log.display()));
    let bytes = read(&args.log, KIND)?;
    if bytes.starts_with(&Journal::KIND) {
        return replay_journal(args);
    }
    let mut rest = chunk::after_title(&bytes, KIND, "log that `simulate --record` wrote")
        .map_err(|e| wrong(&e))?;
    let header: Header = chunk::take(&mut rest).ok_or_else(|| wrong("was cut off or changed"))?;
    if !is_rate(header.hz) {
        return Err(wrong("its steps a second are out of range"));
    }
    let loaded = header.recipe.load()?;
    let from = header.from.as_ref().map(|snapshot| (snapshot, args.log.as_path()));
    let mut running = begin(&header.recipe, loaded.scene(), from)?;
    args.workers.equip(&mut running.world);

    let bar = progress(bytes.len() as u64, "{wide_bar} {percent} %, {eta} left");
    let (mut own, mut recorded) = (BodyHashes::default(), BodyHashes::default());
    let (first, mut steps) = (running.step_count(), 0_u64);
    let mut is_cut = true;
    while !rest.is_empty() {
        if steps > 0 && is_end(rest, steps - 1) {
            is_cut = false;
            break;
        }
        let Some(step) = chunk::take::<StepHashes>(&mut rest) else { break };
        if steps > 0 {
            running
                .before_step(header.hz.recip())
                .map_err(|e| refused(&header.recipe.source.scene, &e))?;
            running.world.step(header.hz.recip());
            running.after_step();
        }
        let now = own.step(&running);
        recorded.apply(&step.bodies);
        if now != step {
            bar.finish_and_clear();
            let bodies = own.different(&recorded);
            let what = difference(&now, &step, &bodies, &running);
            return Err(wrong(&match steps {
                0 => format!("the scene is another now: before the first step {what}"),
                _ => format!("step {}: {what}", first + steps),
            }));
        }
        steps += 1;
        bar.set_position((bytes.len() - rest.len()) as u64);
    }
    bar.finish_and_clear();
    if steps == 0 {
        return Err(wrong("was cut off before the first step"));
    }
    let taken = count(steps - 1, "step");
    let hash = running.world.state_hash();
    let cut = if is_cut { "; the log is cut off there, its end is missing" } else { "" };
    output::print(&one_line(&format!(
        "{}: {taken} run again, every bit the same; hash {hash:016x}{cut}",
        header.recipe.source.scene
    )))?;
    output::print("\n")?;
    Ok(ExitCode::SUCCESS)
}

/// A journal of calls that a program wrote.
fn replay_journal(args: &Replay) -> Outcome {
    let wrong =
        |e: &dyn core::fmt::Display| Failure::failed(format_args!("{}: {e}", args.log.display()));
    let journal = Journal::from_bytes(&read(&args.log, Journal::KIND)?).map_err(|e| wrong(&e))?;
    let mut world = World::default();
    args.workers.equip(&mut world);
    let start = World::restore(journal.start()).map_err(|e| wrong(&e))?.step_count();
    journal.replay(&mut world).map_err(|e| wrong(&e))?;
    let calls = count(journal.calls().len() as u64, "call");
    let steps = count(world.step_count() - start, "step");
    let hash = world.state_hash();
    output::print(&one_line(&format!(
        "{calls} made again, {steps} of them, every bit the same; hash {hash:016x}"
    )))?;
    output::print("\n")?;
    Ok(ExitCode::SUCCESS)
}

/// The stage and the body that differ first.
fn difference(now: &StepHashes, then: &StepHashes, bodies: &[usize], running: &Running) -> String {
    let first = now.stages.first_difference(&then.stages);
    // Only the hashes of bodies are computed twice.
    let stage = first.unwrap_or(Stage::Finalize).name();
    let Some(number) = bodies.first() else {
        return format!("stage {stage} comes to something else, at no body yet");
    };
    let name = running.names.get(*number).map_or("one that is not there now", String::as_str);
    let others = match bodies.len() {
        1 => String::new(),
        n => format!(", the first of {n} bodies"),
    };
    format!("stage {stage} comes to something else, at the body '{name}'{others}")
}
