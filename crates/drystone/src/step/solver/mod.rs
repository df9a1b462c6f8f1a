//! The stage `solver`: contacts and joints to velocities and poses' changes, by the passes of the method.
//!
//! Reads: bodies (state), shapes (surface velocities), contacts (manifolds), joints, colors. Writes: contacts and joints (impulses),
//! solver lines. Runs: groups of small islands side by side, one worker a group; in a large island
//! parallel over bodies, and over the blocks of one color after the other. Invariants: a color touches
//! a dynamic body once; groups share no dynamic body; blocks are eight wide everywhere; the order of
//! colors is fixed.
//! References: docs/derivations/soft-step.md, [Catto24], [Macklin19].
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

mod bins;
mod bound;
mod work;
pub(crate) mod softness;
pub(crate) mod closing;
pub(crate) mod rows;
pub(crate) mod contact;
pub(crate) mod joint;
pub(crate) mod sixdof;
mod held;
mod spring;
pub(crate) mod inertia;
pub(crate) mod integrate;
mod classic;
mod blow;
mod coupling;
mod fineness;
mod impact;
mod pack;
mod pack_extra;
mod pack_joint;
mod pack_sixdof;
mod parting;
mod passes;
mod pinned;
mod root;
mod layout;
mod lines;
mod plan;
mod reflect;
mod renew;
mod turning;
mod rooms;
mod rounds;
mod forest;
pub(crate) mod spin;
mod strokes;
mod survey;
mod swing;
mod tally;
mod six;
mod together;
mod turns;
mod tree;
mod tree_six;
mod touch;
mod unpack;

pub(crate) use self::tally::Given;

use fearless_simd::dispatch;

use self::contact::Sweep;
use self::coupling::CouplingRow;
use self::impact::Impacts;
use self::inertia::{Frames, Squeeze};
use self::integrate::Aux;
use self::joint::JointSweep;
use self::parting::Parting;
use self::plan::{Group, Plan};
use self::rooms::{Blocks, Rooms};
use self::rounds::BodyState;
use self::rows::{ContactBlock, Extra, JointBlock, JointRest, Line, Whitening};
use self::sixdof::SixBlock;
use self::softness::Softness;
use self::strokes::Progress;
use self::tally::{Askers, ContactTally, JointTally, Peaks, TreeTally, Watch};
use self::tree::{TreeBody, TreeRow};
use self::work::Bound;
use super::context::StepContext;
use crate::base::bit_set::BitSet;
use crate::base::disjoint::{Apart, Rows};
use crate::base::grow;
use crate::base::jobs::{Jobs, for_each_in_room, for_shares};
use crate::base::math::Vec3;
use crate::geometry::collide::MeshScratch;
use crate::state::bodies::{Bodies, Fineness};
use crate::state::colors::Colors;
use crate::state::contacts::{Contacts, Slots, Softened};
use crate::state::islands::Islands;
use crate::state::joints::{Joint, Joints};
use crate::state::method::{Method, Pass};
use crate::state::shapes::Shapes;
use crate::step::narrowphase;
use crate::step::particles::pace::Tied;

/// The solver's memory, kept from step to step so that a warm step allocates nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    plan: Plan,
    pub(crate) line_of: Vec<u32>,
    pub(crate) lines: Vec<Line>,
    pub(crate) whitening: Vec<Whitening>,
    pub(crate) aux: Vec<Aux>,
    acceleration: Vec<Vec3>,
    pub(crate) squeezes: Vec<Squeeze>,
    /// Of bodies whose step is taken in rounds, and of those that turn far.
    states: Vec<BodyState>,
    /// Of each group.
    frames: Vec<Frames>,
    /// One for each group, while some body turns far.
    meshes: Vec<MeshScratch>,
    blocks: Vec<ContactBlock>,
    extras: Vec<Extra>,
    /// Steps since the last one in which they were needed.
    plain: u32,
    /// Steps since the last impacts or blows.
    calm: u32,
    /// Of each block, where overlaps are parted, and how they move each line: velocities that nobody keeps.
    partings: Vec<Parting>,
    ways: Vec<Line>,
    /// Steps since the last one in which they were needed.
    unparted: u32,
    joints: Vec<JointBlock>,
    joint_rests: Vec<JointRest>,
    sixdofs: Vec<SixBlock>,
    couplings: Vec<CouplingRow>,
    bounds: Vec<Bound>,
    tree_gains: Vec<f64>,
    tree_bodies: Vec<TreeBody>,
    tree_rows: Vec<TreeRow>,
    /// One for each group, while some contact can bounce.
    impacts: Vec<Impacts>,
    /// Whether nothing pushed a line in this step, where that is known; or empty: see [`Self::flew`].
    free: Vec<Option<bool>>,
    /// A bit for each lane of a block whose touch is new.
    begun: Vec<u8>,
    /// How far groups are that keep pace with particles.
    progress: Vec<Progress>,
    /// One for each block: whose impulses are summed. Sums of others mean nothing.
    watches: Vec<Watch>,
    tallies: Vec<ContactTally>,
    /// One for each block, while somebody asks.
    peaks: Vec<Peaks>,
    /// One for each lane of a block, while some contact can bounce.
    /// While something can break.
    joint_tallies: Vec<JointTally>,
    six_tallies: Vec<JointTally>,
    tree_tallies: Vec<TreeTally>,
    /// Of the methods that run over rows one by one.
    classic: classic::Scratch,
    /// Sweeps over the contacts in the last step.
    pub(crate) sweeps: u32,
}

/// Room is kept for so many steps after it was needed last.
const KEPT_STEPS: u32 = 60;

/// The same for impacts: before what they hit falls asleep, after which no step counts.
const CALM_STEPS: u32 = 20;

/// Room for so many contacts is kept where nothing is hit.
const KEPT_ROOM: usize = 512;

impl Scratch {
    /// Makes room for what few contacts have, if some have that. It is given back when that was not so for a while.
    fn make_extras(&mut self, has_extras: bool) {
        let [blocks, lines] = [self.plan.contacts.owners.len(), self.plan.members.len() + 1];
        self.extras.resize_with(if has_extras { blocks } else { 0 }, Extra::default);
        if Self::is_over(&mut self.plain, has_extras, KEPT_STEPS) {
            self.extras = Vec::new();
        }
        self.free.clear();
        self.free.resize(if has_extras { lines } else { 0 }, None);
    }

    /// Makes room for impacts. A little of it stays, for a blow may come at any time; much is given back when none came for a while.
    fn make_impacts(&mut self, collides: bool) {
        let room = || self.impacts.iter().map(Impacts::room).sum::<usize>();
        if Self::is_over(&mut self.calm, collides, CALM_STEPS) && room() > KEPT_ROOM {
            self.impacts = Vec::new();
        }
        if collides {
            let groups = self.plan.groups.len().max(self.impacts.len());
            self.impacts.resize_with(groups, Impacts::default);
        }
    }

    /// Counts the steps since something was needed; true if room for it is to be given back now.
    const fn is_over(since: &mut u32, is_needed: bool, steps: u32) -> bool {
        *since = if is_needed { 0 } else { since.saturating_add(1) };
        *since == steps
    }

    /// See [`crate::step::Scratch::start_from`]. What is told of the last step is that of `from`.
    pub(crate) fn start_from(&mut self, from: &Self) {
        self.plan.forget();
        self.sweeps = from.sweeps;
        self.classic.start_from(&from.classic);
    }

    /// True if nothing pushed the body of this line though something was near that it can bounce off: it
    /// flew, and must keep its energy.
    pub(crate) fn flew(&self, line: usize) -> bool {
        matches!(self.free.get(line), Some(Some(true)))
    }

    /// How fast overlaps that are parted move the body of a row [m/s].
    pub(crate) fn parting(&self, is_dynamic: bool, row: u32) -> f32 {
        let line = if is_dynamic { self.line_of[row as usize] as usize } else { 0 };
        self.aux.get(line).map_or(0.0, Aux::parting)
    }

    /// Relative residual of the contacts in the last step, of the analytic method, and whether they were
    /// too many for it.
    pub(crate) fn residual(&self) -> (f64, bool) {
        (self.classic.residual, self.classic.too_large)
    }

    /// Room for the rows of joints, couplings and trees.
    fn make_joint_rows(&mut self) {
        self.joints.resize_with(self.plan.joints.owners.len(), JointBlock::default);
        self.joint_rests.resize_with(self.plan.joints.owners.len(), JointRest::default);
        self.sixdofs.resize_with(self.plan.sixdofs.owners.len(), SixBlock::default);
        self.couplings.resize(self.plan.couplings.len(), CouplingRow::default());
        self.plan.bins.begin(&mut self.bounds);
        self.tree_gains.resize(self.plan.forest.trees.last().map_or(0, |tree| tree.gains.end), 0.0);
        self.tree_bodies.resize(self.plan.forest.bodies.len(), TreeBody::default());
        self.tree_rows.resize(self.plan.forest.joints.len(), TreeRow::default());
    }

    /// Contact rows that were pressed together for the first time.
    pub(crate) fn begun(&self) -> impl Iterator<Item = u32> + Clone {
        let pressed =
            self.begun.iter().zip(&self.plan.contacts.owners).filter(|(bits, _)| **bits != 0);
        let blocks = pressed.flat_map(|(bits, owners)| {
            (0_u8..).zip(owners).filter(move |(lane, _)| bits >> lane & 1 == 1).map(|(_, row)| *row)
        });
        blocks.chain(self.classic.begun.iter().copied())
    }
}

/// The solver's rows as lent to the groups: each touches its own.
#[derive(Clone, Copy, Debug)]
struct Solver<'a> {
    ctx: &'a StepContext,
    method: &'a Method,
    bodies: &'a Bodies,
    shapes: &'a Shapes,
    plan: &'a Plan,
    line_of: &'a [u32],
    lines: Rows<'a, Line>,
    whitening: Rows<'a, Whitening>,
    aux: Rows<'a, Aux>,
    acceleration: Rows<'a, Vec3>,
    squeezes: Rows<'a, Squeeze>,
    /// Empty unless some body turns far, or a group takes its step in rounds, and which one this is.
    states: Rows<'a, BodyState>,
    round: u32,
    frames: Rows<'a, Frames>,
    meshes: Rows<'a, MeshScratch>,
    blocks: Blocks<'a>,
    /// Empty, or one for each block.
    extras: Rows<'a, Extra>,
    has_extras: bool,
    /// Some contact that does not bounce may get a blow: see [`narrowphase::blows`].
    blows: bool,
    /// Some contact's bodies turn together: see [`narrowphase::corotates`].
    turning: Option<&'a BitSet>,
    /// Some contact may be parted: only then `partings` and `ways` have rows.
    parts: bool,
    partings: Rows<'a, Parting>,
    ways: Rows<'a, Line>,
    joints: Rows<'a, JointBlock>,
    joint_rests: Rows<'a, JointRest>,
    sixdofs: Rows<'a, SixBlock>,
    couplings: Rows<'a, CouplingRow>,
    bounds: Rows<'a, Bound>,
    tree_gains: Rows<'a, f64>,
    tree_bodies: Rows<'a, TreeBody>,
    tree_rows: Rows<'a, TreeRow>,
    /// Empty where `extras` is, as are `free`.
    impacts: Rows<'a, Impacts>,
    free: Rows<'a, Option<bool>>,
    begun: Rows<'a, u8>,
    progress: Rows<'a, Progress>,
    askers: Askers<'a>,
    watches: Rows<'a, Watch>,
    tallies: Rows<'a, ContactTally>,
    peaks: Rows<'a, Peaks>,
    /// Empty where `extras` is.
    /// Empty unless something can break.
    joint_tallies: Rows<'a, JointTally>,
    six_tallies: Rows<'a, JointTally>,
    tree_tallies: Rows<'a, TreeTally>,
    contacts: Slots<'a>,
    softened: &'a [Softened],
    joint_slots: Rows<'a, Option<Joint>>,
}

/// The tables that the solver reads only.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input<'a> {
    pub(crate) bodies: &'a Bodies,
    pub(crate) shapes: &'a Shapes,
    pub(crate) islands: &'a Islands,
    /// Which contacts close fast.
    pub(crate) closing: &'a narrowphase::Scratch,
    /// Some body or joint can break: what contacts and joints give is summed up.
    pub(crate) breakage: bool,
}

/// Runs the method's passes. Poses are written by finalize, from the lines. There is a context for each
/// [`Fineness`](crate::state::bodies::Fineness) of islands.
pub(crate) fn solve(
    contexts: [&StepContext; 5],
    method: &Method,
    input: Input<'_>,
    joints: &mut Joints,
    contacts: &mut Contacts,
    colors: &mut Colors,
    scratch: &mut Scratch,
    tied: &mut Tied<'_>,
    jobs: &Jobs<'_>,
) {
    let s = scratch;
    let ctx = contexts[0];
    let Input { bodies, shapes, islands, closing, breakage } = input;
    // Blocks that no group takes, those of bodies that were put aside, would keep what they said before.
    s.begun.clear();
    s.watches.clear();
    if method.is_classic() {
        classic::solve(ctx, method, input, joints, contacts, colors, s);
        together::follow(ctx, bodies, s, tied, jobs);
        return;
    }
    if s.classic.leave(&mut s.line_of) {
        // Line 0 is nobody's in blocks, and theirs are of another kind.
        (s.lines, s.whitening, s.aux) = Default::default();
        (s.acceleration, s.squeezes) = Default::default();
    }
    s.sweeps = method.wide_sweeps(ctx.substeps);
    s.plan.choose_fineness(bodies, joints, contacts, islands, closing.closing(), contexts, jobs);
    s.plan.choose_turning(bodies, contacts, shapes, (closing, ctx.dt));
    let [.., struck, _] = contexts;
    s.plan.take_back(bodies, joints, contacts, islands, struck, jobs);
    let workers = jobs.workers().max(1);
    let parts = contexts.map(|ctx| ctx.parts);
    s.plan.update(bodies, joints, contacts, colors, &mut s.line_of, ctx.tree_ratio, parts, jobs);
    let n = s.plan.members.len() + 1;
    grow::resize(&mut s.lines, n, Line::default());
    grow::resize(&mut s.whitening, n, Whitening::default());
    grow::resize(&mut s.aux, n, Aux::default());
    grow::resize(&mut s.acceleration, n, Vec3::ZERO);
    grow::resize(&mut s.squeezes, n, Squeeze::default());
    let in_rounds = s.plan.groups.iter().any(|group| group.fineness == Fineness::Tumbling);
    let states = in_rounds || !s.plan.turning.lines.is_empty();
    grow::resize(&mut s.states, if states { n } else { 0 }, BodyState::default());
    if !s.plan.turning.lines.is_empty() && s.meshes.len() < s.plan.groups.len() {
        s.meshes.resize_with(s.plan.groups.len(), MeshScratch::default);
    }
    s.frames.resize_with(s.plan.groups.len().max(s.frames.len()), Frames::default);
    let n = s.plan.contacts.owners.len();
    s.begun.resize(n, 0);
    let [corotates, parts, blows] = closing.listed();
    let has_extras = colors.special > 0 || corotates;
    s.make_partings(parts);
    s.make_extras(has_extras);
    s.make_impacts(has_extras || blows);
    s.make_joint_rows();
    together::find_groups(&s.plan, &s.line_of, tied.scratch);
    s.progress.resize(tied.scratch.groups.len(), Progress::default());
    let askers = Askers { bodies, shapes, breakage };
    s.make_tallies((breakage, askers.any()));
    // SAFETY: groups share no constraint and no body that can be pushed; in a group that several workers share, a pass goes by bodies, or
    // by colors, which touch such a body once.
    let apart = unsafe { Apart::promise() };
    let (slots, softened) = contacts.solved_mut(apart);
    let plan = &s.plan;
    let keep = !tied.scratch.groups.is_empty();
    let Rooms { own, rooms, size } = Rooms::new(plan, &mut s.blocks, workers, keep);
    let end = own.len();
    let solver = Solver {
        ctx,
        method,
        bodies,
        shapes,
        plan,
        line_of: &s.line_of,
        lines: Rows::new(&mut s.lines, apart),
        whitening: Rows::new(&mut s.whitening, apart),
        aux: Rows::new(&mut s.aux, apart),
        acceleration: Rows::new(&mut s.acceleration, apart),
        squeezes: Rows::new(&mut s.squeezes, apart),
        states: Rows::new(&mut s.states, apart),
        round: 0,
        frames: Rows::new(&mut s.frames, apart),
        meshes: Rows::new(&mut s.meshes, apart),
        blocks: Blocks::new(own, 0, apart),
        extras: Rows::new(&mut s.extras, apart),
        has_extras,
        blows,
        turning: corotates.then_some(&plan.turning.bodies),
        parts,
        partings: Rows::new(&mut s.partings, apart),
        ways: Rows::new(&mut s.ways, apart),
        joints: Rows::new(&mut s.joints, apart),
        joint_rests: Rows::new(&mut s.joint_rests, apart),
        sixdofs: Rows::new(&mut s.sixdofs, apart),
        couplings: Rows::new(&mut s.couplings, apart),
        bounds: Rows::new(&mut s.bounds, apart),
        tree_gains: Rows::new(&mut s.tree_gains, apart),
        tree_bodies: Rows::new(&mut s.tree_bodies, apart),
        tree_rows: Rows::new(&mut s.tree_rows, apart),
        impacts: Rows::new(&mut s.impacts, apart),
        free: Rows::new(&mut s.free, apart),
        begun: Rows::new(&mut s.begun, apart),
        progress: Rows::new(&mut s.progress, apart),
        askers,
        watches: Rows::new(&mut s.watches, apart),
        peaks: Rows::new(&mut s.peaks, apart),
        tallies: Rows::new(&mut s.tallies, apart),
        joint_tallies: Rows::new(&mut s.joint_tallies, apart),
        six_tallies: Rows::new(&mut s.six_tallies, apart),
        tree_tallies: Rows::new(&mut s.tree_tallies, apart),
        contacts: slots,
        softened,
        joint_slots: Rows::new(joints.rows.values_mut(), apart),
    };
    let solver_of =
        |number: usize| Solver { ctx: contexts[plan.groups[number].fineness as usize], ..solver };
    solver.solve_together(tied, jobs);
    let groups = &tied.scratch.groups;
    for number in (0..plan.shared).filter(|number| groups.binary_search(number).is_err()) {
        solver_of(number).solve(number, jobs);
    }
    for_each_in_room(jobs, plan.groups.len() - plan.shared, rooms, size, |room, number| {
        let number = plan.shared + number;
        if groups.binary_search(&number).is_err() {
            let range = plan.contacts.blocks_of(&plan.groups[number].contacts);
            let blocks = if range.end <= end {
                solver.blocks
            } else {
                Blocks::new(&mut room[..range.len()], range.start, apart)
            };
            Solver { blocks, ..solver_of(number) }.solve(number, &Jobs::Inline);
        }
    });
}

impl Solver<'_> {
    /// A pass over the colors.
    fn sweep(&self, group: &Group, pass: Pass, substep: u32, jobs: &Jobs<'_>) {
        let ctx = self.ctx;
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let elapsed = substep as f32 * ctx.h;
        // A relax pass within a substep stands after its positions.
        let moved = elapsed + if substep < ctx.substeps { ctx.h } else { 0.0 };
        let sweep = |softness, inner, elapsed| Sweep {
            inv_h: ctx.inv_h,
            softness,
            relaxes: pass == Pass::Relax,
            cap: ctx.push_speed,
            hit: contact::HIT_SPEED * ctx.length,
            inner,
            elapsed,
        };
        match pass {
            Pass::Solve { inner } => {
                let inner = inner.clamp(1, 8);
                let joints = JointSweep::solving(ctx, elapsed);
                self.sweep_couplings(group, &joints);
                self.sweep_joints(group, &joints, jobs);
                self.sweep_sixdofs(group, &joints, jobs);
                self.sweep_trees(group, &joints, jobs);
                let sweeps =
                    [sweep(ctx.soft, inner, elapsed), sweep(ctx.soft_fixed, inner, elapsed)];
                self.sweep_contacts(group, &sweeps, false, jobs);
            }
            Pass::Relax => {
                let joints = JointSweep::relaxing(ctx, moved);
                self.sweep_couplings(group, &joints);
                self.sweep_joints(group, &joints, jobs);
                self.sweep_sixdofs(group, &joints, jobs);
                self.sweep_trees(group, &joints, jobs);
                let rigid = sweep(Softness::RIGID, 1, moved);
                self.sweep_contacts(group, &[rigid, rigid], true, jobs);
            }
            // Passes over bodies or islands, and those of the classic methods.
            _ => {}
        }
    }

    fn accelerate(&self, group: &Group, jobs: &Jobs<'_>, first: bool) {
        self.for_lines(group, jobs, &|lines, aux| {
            for (line, aux) in lines.iter_mut().zip(aux) {
                integrate::velocities(line, aux, first);
            }
        });
    }

    fn advance(&self, group: &Group, jobs: &Jobs<'_>) {
        let h = self.ctx.h;
        self.for_lines(group, jobs, &|lines, aux| {
            for (line, aux) in lines.iter_mut().zip(aux) {
                integrate::positions(line, h);
                integrate::velocities(line, aux, false);
            }
        });
    }

    fn drift(&self, group: &Group, jobs: &Jobs<'_>) {
        let h = self.ctx.h;
        self.for_lines(group, jobs, &|lines, _| {
            for line in lines {
                integrate::positions(line, h);
            }
        });
    }

    fn for_lines(
        &self,
        group: &Group,
        jobs: &Jobs<'_>,
        f: &(dyn Fn(&mut [Line], &mut [Aux]) + Sync),
    ) {
        let n = group.lines.len();
        for_shares(jobs, n, 256, |part| {
            let part = group.lines.start + part.start..group.lines.start + part.end;
            f(self.lines.slice(part.clone()), self.aux.slice(part));
        });
    }

    /// Sums up how each body is squeezed.
    fn weigh(&self, group: &Group, jobs: &Jobs<'_>) {
        let scale = self.ctx.store_scale();
        self.plan.contacts.for_blocks(&group.contacts, jobs, 64, |_, blocks| {
            dispatch!(self.ctx.level, simd => {
                for i in blocks {
                    unpack::weigh(simd, self.blocks.read(i), &self.squeezes, scale);
                }
            });
        });
    }

    fn store(&self, group: &Group, jobs: &Jobs<'_>) {
        let tables = (&self.contacts, self.bodies);
        if self.ctx.inertia.is_on() {
            self.weigh(group, jobs);
        }
        let blocks = self.plan.contacts.blocks_of(&group.contacts);
        let n = blocks.len();
        for_shares(jobs, n, 32, |part| {
            dispatch!(self.ctx.level, simd => {
                for i in blocks.start + part.start..blocks.start + part.end {
                    let extra = if self.has_extras { Some(self.extras.read(i)) } else { None };
                    let owners = &self.plan.contacts.owners[i];
                    self.prefetch_contacts(i + 1);
                    let block = self.blocks.read(i);
                    let begun = self.begun.row(i);
                    let when = (self.ctx, None);
                    *begun |= unpack::store(simd, block, extra, (owners, *begun), tables, when);
                    self.end_tally(i);
                }
            });
        });
        self.store_tallies(group);
        self.store_joints(group, jobs);
        self.store_couplings(group);
        self.store_trees(group);
        self.store_sixdofs(group, jobs);
    }
}
