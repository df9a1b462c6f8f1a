//! Runs a program from the first operation to the last, and checks all properties that must hold.

use std::panic::AssertUnwindSafe;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

use drystone::World;
use drystone::threads::{Executor, Inline, SimdLevel, Team};

use crate::apply::{Done, Ids, apply};
use crate::calls::{Past, Written};
use crate::finding::{Findings, Kind};
use crate::op::{Op, Program, Style};
use crate::oracle::{self, Pairs};

/// Conditions of a run. None of them may change its result.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Number of threads; 1 is the caller alone.
    pub threads: usize,
    /// Index of the SIMD level, counted from the best; larger indices select the last level.
    pub level: usize,
    /// Interval in steps at which the run restarts from its own snapshot.
    pub restore_every: Option<u32>,
    /// Step after which the run continues as a clone.
    pub clone_at: Option<u32>,
    /// Interval in steps at which the run takes some extra steps and rolls back, alternately by a
    /// copy and by bytes.
    pub back_every: Option<u32>,
    /// Records calls as data in a journal, which is replayed at the end.
    pub written: bool,
    /// Runs all checks; otherwise only hashes are computed.
    pub look: bool,
    /// Whether faults and wild speeds of ordinary worlds are findings.
    pub strict: bool,
    /// Called with each operation before it is applied, and with each step.
    pub trace: Option<fn(&str)>,
    /// A planted fault, to test the search: worlds for which it returns true are findings.
    pub plant: Option<fn(&World) -> bool>,
}

impl Conditions {
    /// One thread, the best level, with all oracles.
    pub const BASE: Self = Self {
        threads: 1,
        level: 0,
        restore_every: None,
        clone_at: None,
        back_every: None,
        written: false,
        look: true,
        strict: false,
        trace: None,
        plant: None,
    };
}

/// Result of a run.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// A hash of the state and the events after each step.
    pub hashes: Vec<u64>,
    /// Operations that the engine refused.
    pub refused: u32,
    /// Whether each operation was done.
    pub done: Vec<bool>,
    /// Faults of bodies and particles.
    pub faults: u32,
    /// Whether a body exceeded any plausible speed.
    pub is_wild: bool,
    /// Failures.
    pub findings: Findings,
    /// Whether the run took too long and was ended early.
    pub is_cut: bool,
}

/// Maximum duration of a run; a slower one is ended early, which is not a finding.
const LONGEST: Duration = Duration::from_secs(3);

/// Interval in steps at which all getters are checked; they are also checked at the end.
const FULL_EVERY: u32 = 40;

/// Speed that no body of an ordinary world can reach [m/s].
const WILD: f32 = 1000.0;

/// Runs a program to its end, or until it panics.
#[must_use]
pub fn run(program: &Program, conditions: &Conditions) -> Run {
    let run = Mutex::new(Run::default());
    let caught = guarded(|| {
        let mut run = run.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        steps(program, conditions, &mut run);
    });
    let mut run = run.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Err(panic) = caught {
        let step = u32::try_from(run.hashes.len()).unwrap_or(u32::MAX);
        run.findings.add(Kind::Panic, panic.place, panic.message, step);
    }
    run
}

/// Place and message of a panic.
#[derive(Clone, Debug, Default)]
pub struct Panic {
    /// File and line.
    pub place: String,
    /// Message.
    pub message: String,
}

/// The first panic since the last check, including panics on a team's threads.
static LAST: Mutex<Option<Panic>> = Mutex::new(None);

/// Calls a function and returns the place of its panic, if any. Panics print nothing.
///
/// # Errors
/// Returns the place of the panic.
pub fn guarded<T>(act: impl FnOnce() -> T) -> Result<T, Panic> {
    static HOOK: OnceLock<()> = OnceLock::new();
    HOOK.get_or_init(|| std::panic::set_hook(Box::new(note)));
    let take = || LAST.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take();
    take();
    std::panic::catch_unwind(AssertUnwindSafe(act)).map_err(|_| take().unwrap_or_default())
}

/// Stores the place of a panic, unless it follows from an earlier one.
fn note(info: &std::panic::PanicHookInfo<'_>) {
    let place = info.location().map_or_else(String::new, |l| {
        let file = l.file().rsplit_once("crates/").map_or(l.file(), |(_, file)| file);
        format!("{file}:{}", l.line())
    });
    let payload = info.payload();
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    let message = text.unwrap_or("a panic without words").to_owned();
    let mut last = LAST.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    last.get_or_insert(Panic { place, message });
}

/// Teams that live as long as the process.
fn executor(threads: usize) -> Arc<dyn Executor> {
    static TEAMS: [OnceLock<Arc<Team>>; 5] = [const { OnceLock::new() }; 5];
    match TEAMS.get(threads) {
        Some(team) if threads > 1 => {
            Arc::clone(team.get_or_init(|| Arc::new(Team::with_threads(threads)))) as _
        }
        _ => Arc::new(Inline),
    }
}

fn equip(world: &mut World, conditions: &Conditions) {
    world.set_executor(executor(conditions.threads));
    let levels = SimdLevel::available();
    if let Some(level) = levels.get(conditions.level).or(levels.last()) {
        world.set_simd_level(*level);
    }
}

fn steps(program: &Program, conditions: &Conditions, run: &mut Run) {
    let Ok(mut world) = World::new(program.config.clone()) else {
        run.refused += 1;
        return;
    };
    equip(&mut world, conditions);
    let (mut ids, mut pairs) = (Ids::default(), Pairs::default());
    let mut past = Past::default();
    let mut written = conditions.written.then(|| Written::begin(&world));
    let start = Instant::now();
    let mut step = 0;
    for op in &program.ops {
        if let Some(trace) = conditions.trace {
            trace(&format!("step {step}: {op:?}"));
        }
        let Op::Step(dt, count) = op else {
            let done = match &mut written {
                Some(written) => written.apply(&mut world, &mut ids, op),
                None => apply(&mut world, &mut ids, op, &mut run.findings, step),
            };
            run.refused += u32::from(done == Done::Refused);
            run.done.push(done == Done::Yes);
            continue;
        };
        run.done.push(true);
        for _ in 0..*count {
            between(&mut world, conditions, step, run);
            if conditions.back_every.is_some_and(|n| step % n == n - 1) {
                past.there_and_back(&mut world, &mut run.findings, step);
            }
            match &mut written {
                Some(written) => written.step(&mut world, *dt),
                None => world.step(*dt),
            }
            step += 1;
            run.hashes.push(came_to(&world));
            ids.take_pieces(&world);
            if conditions.look {
                look(&world, &mut ids, &mut pairs, step, run);
                judge(&world, program.style, conditions, step, run);
            }
            if start.elapsed() > LONGEST {
                run.is_cut = true;
                return;
            }
        }
    }
    if let Some(written) = written {
        written.end(&world, &mut run.findings, step);
    }
    if conditions.look {
        oracle::full(&world, &mut run.findings, step);
        oracle::own_snapshot(&world, &mut run.findings, step);
        ids.gone.check(&world, &mut run.findings, step);
    }
}

/// A hash of the state and of the step's events.
fn came_to(world: &World) -> u64 {
    let events = world.events();
    let touches = events.contact_begin.iter().chain(&events.contact_end);
    let touches = touches.flat_map(|touch| [touch.shape_a, touch.shape_b]);
    let visits = events.sensor_enter.iter().chain(&events.sensor_exit);
    let visits = visits.flat_map(|visit| [visit.sensor, visit.visitor]);
    let shapes = touches.chain(visits).map(|shape| shape.index());
    let bodies = events.sleep.iter().chain(&events.wake).chain(&events.pieces);
    let bodies = bodies.map(|body| body.index());
    let hits = events.hits.iter().map(|hit| hit.point.x.to_bits());
    let ends = [events.contact_begin.len(), events.sensor_enter.len(), events.wake.len()];
    let others = [events.joint_break.len(), events.bond_break.len(), events.faults.len()];
    let counts = ends.into_iter().chain(others).map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    let words = shapes.chain(bodies).chain(hits).chain(counts);
    words.fold(world.state_hash(), |hash, word| crate::rng::mix(hash ^ u64::from(word)))
}

/// Continues from a snapshot or as a clone, if the conditions require it.
fn between(world: &mut World, conditions: &Conditions, step: u32, run: &mut Run) {
    if conditions.restore_every.is_some_and(|n| step % n == n - 1) {
        match World::restore(&world.snapshot()) {
            Ok(again) => *world = again,
            Err(why) => run.findings.add(Kind::SnapshotRefused, why.to_string(), "", step),
        }
        equip(world, conditions);
    }
    if conditions.clone_at == Some(step) {
        let clone = world.clone();
        // Steps of the original must not affect the clone.
        world.step(1.0 / 60.0);
        *world = clone;
    }
}

fn look(world: &World, ids: &mut Ids, pairs: &mut Pairs, step: u32, run: &mut Run) {
    pairs.follow(world, &mut run.findings, step);
    if step % FULL_EVERY == 1 {
        oracle::full(world, &mut run.findings, step);
        ids.gone.check(world, &mut run.findings, step);
    } else {
        oracle::quick(world, &mut run.findings, step);
    }
    if step % (2 * FULL_EVERY) == 1 {
        oracle::own_snapshot(world, &mut run.findings, step);
    }
}

/// Counts failures of the motion rather than of the bookkeeping.
fn judge(world: &World, style: Style, conditions: &Conditions, step: u32, run: &mut Run) {
    let faults = world.events().faults.iter();
    let faults = faults.filter(|f| f.kind == drystone::events::FaultKind::NotFinite).count();
    run.faults += u32::try_from(faults).unwrap_or(u32::MAX);
    let speed = oracle::fastest(world);
    run.is_wild |= speed > WILD;
    if conditions.plant.is_some_and(|is_planted| is_planted(world)) {
        run.findings.add(Kind::Fault, "planted", "", step);
    }
    if conditions.strict && style == Style::Ordinary {
        if faults > 0 {
            let fault = format!("{:?}", world.events().faults[0]);
            run.findings.add(Kind::Fault, "a fault of an ordinary world", fault, step);
        }
        if speed > WILD {
            let speed = format!("{speed} m/s");
            run.findings.add(Kind::Wild, "a wild speed in an ordinary world", speed, step);
        }
    }
}
