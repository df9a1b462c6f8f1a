//! Rows of contacts: their memory, kept from step to step, and as they are lent to the workers of
//! a phase.

use super::arena::{Arena, Blocks, Buffers};
use super::block::{ContactBlock, Extra};
use super::parting::Parting;
use crate::base::bit_set::BitSet;
use crate::base::grow;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::geometry::collide::MeshScratch;
use crate::step::solver::plan::Plan;
use crate::step::solver::scratch::{KEPT_STEPS, is_over};
use crate::step::solver::totals_rows::{ContactTally, Peaks, Watch};
use crate::step::solver_body::SolverBody;

/// One row for each block of eight contacts, if nothing else is said.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactRows<'a> {
    pub(crate) blocks: Blocks<'a>,
    /// Empty unless `has_extras`.
    pub(crate) extras: Rows<'a, Extra>,
    /// One bit for each lane whose touch is new.
    pub(crate) begun: Rows<'a, u8>,
    pub(crate) watches: Rows<'a, Watch>,
    pub(crate) tallies: Rows<'a, ContactTally>,
    /// Empty unless some body or shape needs them.
    pub(crate) peaks: Rows<'a, Peaks>,
    /// Overlap corrections; empty unless `parts`.
    pub(crate) partings: Rows<'a, Parting>,
    /// Pseudo-velocities of overlap correction, one for each solver body; empty unless `parts`.
    pub(crate) pseudo_velocities: Rows<'a, SolverBody>,
    /// One for each group, while some body turns far.
    pub(crate) meshes: Rows<'a, MeshScratch>,
    /// Some contact has rows for rolling, surface velocity, restitution or the like.
    pub(crate) has_extras: bool,
    /// Some contact that does not bounce may get an impact: see
    /// [`may_impact`](crate::step::narrowphase::turning::may_impact).
    pub(crate) has_impacts: bool,
    /// The two bodies of some contact rotate together: see
    /// [`corotates`](crate::step::narrowphase::turning::corotates).
    pub(crate) turning: Option<&'a BitSet>,
    /// Some overlap may be corrected by displacement.
    pub(crate) parts: bool,
}

/// Properties of a step's contacts that decide which rows they need.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent properties")]
pub(crate) struct Needs {
    /// Some contact has rows beyond normal and friction.
    pub(crate) extras: bool,
    /// Some contact that does not bounce may get an impact.
    pub(crate) impacts: bool,
    /// The two bodies of some contact rotate together.
    pub(crate) corotates: bool,
    /// Some overlap may be corrected by displacement.
    pub(crate) parts: bool,
    /// Some body, joint or shape needs peaks.
    pub(crate) peaks: bool,
}

/// Memory of the rows of contacts. The fields are those of [`ContactRows`].
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactScratch {
    pub(crate) blocks: Vec<ContactBlock>,
    extras: Vec<Extra>,
    pub(crate) begun: Vec<u8>,
    /// Sums of contacts that are not watched are undefined.
    pub(crate) watches: Vec<Watch>,
    pub(crate) tallies: Vec<ContactTally>,
    pub(crate) peaks: Vec<Peaks>,
    partings: Vec<Parting>,
    pseudo_velocities: Vec<SolverBody>,
    meshes: Vec<MeshScratch>,
    /// Steps since some contact last needed `extras`, and since the last overlap correction.
    plain: u32,
    unparted: u32,
}

impl ContactScratch {
    /// Clears the records of new and watched contacts of the last step. Blocks that no group
    /// solves, because their bodies were deactivated, would keep them.
    pub(crate) fn begin_step(&mut self) {
        self.begun.clear();
        self.watches.clear();
    }

    /// Allocates the rows of a step, and frees those that were not needed for a while.
    /// [`Self::begin_step`] has cleared the last step's records.
    pub(crate) fn allocate(&mut self, plan: &Plan, needs: Needs) {
        let (n, bodies, groups) =
            (plan.contacts.owners.len(), plan.members.len() + 1, plan.groups.len());
        let count = |is_needed: bool, n: usize| if is_needed { n } else { 0 };
        self.begun.resize(n, 0);
        self.partings.resize_with(count(needs.parts, n), Parting::default);
        self.pseudo_velocities.resize_with(count(needs.parts, bodies), SolverBody::default);
        if is_over(&mut self.unparted, needs.parts, KEPT_STEPS) {
            (self.partings, self.pseudo_velocities) = (Vec::new(), Vec::new());
        }
        self.extras.resize_with(count(needs.extras, n), Extra::default);
        if is_over(&mut self.plain, needs.extras, KEPT_STEPS) {
            self.extras = Vec::new();
        }
        if !plan.turning.solver_rows.is_empty() && self.meshes.len() < groups {
            self.meshes.resize_with(groups, MeshScratch::default);
        }
        self.watches.resize(n, Watch::NONE);
        if self.tallies.len() < n {
            grow::resize(&mut self.tallies, n, ContactTally::default());
        }
        self.peaks.resize(count(needs.peaks, n), Peaks::default());
    }

    /// Lends the rows, with the blocks that have a place of their own, and the workers' buffers for
    /// the other blocks: see [`Arena`].
    pub(crate) fn lend<'a>(
        &'a mut self,
        plan: &'a Plan,
        needs: Needs,
        (workers, keep): (usize, bool),
        apart: Apart,
    ) -> (ContactRows<'a>, Buffers<'a>) {
        let Arena { own, buffers } = Arena::new(plan, &mut self.blocks, workers, keep);
        let rows = ContactRows {
            blocks: Blocks::new(own, 0, apart),
            extras: Rows::new(&mut self.extras, apart),
            begun: Rows::new(&mut self.begun, apart),
            watches: Rows::new(&mut self.watches, apart),
            tallies: Rows::new(&mut self.tallies, apart),
            peaks: Rows::new(&mut self.peaks, apart),
            partings: Rows::new(&mut self.partings, apart),
            pseudo_velocities: Rows::new(&mut self.pseudo_velocities, apart),
            meshes: Rows::new(&mut self.meshes, apart),
            has_extras: needs.extras,
            has_impacts: needs.impacts,
            turning: needs.corotates.then_some(&plan.turning.bodies),
            parts: needs.parts,
        };
        (rows, buffers)
    }

    /// Rows of contacts that were pressed for the first time in this step.
    pub(crate) fn begun<'a>(
        &'a self,
        owners: &'a [[u32; 8]],
    ) -> impl Iterator<Item = u32> + Clone + 'a {
        let pressed = self.begun.iter().zip(owners).filter(|(bits, _)| **bits != 0);
        pressed.flat_map(|(bits, owners)| {
            (0_u8..).zip(owners).filter(move |(lane, _)| bits >> lane & 1 == 1).map(|(_, row)| *row)
        })
    }
}
