//! `drystone simulate`: the run from the scene to the last file.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::available_parallelism;
use std::time::Instant;

use drystone::{Inline, Method, SimdLevel, Team, World, WorldConfig};
use drystone_bench::StageClock;
use drystone_scene::Running;
use indicatif::{ProgressBar, ProgressStyle};

use crate::Outcome;
use crate::bake::Bake;
use crate::cli::{Rendering, Simulate};
use crate::events::{EventLog, Names};
use crate::load::{Loaded, build, load, refused};
use crate::measure::Measure;
use crate::output::{self, Failure, Output};
use crate::render::{Render, quiet_driver};
use crate::report::{Report, Run};
use crate::trace::Trace;

/// Status of a run that finished with a fault.
const FAULTED: u8 = 3;

/// Simulates a scene and writes what was asked for.
pub(crate) fn simulate(args: &Simulate) -> Outcome {
    check_paths(args)?;
    if args.rendering.render.is_some() {
        quiet_driver();
    }
    // What is said of the world is checked first: no scene makes it right or wrong.
    let mut config = WorldConfig::default();
    configure(&mut config, &Settings::of(args))?;
    let says_gravity = args.set.iter().any(|(key, _)| key == "gravity");
    let mut loaded = load(&args.source, says_gravity.then_some(config.gravity))?;
    configure(&mut loaded.scene_mut().config, &Settings::of(args))?;
    let scene = loaded.scene();
    let hz = args.hz.unwrap_or(scene.hz);
    let steps = args
        .steps
        .unwrap_or_else(|| steps_of(args.seconds.unwrap_or_else(|| f64::from(scene.seconds)), hz));
    let mut running = build(scene, &args.source.scene)?;
    let threads = threads(args);
    if threads > 1 {
        running.world.set_executor(Arc::new(Team::new(threads)));
    } else {
        running.world.set_executor(Arc::new(Inline));
    }
    if let Some(level) = args.simd.as_deref().and_then(SimdLevel::named) {
        running.world.set_simd_level(level);
    }
    if args.audit {
        running.world.begin_ledger();
    }
    let mut outputs = Outputs::create(args, &running.world, time_of(steps, hz), hz)?;

    let stop = stop_on_interrupt();
    let bar = progress(steps);
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

/// Number of steps in `seconds`, to the nearest.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range: 0 to 1e15")]
pub(crate) fn steps_of(seconds: f64, hz: f32) -> u64 {
    (seconds * f64::from(hz)).round() as u64
}

/// Time after `step` steps [s].
#[expect(clippy::cast_precision_loss, reason = "steps are far below 2^52")]
pub(crate) fn time_of(step: u64, hz: f32) -> f64 {
    step as f64 / f64::from(hz)
}

fn threads(args: &Simulate) -> usize {
    let all = || available_parallelism().map_or(1, |n| n.get().min(256));
    args.threads.map_or_else(all, usize::from)
}

/// What the command line says of the world.
pub(crate) struct Settings<'a> {
    pub(crate) method: Option<&'a str>,
    pub(crate) substeps: Option<u32>,
    pub(crate) set: &'a [(String, String)],
}

impl<'a> Settings<'a> {
    fn of(args: &'a Simulate) -> Self {
        Self { method: args.method.as_deref(), substeps: args.substeps, set: &args.set }
    }
}

/// Applies what the command line says of the world.
pub(crate) fn configure(config: &mut WorldConfig, settings: &Settings<'_>) -> Result<(), Failure> {
    if let Some(method) = settings.method.and_then(Method::named) {
        config.method = method;
    }
    if let Some(substeps) = settings.substeps {
        config.substeps = substeps;
    }
    for (key, value) in settings.set {
        config
            .set(key, value)
            .map_err(|e| Failure::usage(format_args!("--set {key}={value}: {e}")))?;
    }
    Ok(())
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

/// A bar with the time left, if somebody looks.
fn progress(steps: u64) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(steps);
    let style = ProgressStyle::with_template("{wide_bar} step {pos} of {len}, {eta} left");
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
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
    /// `world` is as the run begins, `seconds` how long it is to be, `hz` its steps a second.
    fn create(args: &Simulate, world: &World, seconds: f64, hz: f32) -> Result<Self, Failure> {
        let trace = args.trace.as_deref();
        let Rendering { render, .. } = &args.rendering;
        let render = render.as_deref();
        Ok(Self {
            names: Names::default(),
            trace: trace.map(|path| Trace::create(path, args.every)).transpose()?,
            events: args.events.as_deref().map(EventLog::create).transpose()?,
            bake: args.bake.as_deref().map(Bake::create).transpose()?,
            render: render
                .map(|path| Render::create(path, &args.rendering, world, seconds, hz))
                .transpose()?,
            report: args.report.as_deref().map(Output::create).transpose()?,
        })
    }

    /// Adds the state after step `step`, at `time` [s].
    fn add(&mut self, step: u64, time: f64, running: &Running) -> Result<(), Failure> {
        let Running { world, bodies, names, .. } = running;
        if let Some(trace) = &mut self.trace {
            trace.add(step, time, world, bodies, names)?;
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
