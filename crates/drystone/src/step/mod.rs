//! One time step: nine stages over the world's tables, always in this order. Read this first.

pub(crate) mod context;
pub(crate) mod broadphase;
pub(crate) mod narrowphase;
pub(crate) mod partition;
pub(crate) mod particles;
pub(crate) mod solver;
pub(crate) mod finalize;
pub(crate) mod sweep;
pub(crate) mod hooks;
pub(crate) mod reach;
pub(crate) mod one_way;
pub(crate) mod sensor;
pub(crate) mod impulses;
pub(crate) mod sleep;
pub(crate) mod caps;
pub(crate) mod flight;
pub(crate) mod gyration;
pub(crate) mod load_inertia;
pub(crate) mod notes;
pub(crate) mod softness;
pub(crate) mod solver_body;

use self::context::StepContext;
use self::hooks::Hooks;
use self::notes::Note;
use self::particles::pace::Pace;
use self::particles::settle::settle;
use crate::base::jobs::Jobs;
use crate::state::config::SleepConfig;
use crate::state::events::{Fault, FaultKind};
use crate::state::sets::Sets;
use crate::state::stillness::StillnessRule;
use crate::state::tables::Tables;

/// A stage of the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Stage {
    /// New pairs of shapes.
    Broadphase,
    /// Contact manifolds.
    Narrowphase,
    /// Islands and colors.
    Partition,
    /// What particles meet, and free ones.
    Particles,
    /// Velocities and impulses.
    Solver,
    /// Poses and bounds.
    Finalize,
    /// Fast bodies.
    Sweep,
    /// Sensors and the order of events.
    Sensor,
    /// Sleep.
    Sleep,
}

impl Stage {
    /// All stages, in order.
    pub const ALL: &'static [Self] = &[
        Self::Broadphase,
        Self::Narrowphase,
        Self::Partition,
        Self::Particles,
        Self::Solver,
        Self::Finalize,
        Self::Sweep,
        Self::Sensor,
        Self::Sleep,
    ];

    /// Its name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Broadphase => "broadphase",
            Self::Narrowphase => "narrowphase",
            Self::Partition => "partition",
            Self::Particles => "particles",
            Self::Solver => "solver",
            Self::Finalize => "finalize",
            Self::Sweep => "sweep",
            Self::Sensor => "sensor",
            Self::Sleep => "sleep",
        }
    }
}

/// Memory of the stages, kept from step to step. Nothing in it outlives a step in meaning.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    broadphase: broadphase::Scratch,
    narrowphase: narrowphase::scratch::Scratch,
    partition: partition::Scratch,
    particles: particles::scratch::Scratch,
    solver: solver::scratch::Scratch,
    finalize: finalize::Scratch,
    sweep: sweep::Scratch,
    impulses: impulses::Scratch,
    sleep: sleep::Scratch,
}

impl Scratch {
    /// Is that of tables which are a copy of those that `from` is of: what it knows of other ones is forgotten.
    pub(crate) fn start_from(&mut self, from: &Self, copy: &mut Tables) {
        self.solver.start_from(&from.solver);
        self.particles.start_from(&from.particles, &mut copy.bodies);
        // The plan of the solver is to be made anew.
        copy.colors.bodies_changed = true;
    }

    /// Sweeps over the contacts in the last step.
    pub(crate) const fn sweeps(&self) -> u32 {
        self.solver.sweeps
    }

    /// What the contacts gave in the last step that landed or are asked for.
    pub(crate) fn given(&self) -> impl Iterator<Item = solver::totals_rows::Given> {
        self.solver.given()
    }

    /// Relative residual of the contacts in the last step, of the analytic method, and whether they were
    /// too many for it.
    pub(crate) fn residual(&self) -> (f64, bool) {
        self.solver.residual()
    }
}

/// The step. `after` is told of every stage that is done.
pub(crate) fn step(
    ctx: &StepContext,
    tables: &mut Tables,
    scratch: &mut Scratch,
    jobs: &Jobs<'_>,
    hooks: Option<&Hooks<'_>>,
    after: &mut dyn FnMut(Stage),
) {
    // Before anything wakes in this step.
    tables.islands.wake_alone = tables.config.method.freezes();
    tables.islands.gentle_speed = sleep::freeze::rest_speed(ctx, tables.config.sleep_speed());
    tables.islands.length = ctx.length;
    let Tables {
        config,
        bodies,
        shapes,
        joints,
        particles,
        contacts,
        bounds,
        islands,
        colors,
        events,
        breakage,
        ..
    } = tables;
    let s = scratch;

    broadphase::find_pairs(ctx, bodies, shapes, joints, contacts, bounds, &mut s.broadphase, jobs);
    after(Stage::Broadphase);
    narrowphase::update_manifolds(ctx, bodies, shapes, contacts, &mut s.narrowphase, hooks, jobs);
    after(Stage::Narrowphase);
    let mut sets = Sets { bodies, joints, contacts, islands, colors, events };
    partition::apply_touch_changes(&s.narrowphase, shapes, &mut sets, &mut s.partition, jobs);
    partition::relax_levels(tables.steps, &mut sets, &mut s.partition, jobs);
    after(Stage::Partition);
    particles::meet_shapes(ctx, particles, shapes, bounds, &mut sets, &mut s.particles, jobs);
    after(Stage::Particles);
    let Sets { bodies, joints, contacts, islands, colors, events } = sets;
    let method = &config.method;
    let breakage = joints.breakable > 0 || breakage.any();
    let closing = &s.narrowphase;
    let read = solver::input::Input { bodies, shapes, islands, closing, breakage };
    let [loaded, jointed, struck, tumbling] = &ctx.finer(config);
    let contexts = [ctx, loaded, jointed, struck, tumbling];
    let pace = Pace::new(ctx, config, particles.last_h);
    let mut tied = s.particles.tied(pace, particles);
    solver::solve(contexts, method, read, joints, contacts, colors, &mut s.solver, &mut tied, jobs);
    after(Stage::Solver);
    let sleep = &config.sleep;
    let (enabled, time) = (sleep.enabled && method.sleeps(), sleep.wait(ctx.dt));
    let rest = SleepConfig { enabled, time, speed: config.sleep_speed() };
    let (gravity, length, dt) = (ctx.gravity, ctx.length, ctx.dt);
    let rule = StillnessRule { gravity, length, speed: rest.speed, time, dt };
    finalize::advance_poses(
        ctx,
        (&rule, islands.wake_alone),
        bodies,
        shapes,
        bounds,
        &s.solver,
        &mut s.finalize,
        jobs,
    );
    after(Stage::Finalize);
    let (fast, links) = (s.finalize.flights(), (&*contacts, &*joints, hooks));
    sweep::stop_fast_bodies(ctx, fast, links, bodies, shapes, bounds, &mut s.sweep, jobs);
    after(Stage::Sweep);
    let around = (&*shapes, &*bounds);
    let ends = (&mut *events, tables.steps + 1, pace.h);
    settle(ctx, &rest, particles, bodies, around, ends, &mut s.particles, jobs);
    let mut sets = Sets { bodies, joints, contacts, islands, colors, events };
    let found = (s.solver.begun(), s.sweep.crossed());
    sensor::report_touches(found, shapes, &mut sets);
    let (given, least) = (s.solver.given(), (ctx.dt, ctx.hit_speed));
    impulses::report_given(given, least, shapes, &mut sets, &mut s.impulses);
    quarantine(&mut sets, s.finalize.notes(), tables.steps + 1);
    after(Stage::Sensor);
    let still = s.finalize.notes();
    let rule = (&rest, rule.spacing());
    let around = (&*shapes, tables.steps);
    sleep::rest_still_islands(ctx, rule, still, around, &mut sets, &mut s.sleep, jobs);
    after(Stage::Sleep);
}

/// Takes bodies with a non-finite state out of the awake sets, and reports them.
fn quarantine(sets: &mut Sets<'_>, notes: impl Iterator<Item = Note>, step: u64) {
    for note in notes {
        if let Note::Fault(row) = note {
            sets.rest(&[row]);
            let body = sets.bodies.at_mut(row);
            (body.out, body.faulted) = (true, true);
            let body = Some(sets.bodies.id(row));
            sets.events.faults.push(Fault {
                body,
                joint: None,
                particle: None,
                kind: FaultKind::NotFinite,
                step,
            });
        }
    }
}
