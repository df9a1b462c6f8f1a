//! `drystone simulate`: the run from the scene to the last file.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Instant;

use drystone::World;
use drystone_bench::StageClock;
use drystone_scene::{Running, Scene};

use crate::cli::{Reading, Rendering, Settings, Simulate, Source};
use crate::file::bake::Bake;
use crate::file::events::{EventLog, Names};
use crate::file::record::{Header, Record};
use crate::file::snapshot::{Recipe, Snapshot, SnapshotFile, begin};
use crate::file::trace::Trace;
use crate::load::{Loaded, refused};
use crate::output::{self, Failure, Outcome, Output, progress};
use crate::render::{Render, quiet_driver};
use crate::report::measure::Measure;
use crate::report::{Report, Run};
use crate::settings::time_of;

/// Status of a run that finished with a fault.
const FAULTED: u8 = 3;

/// Simulates a scene and writes the outputs.
pub(crate) fn simulate(args: &Simulate) -> Outcome {
    check_paths(args)?;
    if args.rendering.render.is_some() {
        quiet_driver();
    }
    let saved = args.resume.as_deref().map(Snapshot::read).transpose()?;
    let recipe = recipe_of(args, saved.as_ref())?;
    let mut loaded = recipe.load()?;
    if args.rendering.render.is_some() {
        loaded.read_visuals();
    }
    let scene = loaded.scene();
    let hz = args.settings.hz.or(saved.as_ref().map(|s| s.hz)).unwrap_or(scene.hz);
    let steps = args.length.steps(scene.seconds, hz);
    let mut running = begin(&recipe, scene, saved.as_ref().zip(args.resume.as_deref()))?;
    if saved.is_some() {
        set_again(&mut running, &args.settings)?;
    }
    let start = Start::of(&running, saved.as_ref(), hz);
    let threads = args.workers.equip(&mut running.world);
    if args.audit {
        running.world.begin_ledger();
    }
    // Only a recording needs the state at the start.
    let from = match (&saved, &args.record) {
        (Some(_), Some(_)) => Some(start.snapshot(&recipe, scene, &running, 0)?),
        _ => None,
    };
    let header = Header { recipe, hz, from };
    // Before the first file: files that are not whole are removed on Ctrl-C.
    let stop = output::stop_on_interrupt();
    let mut outputs = Outputs::create(args, &running, time_of(steps, hz), &header)?;
    let Header { recipe, .. } = header;
    let source = &recipe.source.scene;

    let bar = progress(steps, "{wide_bar} step {pos} of {len}, {eta} left");
    let mut measure = Measure::new(&running.world);
    let mut clock = StageClock::new();
    let dt = hz.recip();
    outputs.add(&start, 0, &running)?;
    let mut done = 0;
    while done < steps && !stop.load(Ordering::Relaxed) {
        running.before_step(dt).map_err(|e| refused(source, &e))?;
        let began = Instant::now();
        clock.begin();
        running.world.step_observed(dt, &mut |stage| clock.stage(stage.name()));
        let spent = began.elapsed();
        running.after_step();
        done += 1;
        measure.add(start.step + done, spent, &running.world);
        outputs.add(&start, done, &running)?;
        bar.inc(1);
    }
    bar.finish_and_clear();

    let run = Run {
        source,
        from: start.step,
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
    let last = match &args.snapshot {
        Some(_) => Some(start.snapshot(&recipe, scene, &running, done)?),
        None => None,
    };
    let end = (start.step + done, start.time(done));
    let written = outputs.finish(&loaded, &running.world, end, last.as_ref(), &report)?;
    output::print(&report.text(&run, &written))?;
    Ok(if measure.faults.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(FAULTED) })
}

/// The scene to run: the one on the command line, or that of the snapshot.
fn recipe_of(args: &Simulate, saved: Option<&Snapshot>) -> Result<Recipe, Failure> {
    let Some(Snapshot { recipe, .. }) = saved else {
        let scene = args.scene.clone().unwrap_or_default();
        let source = Source { scene, reading: args.reading };
        return Ok(Recipe { source, settings: args.settings.clone() });
    };
    if args.reading != Reading::default() {
        let message = "--auto-colliders, --base and --ground are the snapshot's; leave them out";
        return Err(Failure::usage(message));
    }
    // Settings are checked before any scene is read.
    args.settings.gravity()?;
    let scene = args.scene.clone().unwrap_or_else(|| recipe.source.scene.clone());
    Ok(Recipe { source: Source { scene, ..recipe.source.clone() }, ..recipe.clone() })
}

/// Changes the settings of a world that goes on.
fn set_again(running: &mut Running, settings: &Settings) -> Result<(), Failure> {
    let mut config = running.world.config().clone();
    settings.apply(&mut config)?;
    if config == *running.world.config() {
        return Ok(());
    }
    running.world.set_config(config).map_err(Failure::usage)
}

/// Where a run begins.
#[derive(Debug)]
struct Start {
    /// Steps that were taken before.
    step: u64,
    /// Time beyond that of its steps [s]: 0 unless the length of a step has changed.
    shift: f64,
    hz: f32,
}

impl Start {
    fn of(running: &Running, saved: Option<&Snapshot>, hz: f32) -> Self {
        let step = running.step_count();
        let shift = saved.map_or(0.0, |s| s.time - time_of(step, hz));
        Self { step, shift, hz }
    }

    /// Time after `done` more steps [s].
    fn time(&self, done: u64) -> f64 {
        time_of(self.step + done, self.hz) + self.shift
    }

    /// The run after `done` more steps.
    fn snapshot(
        &self,
        recipe: &Recipe,
        scene: &Scene,
        running: &Running,
        done: u64,
    ) -> Result<Snapshot, Failure> {
        Snapshot::of(recipe, scene, running, self.hz, self.time(done))
            .map_err(|e| refused(&recipe.source.scene, &e))
    }
}

/// Two outputs in one file, or an output over the scene itself, are mistakes.
fn check_paths(args: &Simulate) -> Result<(), Failure> {
    let outputs = [
        ("--trace", &args.trace),
        ("--events", &args.events),
        ("--bake", &args.bake),
        ("--render", &args.rendering.render),
        ("--report", &args.report),
        ("--record", &args.record),
        ("--snapshot", &args.snapshot),
    ];
    let file = |path: &Path| path.canonicalize().ok();
    let scene = args.scene.as_ref().and_then(|scene| file(Path::new(scene)));
    let resumed = args.resume.as_deref().and_then(file);
    let mut seen: Vec<(&str, PathBuf)> = Vec::new();
    for (flag, path) in outputs {
        let Some(path) = path else { continue };
        let full = full_path(path);
        if scene.as_ref() == Some(&full) {
            return Err(Failure::usage(format_args!("{flag} would overwrite the scene itself")));
        }
        // A snapshot may take the place of the one that the run went on from.
        if resumed.as_ref() == Some(&full) && flag != "--snapshot" {
            return Err(Failure::usage(format_args!("{flag} would overwrite the snapshot")));
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

/// The output files.
struct Outputs {
    names: Names,
    trace: Option<Trace>,
    events: Option<EventLog>,
    bake: Option<Bake>,
    render: Option<Render>,
    record: Option<Record>,
    snapshot: Option<SnapshotFile>,
    report: Option<Output>,
}

impl Outputs {
    /// Opens them all, so that a bad path is found before the run, not after it. `running` is as
    /// the run begins, `seconds` how long it is to be, `header` the head of a recording.
    fn create(
        args: &Simulate,
        running: &Running,
        seconds: f64,
        header: &Header,
    ) -> Result<Self, Failure> {
        let hz = header.hz;
        let trace = args.trace.as_deref();
        let Rendering { render, .. } = &args.rendering;
        let render = render.as_deref();
        Ok(Self {
            names: Names::default(),
            trace: trace.map(|path| Trace::create(path, args.every)).transpose()?,
            events: args.events.as_deref().map(EventLog::create).transpose()?,
            bake: args.bake.as_deref().map(Bake::create).transpose()?,
            render: render
                .map(|path| {
                    let Rendering { camera, .. } = args.rendering;
                    Render::create(path, camera, args.rendering.wanted(), running, seconds, hz)
                })
                .transpose()?,
            record: args.record.as_deref().map(|path| Record::create(path, header)).transpose()?,
            snapshot: args.snapshot.as_deref().map(SnapshotFile::create).transpose()?,
            report: args.report.as_deref().map(Output::create).transpose()?,
        })
    }

    /// Adds the state after `done` steps of this run.
    fn add(&mut self, start: &Start, done: u64, running: &Running) -> Result<(), Failure> {
        let Running { world, bodies, names, .. } = running;
        let (step, time) = (start.step + done, start.time(done));
        if let Some(trace) = &mut self.trace {
            trace.add(step, time, running)?;
        }
        if let Some(events) = &mut self.events {
            self.names.learn(bodies, names);
            if done > 0 {
                events.add(step, time, world.events(), &self.names)?;
            }
        }
        if let Some(bake) = &mut self.bake {
            bake.add(time, running);
        }
        if let Some(record) = &mut self.record {
            record.add(running)?;
        }
        if let Some(render) = &mut self.render {
            render.add(time, world)?;
        }
        Ok(())
    }

    /// Finishes them all; returns their paths. `end` is the last step and its time [s].
    fn finish(
        self,
        loaded: &Loaded,
        world: &World,
        end: (u64, f64),
        snapshot: Option<&Snapshot>,
        report: &Report,
    ) -> Result<Vec<PathBuf>, Failure> {
        let mut written = Vec::new();
        if let Some(trace) = self.trace {
            written.push(trace.finish()?);
        }
        if let Some(events) = self.events {
            written.push(events.finish(end.0, end.1)?);
        }
        if let Some(bake) = self.bake {
            written.push(bake.finish(loaded)?);
        }
        if let Some(render) = self.render {
            written.push(render.finish(world)?);
        }
        if let Some(record) = self.record {
            written.push(record.finish()?);
        }
        if let Some((file, snapshot)) = self.snapshot.zip(snapshot) {
            written.push(file.finish(snapshot)?);
        }
        if let Some(mut file) = self.report {
            file.write(&report.json()?)?;
            written.push(file.finish()?);
        }
        Ok(written)
    }
}
