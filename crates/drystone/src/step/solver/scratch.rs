//! Memory of the solver, kept from step to step.

use super::body::island_motion::Frames;
use super::body::row::Aux;
use super::body::solved::Solved;
use super::body::squeeze::Squeeze;
use super::body::state::BodyState;
use super::contact::block::{ContactBlock, Extra};
use super::contact::parting::Parting;
use super::impact::Impacts;
use super::joint::block::{JointBlock, JointRest};
use super::joint::coupling_row::CouplingRow;
use super::joint::six_dof::block::SixBlock;
use super::pass::Progress;
use super::plan::Plan;
use super::totals_rows::{ContactTally, JointTally, Peaks, TreeTally, Watch};
use super::tree::rows::{TreeBody, TreeRow};
use super::work::Bound;
use crate::base::grow;
use crate::base::math::Vec3;
use crate::geometry::collide::MeshScratch;
use crate::state::bodies::Fineness;
use crate::step::classic;
use crate::step::solver_body::{SolverBody, Whitening};

/// The solver's memory, kept from step to step so that a warm step allocates nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub(super) plan: Plan,
    pub(crate) solved: Solved,
    pub(super) acceleration: Vec<Vec3>,
    /// One for each group.
    pub(super) frames: Vec<Frames>,
    /// One for each group, while some body turns far.
    pub(super) meshes: Vec<MeshScratch>,
    pub(super) blocks: Vec<ContactBlock>,
    pub(super) extras: Vec<Extra>,
    /// Steps since some contact last needed `extras`.
    plain: u32,
    /// Steps since the last impact, with or without bounce.
    calm: u32,
    /// Overlap corrections of each block, and their pseudo-velocities for each solver body, which
    /// are discarded after the step.
    pub(super) partings: Vec<Parting>,
    pub(super) ways: Vec<SolverBody>,
    /// Steps since the last overlap correction.
    pub(super) unparted: u32,
    pub(super) joints: Vec<JointBlock>,
    pub(super) joint_rests: Vec<JointRest>,
    pub(super) sixdofs: Vec<SixBlock>,
    pub(super) couplings: Vec<CouplingRow>,
    pub(super) bounds: Vec<Bound>,
    pub(super) tree_gains: Vec<f64>,
    pub(super) tree_bodies: Vec<TreeBody>,
    pub(super) tree_rows: Vec<TreeRow>,
    /// One for each group, while some contact can bounce.
    pub(super) impacts: Vec<Impacts>,
    /// One bit for each lane of a block whose touch is new.
    pub(super) begun: Vec<u8>,
    /// Progress of the groups that run in step with particles.
    pub(super) progress: Vec<Progress>,
    /// Contacts of each block whose impulses are summed; sums of other contacts are undefined.
    pub(super) watches: Vec<Watch>,
    pub(super) tallies: Vec<ContactTally>,
    /// One for each block, while some body, joint or shape needs them.
    pub(super) peaks: Vec<Peaks>,
    /// Empty unless something can break.
    pub(super) joint_tallies: Vec<JointTally>,
    pub(super) six_tallies: Vec<JointTally>,
    pub(super) tree_tallies: Vec<TreeTally>,
    /// Memory of the methods that process rows one by one.
    pub(super) classic: classic::Scratch,
    /// Sweeps over the contacts in the last step.
    pub(crate) sweeps: u32,
}

/// Number of steps after which unused memory is freed.
pub(crate) const KEPT_STEPS: u32 = 60;

/// The same for impacts. It is shorter, so that memory is freed before the bodies fall asleep:
/// after that no step counts.
const CALM_STEPS: u32 = 20;

/// Number of contacts for which memory for impacts is kept.
const KEPT_ROOM: usize = 512;

impl Scratch {
    /// Clears the records of new and watched contacts of the last step. Blocks that no group
    /// solves, because their bodies were deactivated, would keep them.
    pub(super) fn begin_step(&mut self) {
        self.begun.clear();
        self.watches.clear();
    }

    /// Discards the plan when a classic method takes over: its solver bodies are not those of this
    /// step.
    pub(super) fn leave_wide(&mut self) {
        self.plan = Plan::default();
        self.sweeps = 0;
    }

    /// Discards classic rows when a default method takes over. In blocks solver body 0 cannot be
    /// pushed, and the solver bodies of a classic method differ.
    pub(super) fn leave_classic(&mut self) {
        let Solved { line_of, lines, whitening, aux, squeezes, .. } = &mut self.solved;
        if self.classic.leave(line_of) {
            (*lines, *whitening, *aux) = Default::default();
            *squeezes = Vec::new();
            self.acceleration = Vec::new();
        }
    }

    /// Makes room for the solver bodies, and for those that turn far or are solved in rounds.
    pub(super) fn make_bodies(&mut self) {
        let n = self.plan.members.len() + 1;
        grow::resize(&mut self.solved.lines, n, SolverBody::default());
        grow::resize(&mut self.solved.whitening, n, Whitening::default());
        grow::resize(&mut self.solved.aux, n, Aux::default());
        grow::resize(&mut self.acceleration, n, Vec3::ZERO);
        grow::resize(&mut self.solved.squeezes, n, Squeeze::default());
        let in_rounds = self.plan.groups.iter().any(|group| group.fineness == Fineness::Tumbling);
        // Bodies on one ball joint have end states as well.
        let on_joints = !self.plan.joints.owners.is_empty();
        let states = in_rounds || on_joints || !self.plan.turning.lines.is_empty();
        grow::resize(&mut self.solved.states, if states { n } else { 0 }, BodyState::default());
        if !self.plan.turning.lines.is_empty() && self.meshes.len() < self.plan.groups.len() {
            self.meshes.resize_with(self.plan.groups.len(), MeshScratch::default);
        }
        self.frames.resize_with(self.plan.groups.len().max(self.frames.len()), Frames::default);
    }

    /// Sweeps over the contacts in the last step.
    pub(crate) const fn sweeps(&self) -> u32 {
        self.sweeps + self.classic.sweeps
    }

    /// Allocates the `extras` of all blocks if some contact has any, and frees them after a while
    /// without use.
    pub(crate) fn make_extras(&mut self, has_extras: bool) {
        let [blocks, lines] = [self.plan.contacts.owners.len(), self.plan.members.len() + 1];
        self.extras.resize_with(if has_extras { blocks } else { 0 }, Extra::default);
        if Self::is_over(&mut self.plain, has_extras, KEPT_STEPS) {
            self.extras = Vec::new();
        }
        self.solved.free.clear();
        self.solved.free.resize(if has_extras { lines } else { 0 }, None);
    }

    /// Allocates memory for impacts. A small amount stays, because an impact may occur at any time;
    /// a large one is freed after a while without use.
    pub(crate) fn make_impacts(&mut self, collides: bool) {
        let room = || self.impacts.iter().map(Impacts::room).sum::<usize>();
        if Self::is_over(&mut self.calm, collides, CALM_STEPS) && room() > KEPT_ROOM {
            self.impacts = Vec::new();
        }
        if collides {
            let groups = self.plan.groups.len().max(self.impacts.len());
            self.impacts.resize_with(groups, Impacts::default);
        }
    }

    /// Counts the steps since something was needed; true when its memory is to be freed.
    pub(crate) const fn is_over(since: &mut u32, is_needed: bool, steps: u32) -> bool {
        *since = if is_needed { 0 } else { since.saturating_add(1) };
        *since == steps
    }

    /// See [`crate::step::Scratch::start_from`]. Statistics of the last step are those of `from`.
    pub(crate) fn start_from(&mut self, from: &Self) {
        self.plan.forget();
        self.sweeps = from.sweeps;
        self.classic.start_from(&from.classic);
    }

    /// Relative residual of the contacts in the last step, for the analytic method, and whether
    /// they were too many for it.
    pub(crate) fn residual(&self) -> (f64, bool) {
        (self.classic.residual, self.classic.too_large)
    }

    /// Allocates the rows of joints, couplings and trees.
    pub(crate) fn make_joint_rows(&mut self) {
        self.joints.resize_with(self.plan.joints.owners.len(), JointBlock::default);
        self.joint_rests.resize_with(self.plan.joints.owners.len(), JointRest::default);
        self.sixdofs.resize_with(self.plan.sixdofs.owners.len(), SixBlock::default);
        self.couplings.resize(self.plan.couplings.len(), CouplingRow::default());
        self.plan.bins.begin(&mut self.bounds);
        self.tree_gains.resize(self.plan.forest.trees.last().map_or(0, |tree| tree.gains.end), 0.0);
        self.tree_bodies.resize(self.plan.forest.bodies.len(), TreeBody::default());
        self.tree_rows.resize(self.plan.forest.joints.len(), TreeRow::default());
    }

    /// Rows of contacts that were pressed for the first time in this step.
    pub(crate) fn begun(&self) -> impl Iterator<Item = u32> + Clone {
        let pressed =
            self.begun.iter().zip(&self.plan.contacts.owners).filter(|(bits, _)| **bits != 0);
        let blocks = pressed.flat_map(|(bits, owners)| {
            (0_u8..).zip(owners).filter(move |(lane, _)| bits >> lane & 1 == 1).map(|(_, row)| *row)
        });
        blocks.chain(self.classic.begun.iter().copied())
    }
}
