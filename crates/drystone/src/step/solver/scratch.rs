//! Memory of the solver, kept from step to step.

use super::articulation::lent::ArticulationScratch;
use super::body::solved::Solved;
use super::contact::lent::ContactScratch;
use super::impact::Impacts;
use super::joint::lent::JointScratch;
use super::pass::Progress;
use super::plan::Plan;
use super::tree::lent::TreeScratch;
use crate::step::classic;

/// The solver's memory, kept from step to step so that a warm step allocates nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub(super) plan: Plan,
    pub(crate) solved: Solved,
    pub(super) contact: ContactScratch,
    pub(super) joint: JointScratch,
    pub(super) tree: TreeScratch,
    pub(super) articulation: ArticulationScratch,
    /// One for each group, while some contact can bounce.
    pub(super) impacts: Vec<Impacts>,
    /// Progress of the groups that run in step with particles.
    pub(super) progress: Vec<Progress>,
    /// Memory of the methods that process rows one by one.
    pub(super) classic: classic::Scratch,
    /// Sweeps over the contacts in the last step.
    pub(crate) sweeps: u32,
    /// Steps since the last impact, with or without bounce.
    calm: u32,
}

/// Number of steps after which unused memory is freed.
pub(crate) const KEPT_STEPS: u32 = 60;

/// The same for impacts. It is shorter, so that memory is freed before the bodies fall asleep:
/// after that no step counts.
const CALM_STEPS: u32 = 20;

/// Number of contacts for which memory for impacts is kept.
const KEPT_ROOM: usize = 512;

/// Counts the steps since something was needed; true when its memory is to be freed.
pub(crate) const fn is_over(since: &mut u32, is_needed: bool, steps: u32) -> bool {
    *since = if is_needed { 0 } else { since.saturating_add(1) };
    *since == steps
}

impl Scratch {
    /// Discards the plan when a classic method takes over: its solver bodies are not those of this
    /// step.
    pub(super) fn leave_wide(&mut self) {
        self.plan = Plan::default();
        self.sweeps = 0;
    }

    /// Discards classic rows when a default method takes over. In blocks solver body 0 cannot be
    /// pushed, and the solver bodies of a classic method differ.
    pub(super) fn leave_classic(&mut self) {
        if self.classic.leave(&mut self.solved.solver_row_of) {
            self.solved.discard();
        }
    }

    /// Sweeps over the contacts in the last step.
    pub(crate) const fn sweeps(&self) -> u32 {
        self.sweeps + self.classic.sweeps
    }

    /// Allocates memory for impacts. A small amount stays, because an impact may occur at any time;
    /// a large one is freed after a while without use.
    pub(crate) fn make_impacts(&mut self, collides: bool) {
        let room = || self.impacts.iter().map(Impacts::room).sum::<usize>();
        if is_over(&mut self.calm, collides, CALM_STEPS) && room() > KEPT_ROOM {
            self.impacts = Vec::new();
        }
        if collides {
            let groups = self.plan.groups.len().max(self.impacts.len());
            self.impacts.resize_with(groups, Impacts::default);
        }
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

    /// Rows of contacts that were pressed for the first time in this step.
    pub(crate) fn begun(&self) -> impl Iterator<Item = u32> + Clone {
        let blocks = self.contact.begun(&self.plan.contacts.owners);
        blocks.chain(self.classic.begun.iter().copied())
    }
}
