//! Runs the default methods: rows of contacts and joints in blocks of eight, swept color by color.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use fearless_simd::dispatch;

use super::body::integrate;
use super::body::row::Aux;
use super::contact::arena::{Blocks, Buffers};
use super::contact::lent::{ContactRows, Needs};
use super::contact::sweep::ContactSweep;
use super::contact::{store, sweep};
use super::input::Input;
use super::joint::sweep::JointSweep;
use super::lent::Solver;
use super::pass::Progress;
use super::plan::group::Group;
use super::scratch::Scratch;
use super::totals_rows::SumRequests;
use super::{Tables, with_particles};
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, for_each_in_buffer, for_shares};
use crate::state::def::config::WorldConfig;
use crate::state::def::method::Pass;
use crate::step::context::StepContext;
use crate::step::context::softness::Softness;
use crate::step::particles::tied::Tied;
use crate::step::solver_body::SolverBody;

/// Runs the method's passes: plans groups of islands, allocates their rows, and lets a worker take
/// each group through the step. There is one context for each
/// [`Subdivision`](crate::state::bodies::body::Fineness) of islands.
pub(crate) fn solve(
    ctx: &StepContext,
    config: &WorldConfig,
    input: Input<'_>,
    (joints, articulations, contacts, colors): Tables<'_>,
    scratch: &mut Scratch,
    tied: &mut Tied<'_>,
    jobs: &Jobs<'_>,
) {
    let s = scratch;
    let method = &config.method;
    let [loaded, jointed, struck, tumbling] = &ctx.finer(config);
    let contexts = [ctx, loaded, jointed, struck, tumbling];
    let Input { bodies, shapes, islands, closing, breakage } = input;
    s.sweeps = method.wide_sweeps(ctx.substeps);
    s.plan.choose_subdivision(bodies, joints, contacts, islands, closing.closing(), contexts, jobs);
    s.plan.choose_turning(bodies, contacts, shapes, (closing, ctx.dt));
    s.plan.take_back(bodies, joints, contacts, islands, struck, jobs);
    let workers = jobs.workers().max(1);
    let parts = contexts.map(|ctx| ctx.parts);
    s.plan.update(
        (bodies, articulations),
        joints,
        contacts,
        colors,
        &mut s.solved.solver_row_of,
        ctx.tree_ratio,
        parts,
        jobs,
    );
    let [corotates, parts, has_impacts] = closing.listed();
    let sum_requests = SumRequests { bodies, shapes, breakage };
    let has_extras = colors.special > 0 || corotates;
    let needs = Needs {
        extras: has_extras,
        impacts: has_impacts,
        corotates,
        parts,
        peaks: sum_requests.any(),
    };
    s.solved.allocate(&s.plan, has_extras);
    s.contact.allocate(&s.plan, needs);
    s.joint.allocate(&s.plan, breakage);
    s.tree.allocate(&s.plan, breakage);
    s.make_impacts(has_extras || has_impacts);
    with_particles::find_groups(&s.plan, &s.solved.solver_row_of, tied.scratch);
    s.progress.resize(tied.scratch.groups.len(), Progress::default());
    // SAFETY: groups share no constraint and no body that can be pushed. In a group that several
    // workers share, a pass runs over bodies, or over colors, each of which touches such a body
    // once.
    let apart = unsafe { Apart::promise() };
    let (slots, softened) = contacts.solved_mut(apart);
    let plan = &s.plan;
    let keep = !tied.scratch.groups.is_empty();
    let (contact, of_workers) = s.contact.lend(plan, needs, (workers, keep), apart);
    let Buffers { first, blocks: buffers, size } = of_workers;
    let solver = Solver {
        ctx,
        method,
        plan,
        round: 0,
        sum_requests,
        bodies,
        shapes,
        contacts: slots,
        softened,
        joint_slots: Rows::new(joints.rows.values_mut(), apart),
        body: s.solved.lend(apart),
        contact,
        joint: s.joint.lend(apart),
        tree: s.tree.lend(apart),
        articulation: s.articulation.lend(plan, articulations, apart),
        impacts: Rows::new(&mut s.impacts, apart),
        progress: Rows::new(&mut s.progress, apart),
    };
    let solver_of = |number: usize| Solver {
        ctx: contexts[plan.groups[number].subdivision as usize],
        ..solver
    };
    solver.solve_with_particles(tied, jobs);
    let groups = &tied.scratch.groups;
    for number in (0..plan.shared).filter(|number| groups.binary_search(number).is_err()) {
        solver_of(number).solve(number, jobs);
    }
    for_each_in_buffer(jobs, plan.groups.len() - plan.shared, buffers, size, |buffer, number| {
        let number = plan.shared + number;
        if groups.binary_search(&number).is_err() {
            let range = plan.contacts.blocks_of(&plan.groups[number].contacts);
            let blocks = if range.end <= first {
                solver.contact.blocks
            } else {
                Blocks::new(&mut buffer[..range.len()], range.start, apart)
            };
            let contact = ContactRows { blocks, ..solver.contact };
            Solver { contact, ..solver_of(number) }.solve(number, &Jobs::Inline);
        }
    });
}

impl Solver<'_> {
    /// Runs a sweep of a pass over the colors.
    pub(crate) fn sweep(&self, group: &Group, pass: Pass, substep: u32, jobs: &Jobs<'_>) {
        let ctx = self.ctx;
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let elapsed = substep as f32 * ctx.h;
        // A relax pass within a substep follows the position update.
        let moved = elapsed + if substep < ctx.substeps { ctx.h } else { 0.0 };
        let sweep = |softness, inner, elapsed| ContactSweep {
            inv_h: ctx.inv_h,
            softness,
            relaxes: pass == Pass::Relax,
            cap: ctx.push_speed,
            hit: sweep::HIT_SPEED * ctx.length,
            inner,
            elapsed,
        };
        match pass {
            Pass::Solve { inner } => {
                let inner = inner.clamp(1, 8);
                let joints = JointSweep::solving(ctx, elapsed);
                self.sweep_couplings(group, &joints);
                self.sweep_joints(group, &joints, jobs);
                self.sweep_six_dof(group, &joints, jobs);
                self.sweep_trees(group, &joints, jobs);
                let sweeps =
                    [sweep(ctx.soft, inner, elapsed), sweep(ctx.soft_fixed, inner, elapsed)];
                self.sweep_contacts(group, &sweeps, false, jobs);
            }
            Pass::Relax => {
                let joints = JointSweep::relaxing(ctx, moved);
                self.sweep_couplings(group, &joints);
                self.sweep_joints(group, &joints, jobs);
                self.sweep_six_dof(group, &joints, jobs);
                self.sweep_trees(group, &joints, jobs);
                let rigid = sweep(Softness::RIGID, 1, moved);
                self.sweep_contacts(group, &[rigid, rigid], true, jobs);
            }
            // Passes over bodies or islands, and passes of the classic methods.
            _ => {}
        }
    }

    pub(crate) fn accelerate(&self, group: &Group, jobs: &Jobs<'_>, first: bool) {
        self.for_bodies(group, jobs, &|solver_bodies, aux| {
            for (solver_body, aux) in solver_bodies.iter_mut().zip(aux) {
                integrate::velocities(solver_body, aux, first);
            }
        });
    }

    pub(crate) fn advance(&self, group: &Group, jobs: &Jobs<'_>) {
        let h = self.ctx.h;
        self.for_bodies(group, jobs, &|solver_bodies, aux| {
            for (solver_body, aux) in solver_bodies.iter_mut().zip(aux) {
                integrate::positions(solver_body, h);
                integrate::velocities(solver_body, aux, false);
            }
        });
    }

    pub(crate) fn drift(&self, group: &Group, jobs: &Jobs<'_>) {
        let h = self.ctx.h;
        self.for_bodies(group, jobs, &|solver_bodies, _| {
            for solver_body in solver_bodies {
                integrate::positions(solver_body, h);
            }
        });
    }

    fn for_bodies(
        &self,
        group: &Group,
        jobs: &Jobs<'_>,
        f: &(dyn Fn(&mut [SolverBody], &mut [Aux]) + Sync),
    ) {
        let n = group.solver_rows.len();
        for_shares(jobs, n, 256, |part| {
            let part = group.solver_rows.start + part.start..group.solver_rows.start + part.end;
            f(self.body.solver_bodies.slice(part.clone()), self.body.aux.slice(part));
        });
    }

    /// Sums the normal impulses that squeeze each body.
    fn weigh(&self, group: &Group, jobs: &Jobs<'_>) {
        let scale = self.ctx.store_scale();
        self.plan.contacts.for_blocks(&group.contacts, jobs, 64, |_, blocks| {
            dispatch!(self.ctx.level, simd => {
                for i in blocks {
                    store::weigh(simd, self.contact.blocks.read(i), &self.body.squeezes, scale);
                }
            });
        });
    }

    pub(crate) fn store(&self, group: &Group, jobs: &Jobs<'_>) {
        let tables = (&self.contacts, self.bodies);
        if self.ctx.inertia.is_on() {
            self.weigh(group, jobs);
        }
        let blocks = self.plan.contacts.blocks_of(&group.contacts);
        let n = blocks.len();
        for_shares(jobs, n, 32, |part| {
            dispatch!(self.ctx.level, simd => {
                for i in blocks.start + part.start..blocks.start + part.end {
                    let extra = if self.contact.has_extras { Some(self.contact.extras.read(i)) } else { None };
                    let owners = &self.plan.contacts.owners[i];
                    self.prefetch_contacts(i + 1);
                    let block = self.contact.blocks.read(i);
                    let begun = self.contact.begun.row(i);
                    let when = (self.ctx, None);
                    *begun |= store::store(simd, block, extra, (owners, *begun), tables, when);
                    self.end_tally(i);
                }
            });
        });
        self.store_tallies(group);
        self.store_joints(group, jobs);
        self.store_couplings(group);
        self.store_trees(group);
        self.store_six_dof(group, jobs);
    }
}
