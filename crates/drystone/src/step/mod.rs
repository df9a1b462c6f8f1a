//! One time step: ten stages over the world's tables, always in this order. Read this first.

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
pub(crate) mod touches;
pub(crate) mod sleep;
pub(crate) mod report;
pub(crate) mod flight;
pub(crate) mod gyration;
pub(crate) mod notes;
pub(crate) mod solver_body;
pub(crate) mod classic;

use self::context::StepContext;
use self::hooks::Hooks;
use self::particles::pace::Pace;
use self::particles::settle::settle;
use self::report::Found;
use self::sleep::begin_step;
use self::solver::input::Input;
use crate::base::threads::jobs::Jobs;
use crate::state::sets::Sets;
use crate::state::tables::{Others, Tables};

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
    /// Contacts of particles, and the motion of free particles.
    Particles,
    /// Velocities and impulses.
    Solver,
    /// Poses and bounds.
    Finalize,
    /// Fast bodies.
    Sweep,
    /// Sleep.
    Sleep,
    /// Events.
    Report,
    /// Joints, bonds and bodies that break.
    Breakage,
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
        Self::Sleep,
        Self::Report,
        Self::Breakage,
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
            Self::Sleep => "sleep",
            Self::Report => "report",
            Self::Breakage => "breakage",
        }
    }
}

/// Memory of the stages, kept from step to step for its capacity. No result depends on its
/// contents.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    broadphase: broadphase::Scratch,
    narrowphase: narrowphase::scratch::Scratch,
    partition: partition::Scratch,
    particles: particles::scratch::Scratch,
    solver: solver::scratch::Scratch,
    finalize: finalize::Scratch,
    sweep: sweep::Scratch,
    sleep: sleep::Scratch,
    report: report::Scratch,
}

impl Scratch {
    /// Prepares this scratch for `copy`, a copy of the tables that `from` belongs to. Everything
    /// stored about other tables is discarded.
    pub(crate) fn start_from(&mut self, from: &Self, copy: &mut Tables) {
        self.solver.start_from(&from.solver);
        self.particles.start_from(&from.particles, &mut copy.bodies);
        // The solver must make its plan anew.
        copy.colors.bodies_changed = true;
    }

    /// The findings of all stages, and the memory for their report.
    fn findings(&mut self) -> (Found<'_>, &mut report::Scratch) {
        let Self { partition, particles, solver, finalize, sweep, report, .. } = self;
        (Found { partition, particles, solver, finalize, sweep }, report)
    }

    /// Sweeps over the contacts in the last step.
    pub(crate) const fn sweeps(&self) -> u32 {
        self.solver.sweeps()
    }

    /// Impulses of the last step's contacts that landed, or whose forces are reported.
    pub(crate) fn given(&self) -> impl Iterator<Item = solver::totals_rows::ContactTotals> {
        self.solver.given()
    }

    /// Relative residual of the contacts in the last step (analytic method), and whether there were
    /// too many contacts for that method.
    pub(crate) fn residual(&self) -> (f64, bool) {
        self.solver.residual()
    }
}

/// Runs one step. [`World`](crate::World) runs the tenth stage, breakage, itself. Calls `after` at
/// the end of each stage.
pub(crate) fn step(
    ctx: &StepContext,
    tables: &mut Tables,
    s: &mut Scratch,
    jobs: &Jobs<'_>,
    hooks: Option<&Hooks<'_>>,
    after: &mut dyn FnMut(Stage),
) {
    let (mut sets, others) = tables.lend();
    let Others { config, shapes, articulations, particles, bounds, breakage, steps } = others;
    let pace = Pace::new(ctx, config, particles.last_h);

    begin_step(ctx, sets.islands);
    let Sets { bodies, joints, contacts, .. } = &mut sets;
    broadphase::find_pairs(ctx, bodies, shapes, joints, contacts, bounds, &mut s.broadphase, jobs);
    after(Stage::Broadphase);
    narrowphase::update_manifolds(ctx, bodies, shapes, contacts, &mut s.narrowphase, hooks, jobs);
    after(Stage::Narrowphase);
    partition::apply_changes(steps, &s.narrowphase, shapes, &mut sets, &mut s.partition, jobs);
    after(Stage::Partition);
    particles::meet_shapes(ctx, particles, shapes, bounds, &mut sets, &mut s.particles, jobs);
    after(Stage::Particles);
    let Sets { bodies, joints, contacts, islands, colors, .. } = &mut sets;
    let read = Input::new(bodies, shapes, islands, &s.narrowphase, breakage, joints);
    let tied = &mut s.particles.tied(pace, particles);
    let solved = (&mut **joints, articulations, &mut **contacts, &mut **colors);
    solver::solve(ctx, config, read, solved, &mut s.solver, tied, jobs);
    after(Stage::Solver);
    let solved = &s.solver.solved;
    finalize::advance_poses(ctx, sets.bodies, shapes, bounds, solved, &mut s.finalize, jobs);
    after(Stage::Finalize);
    let read = (&s.finalize, &*sets.contacts, &*sets.joints, hooks);
    sweep::stop_fast_bodies(ctx, read, sets.bodies, shapes, bounds, &mut s.sweep, jobs);
    settle(ctx, pace.h, particles, sets.bodies, shapes, bounds, &mut s.particles, jobs);
    after(Stage::Sweep);
    sleep::rest_still_islands(ctx, steps, &s.finalize, shapes, &mut sets, &mut s.sleep, jobs);
    after(Stage::Sleep);
    let (found, report) = s.findings();
    report::report(ctx, steps + 1, found, shapes, particles, &mut sets, report);
    after(Stage::Report);
}
