//! `drystone simulate`: the run from the scene to the last file.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use drystone::{SimdLevel, World};
use drystone_bench::StageClock;
use drystone_scene::Running;

use crate::Outcome;
use crate::bake::Bake;
use crate::cli::{Rendering, Simulate};
use crate::events::{EventLog, Names};
use crate::load::{Loaded, build, load, refused};
use crate::measure::Measure;
use crate::output::{self, Failure, Output, progress};
use crate::render::{Render, quiet_driver};
use crate::report::{Report, Run};
use crate::settings::{cores_but, executor, time_of};
use crate::trace::Trace;

/// Status of a run that finished with a fault.
const FAULTED: u8 = 3;

/// Simulates a scene and writes what was asked for.
pub(crate) fn simulate(args: &Simulate) -> Outcome {
    check_paths(args)?;
    if args.rendering.render.is_some() {
        quiet_driver();
    }
    let mut loaded = load(&args.source, args.settings.gravity()?)?;
    args.settings.apply(&mut loaded.scene_mut().config)?;
    if args.rendering.render.is_some() {
        loaded.read_visuals();
    }
    let scene = loaded.scene();
    let hz = args.settings.hz.unwrap_or(scene.hz);
    let steps = args.length.steps(scene.seconds, hz);
    let mut running = build(scene, &args.source.scene)?;
    let threads = args.threads.map_or_else(|| cores_but(0), usize::from);
    running.world.set_executor(executor(threads));
    if let Some(level) = args.simd.as_deref().and_then(SimdLevel::named) {
        running.world.set_simd_level(level);
    }
    if args.audit {
        running.world.begin_ledger();
    }
    let mut outputs = Outputs::create(args, &running, time_of(steps, hz), hz)?;

    let stop = stop_on_interrupt();
    let bar = progress(steps, "{wide_bar} step {pos} of {len}, {eta} left");
    let mut measure = Measure::new(&running.world);
    let mut clock = StageClock::new();
    let dt = hz.recip();
    outputs.add(0, 0.0, &running)?;
    let mut done = 0;
    while done < steps && !stop.load(Ordering::Relaxed) {
        running.before_step(dt).map_err(|e| refused(&args.source.scene, &e))?;
        let start = Instant::now();
        clock.begin();
        running.world.step_observed(dt, &mut |stage| clock.stage(stage.name()));
        let spent = start.elapsed();
        running.after_step();
        done += 1;
        measure.add(done, spent, &running.world);
        outputs.add(done, time_of(done, hz), &running)?;
        bar.inc(1);
    }
    bar.finish_and_clear();

    let run = Run {
        source: &args.source.scene,
        scene,
        running: &running,
        hz,
        threads,
        steps: done,
        seconds: time_of(done, hz),
        asked: steps,
        measure: &measure,
        audit: args.audit,
    };
    let report = Report::new(&run, clock.means(done));
    let written = outputs.finish(&loaded, &running.world, &report)?;
    output::print(&report.text(&run, &written))?;
    Ok(if measure.faults.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(FAULTED) })
}

/// Two outputs in one file, or an output over the scene itself, are mistakes.
fn check_paths(args: &Simulate) -> Result<(), Failure> {
    let outputs = [
        ("--trace", &args.trace),
        ("--events", &args.events),
        ("--bake", &args.bake),
        ("--render", &args.rendering.render),
        ("--report", &args.report),
    ];
    let scene = Path::new(&args.source.scene).canonicalize().ok();
    let mut seen: Vec<(&str, PathBuf)> = Vec::new();
    for (flag, path) in outputs {
        let Some(path) = path else { continue };
        let full = full_path(path);
        if scene.as_ref() == Some(&full) {
            return Err(Failure::usage(format_args!("{flag} would overwrite the scene itself")));
        }
        if let Some((other, _)) = seen.iter().find(|(_, p)| *p == full)
            && (path.is_file() || !path.exists())
        {
            return Err(Failure::usage(format_args!("{other} and {flag} name the same file")));
        }
        seen.push((flag, full));
    }
    Ok(())
}

/// The path from the root, as far as it exists.
fn full_path(path: &Path) -> PathBuf {
    if let Ok(full) = path.canonicalize() {
        return full;
    }
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}

/// Becomes true on Ctrl-C; a second Ctrl-C ends the program at once.
fn stop_on_interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let shared = Arc::clone(&stop);
    // Without a handler Ctrl-C ends the program as it would any other.
    let _ = ctrlc::set_handler(move || {
        if shared.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
    stop
}

/// The files asked for.
struct Outputs {
    names: Names,
    trace: Option<Trace>,
    events: Option<EventLog>,
    bake: Option<Bake>,
    render: Option<Render>,
    report: Option<Output>,
}

impl Outputs {
    /// Opens them all, so that a bad path is found before the run, not after it.
    /// `running` is as the run begins, `seconds` how long it is to be, `hz` its steps a second.
    fn create(args: &Simulate, running: &Running, seconds: f64, hz: f32) -> Result<Self, Failure> {
        let trace = args.trace.as_deref();
        let Rendering { render, .. } = &args.rendering;
        let render = render.as_deref();
        Ok(Self {
            names: Names::default(),
            trace: trace.map(|path| Trace::create(path, args.every)).transpose()?,
            events: args.events.as_deref().map(EventLog::create).transpose()?,
            bake: args.bake.as_deref().map(Bake::create).transpose()?,
            render: render
                .map(|path| Render::create(path, &args.rendering, running, seconds, hz))
                .transpose()?,
            report: args.report.as_deref().map(Output::create).transpose()?,
        })
    }

    /// Adds the state after step `step`, at `time` [s].
    fn add(&mut self, step: u64, time: f64, running: &Running) -> Result<(), Failure> {
        let Running { world, bodies, names, .. } = running;
        if let Some(trace) = &mut self.trace {
            trace.add(step, time, running)?;
        }
        if let Some(events) = &mut self.events {
            self.names.learn(bodies, names);
            if step > 0 {
                events.add(step, time, world.events(), &self.names)?;
            }
        }
        if let Some(bake) = &mut self.bake {
            bake.add(time, running);
        }
        if let Some(render) = &mut self.render {
            render.add(time, world)?;
        }
        Ok(())
    }

    /// Finishes them all; returns their paths.
    fn finish(
        self,
        loaded: &Loaded,
        world: &World,
        report: &Report,
    ) -> Result<Vec<PathBuf>, Failure> {
        let mut written = Vec::new();
        if let Some(trace) = self.trace {
            written.push(trace.finish()?);
        }
        if let Some(events) = self.events {
            written.push(events.finish()?);
        }
        if let Some(bake) = self.bake {
            written.push(bake.finish(loaded)?);
        }
        if let Some(render) = self.render {
            written.push(render.finish(world)?);
        }
        if let Some(mut file) = self.report {
            file.write(&report.json()?)?;
            written.push(file.finish()?);
        }
        Ok(written)
    }
}
