//! `drystone compare`: one scene by several methods and settings, side by side.

use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::Instant;

use drystone::method::{Method, MethodOptions, Overlap};
use drystone::{BodyKind, Vec3, World, WorldConfig};
use drystone_bench::{BodyState, stands, still_stands};
use drystone_scene::{Running, Scene, SceneBody};
use serde::Serialize;

use super::compare_plot::{self, Curve};
use crate::cli::Compare;
use crate::load::{build, load, refused};
use crate::output::{self, Failure, Outcome, Output, one_line};
use crate::report::measure::Measure;
use crate::settings::{executor, said_gravity, set_all, time_of};

/// One run, as a row of the table.
#[derive(Debug, Serialize)]
struct Row {
    /// As the user wrote it.
    run: String,
    method: &'static str,
    substeps: u32,
    /// Median time of a step [ms], without measurements.
    ms_per_step: f64,
    /// Sweeps over the contacts in a step, mean over steps.
    sweeps: f64,
    /// Deepest overlap in any step, and after the last [m].
    penetration_max: f64,
    penetration_end: f64,
    /// Largest joint error in any step [m].
    joint_error_max: f64,
    /// Largest speed of a dynamic body's center at the end [m/s].
    speed_end: f64,
    /// Kinetic energy at the end [J].
    kinetic_end: f64,
    /// Change of kinetic and potential energy over the run, and the most that it was above the
    /// start [J].
    energy_change: f64,
    energy_gain: f64,
    /// Farthest that a dynamic body is from where it was at the start: across gravity, and along it
    /// [m].
    drift: f64,
    sink: f64,
    /// Greatest difference of a body's velocity after one more step to the velocity that `analytic`
    /// gives from the same state, over the gain by gravity in a step. Nothing where `analytic` has
    /// no answer.
    off_analytic: Option<f64>,
    /// Whether the scene stands, if it should; nothing if that is not measured.
    stands: Option<bool>,
    /// Bodies that left the finite numbers.
    faults: usize,
    /// Warnings of the engine before the first step.
    warnings: Vec<String>,
    hash: String,
}

/// The comparison as JSON.
#[derive(Debug, Serialize)]
struct Comparison<'a> {
    scene: &'a str,
    hz: f32,
    steps: u64,
    threads: u16,
    runs: &'a [Row],
}

/// Runs the scene by each method and prints what came of it.
pub(crate) fn compare(args: &Compare) -> Outcome {
    let mut specs: Vec<String> = args.methods.iter().chain(&args.with).cloned().collect();
    if specs.is_empty() {
        specs.extend(Method::NAMES.iter().map(|name| (*name).to_owned()));
    }
    // All settings are checked before the first run.
    for spec in &specs {
        configure(&mut WorldConfig::default(), args, spec)?;
    }
    let mut config = WorldConfig::default();
    set_all(&mut config, &args.set)?;
    let loaded = load(&args.source, said_gravity(&args.set, &config))?;
    let scene = loaded.scene();
    let hz = args.hz.unwrap_or(scene.hz);
    let steps = args.length.steps(scene.seconds, hz);
    let mut files = Files::create(args)?;
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    for spec in &specs {
        let mut scene = scene.clone();
        configure(&mut scene.config, args, spec)?;
        let (row, curve) = run(&scene, spec, args, hz, steps)?;
        rows.push(row);
        curves.push(curve);
    }
    let whole =
        Comparison { scene: &args.source.scene, hz, steps, threads: args.threads, runs: &rows };
    files.write(&whole, &curves)?;
    output::print(&text(&whole))?;
    Ok(ExitCode::SUCCESS)
}

/// `METHOD` or `METHOD:KEY=VALUE,KEY=VALUE`, over what `--set` says.
fn configure(config: &mut WorldConfig, args: &Compare, spec: &str) -> Result<(), Failure> {
    let (name, settings) = spec.split_once(':').unwrap_or((spec, ""));
    let mut pairs = vec![("method".to_owned(), name.trim().to_owned())];
    for setting in settings.split(',').filter(|s| !s.trim().is_empty()) {
        let Some((key, value)) = setting.split_once('=') else {
            return Err(Failure::usage(format_args!(
                "--with {spec}: '{setting}', expected METHOD:KEY=VALUE,KEY=VALUE"
            )));
        };
        pairs.push((key.trim().to_owned(), value.trim().to_owned()));
    }
    set_all(config, &args.set)?;
    for (key, value) in &pairs {
        config
            .set(key, value)
            .map_err(|e| Failure::usage(format_args!("--with {spec}: {key}={value}: {e}")))?;
    }
    Ok(())
}

fn run(
    scene: &Scene,
    spec: &str,
    args: &Compare,
    hz: f32,
    steps: u64,
) -> Result<(Row, Curve), Failure> {
    let mut running = build(scene, &args.source.scene)?;
    running.world.set_executor(executor(usize::from(args.threads)));
    let dt = hz.recip();
    // In a copy, for to know the contacts takes a step.
    let mut ahead = running.world.clone();
    ahead.step(1.0e-6);
    let warnings = ahead.warnings(dt);
    let mut measure = Measure::new(&running.world);
    let mut curve = Curve::new(spec);
    let every = steps.div_ceil(compare_plot::POINTS).max(1);
    let mut sweeps = 0_u64;
    for step in 1..=steps {
        running.before_step(dt).map_err(|e| refused(&args.source.scene, &e))?;
        let start = Instant::now();
        running.world.step(dt);
        let spent = start.elapsed();
        running.after_step();
        measure.add(step, spent, &running.world);
        sweeps += u64::from(running.world.sweep_count());
        if step.is_multiple_of(every) {
            let seconds = time_of(step, hz);
            curve.push(seconds, measure.penetration.last(), measure.energy_end.kinetic);
        }
    }
    let row = judge(scene, spec, &running, &measure, sweeps, args);
    let off_analytic = off_analytic(&running.world, &running.bodies, dt);
    Ok((Row { warnings, off_analytic, ..row }, curve))
}

/// Most contacts of a world for which the analytic method runs.
const MOST_CONTACTS: usize = 2000;

/// How far the world's method is from the analytic one in its next step.
fn off_analytic(world: &World, bodies: &[drystone::BodyId], dt: f32) -> Option<f64> {
    let scale = f64::from(world.config().gravity.length() * dt);
    if world.contacts().count() > MOST_CONTACTS || !(scale > 0.0) {
        return None;
    }
    let mut config = world.config().clone();
    config.sleep.enabled = false;
    let (mut here, mut there) = (world.clone(), world.clone());
    here.set_config(config.clone()).ok()?;
    // Overlaps are none of its business: what each method does about them differs by intent.
    let options = MethodOptions { overlap: Overlap::Nothing, ..MethodOptions::default() };
    config.method = Method::analytic().with_options(options).ok()?;
    config.substeps = 0;
    there.set_config(config).ok()?;
    here.step(dt);
    there.step(dt);
    if !there.warnings(dt).is_empty() {
        return None;
    }
    let velocity = |world: &World, id: drystone::BodyId| Some(world.body(id)?.linear_velocity());
    let off = bodies.iter().filter_map(|id| {
        Some(f64::from((velocity(&here, *id)? - velocity(&there, *id)?).length()))
    });
    Some(off.fold(0.0, f64::max) / scale)
}

fn judge(
    scene: &Scene,
    spec: &str,
    running: &Running,
    measure: &Measure,
    sweeps: u64,
    args: &Compare,
) -> Row {
    let world = &running.world;
    let bodies: Vec<&SceneBody> =
        scene.bodies.iter().chain(scene.script.joining()).take(running.brought().len()).collect();
    let states: Vec<BodyState> = running.brought().iter().map(|id| state(world, *id)).collect();
    let source = &args.source.scene;
    let stands = if args.stands {
        still_stands(scene.config.gravity, &bodies, &states, 0.0)
    } else {
        stands(source, scene, &bodies, &states)
    };
    let up = (-scene.config.gravity).normalize_or(Vec3::Y);
    let (mut drift, mut sink, mut speed) = (0.0_f32, 0.0_f32, 0.0_f32);
    for (body, state) in bodies.iter().zip(&states) {
        if body.def.kind == BodyKind::Dynamic {
            let moved = state.pose.position - body.def.position;
            let rise = moved.dot(up);
            drift = drift.max((moved - up * rise).length());
            sink = sink.max(-rise);
            speed = speed.max(state.linear_velocity.length());
        }
    }
    let config = world.config();
    let start = measure.energy_start.total();
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^52")]
    let sweeps = sweeps as f64 / world.step_count().max(1) as f64;
    Row {
        run: one_line(spec),
        method: config.method.name(),
        substeps: if config.substeps > 0 { config.substeps } else { config.method.substeps() },
        ms_per_step: measure.step_ms.percentile(50),
        sweeps,
        penetration_max: measure.penetration.max(),
        penetration_end: measure.penetration.last(),
        joint_error_max: measure.joint_error.max(),
        speed_end: f64::from(speed),
        kinetic_end: measure.energy_end.kinetic,
        energy_change: measure.energy_end.total() - start,
        energy_gain: measure.energy_max - start,
        drift: f64::from(drift),
        sink: f64::from(sink),
        off_analytic: None,
        stands,
        faults: measure.faults.len(),
        warnings: Vec::new(),
        hash: format!("{:016x}", world.state_hash()),
    }
}

fn state(world: &World, id: drystone::BodyId) -> BodyState {
    world.body(id).map_or(
        BodyState {
            pose: drystone::Pose::at(Vec3::splat(f32::NAN)),
            linear_velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
        },
        |b| BodyState {
            pose: b.pose(),
            linear_velocity: b.linear_velocity(),
            angular_velocity: b.angular_velocity(),
        },
    )
}

/// The table for people.
fn text(whole: &Comparison<'_>) -> String {
    let name = whole.runs.iter().map(|r| r.run.chars().count()).max().unwrap_or(0).max(3);
    let mut text = format!(
        "{}: {} steps at {} Hz, {} thread{}\n",
        one_line(whole.scene),
        whole.steps,
        whole.hz,
        whole.threads,
        if whole.threads == 1 { "" } else { "s" }
    );
    let _ = writeln!(
        text,
        "{:<name$}  {:>8} {:>7} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9} {:>9} {:>12}  {:<6}  hash",
        "run",
        "ms/step",
        "sweeps",
        "deepest mm",
        "end mm",
        "speed m/s",
        "kinetic J",
        "gained J",
        "drift m",
        "sink m",
        "off analytic",
        "stands"
    );
    for r in whole.runs {
        let stands = match (r.faults, r.stands) {
            (1.., _) => "fault",
            (_, Some(true)) => "yes",
            (_, Some(false)) => "no",
            (_, None) => "-",
        };
        let _ = writeln!(
            text,
            "{:<name$}  {:>8.4} {:>7.1} {:>10.4} {:>10.4} {:>10.2e} {:>10.2e} {:>10.2e} {:>9.2e} {:>9.2e} {:>12}  {:<6}  {}",
            r.run,
            r.ms_per_step,
            r.sweeps,
            1.0e3 * r.penetration_max,
            1.0e3 * r.penetration_end,
            r.speed_end,
            r.kinetic_end,
            r.energy_gain,
            r.drift,
            r.sink,
            r.off_analytic.map_or_else(|| "-".to_owned(), |off| format!("{off:.2e}")),
            stands,
            r.hash
        );
    }
    for r in whole.runs {
        for warning in &r.warnings {
            let _ = writeln!(text, "warning: {}: {warning}", r.run);
        }
    }
    text
}

fn csv(rows: &[Row]) -> String {
    let mut text = "run,method,substeps,ms_per_step,sweeps,penetration_max_m,penetration_end_m,\
                    joint_error_max_m,speed_end_m_s,kinetic_end_J,energy_change_J,energy_gain_J,\
                    drift_m,sink_m,off_analytic,stands,faults,hash\n"
        .to_owned();
    for r in rows {
        let stands = r.stands.map_or("", |s| if s { "yes" } else { "no" });
        let _ = writeln!(
            text,
            "\"{}\",{},{},{},{},{},{},{},{},{},{},{},{},{},{},{stands},{},{}",
            r.run.replace('"', "\"\""),
            r.method,
            r.substeps,
            r.ms_per_step,
            r.sweeps,
            r.penetration_max,
            r.penetration_end,
            r.joint_error_max,
            r.speed_end,
            r.kinetic_end,
            r.energy_change,
            r.energy_gain,
            r.drift,
            r.sink,
            r.off_analytic.map_or_else(String::new, |off| off.to_string()),
            r.faults,
            r.hash
        );
    }
    text
}

/// The output files, opened before the first run.
#[derive(Debug)]
struct Files {
    json: Option<Output>,
    csv: Option<Output>,
    svg: Option<Output>,
    png: Option<Output>,
}

impl Files {
    fn create(args: &Compare) -> Result<Self, Failure> {
        output::leave_on_interrupt();
        Ok(Self {
            json: args.json.as_deref().map(Output::create).transpose()?,
            csv: args.csv.as_deref().map(Output::create).transpose()?,
            svg: args.svg.as_deref().map(Output::create).transpose()?,
            png: args.png.as_deref().map(Output::create).transpose()?,
        })
    }

    fn write(&mut self, whole: &Comparison<'_>, curves: &[Curve]) -> Result<(), Failure> {
        let put = |file: Option<Output>, bytes: Vec<u8>| -> Result<(), Failure> {
            if let Some(mut file) = file {
                file.write(&bytes)?;
                file.finish()?;
            }
            Ok(())
        };
        if self.json.is_some() {
            let json = serde_json::to_string_pretty(whole)
                .map_err(|e| Failure::failed(format_args!("report: {e}")))?;
            put(self.json.take(), (json + "\n").into_bytes())?;
        }
        put(self.csv.take(), csv(whole.runs).into_bytes())?;
        let plot = compare_plot::svg(whole.scene, curves);
        if self.png.is_some() {
            put(self.png.take(), compare_plot::png(&plot)?)?;
        }
        put(self.svg.take(), plot.into_bytes())
    }
}
