//! `Solver`: borrowed views of the solver's rows, through which groups are solved in parallel.

use super::body::island_motion::Frames;
use super::body::row::Aux;
use super::body::squeeze::Squeeze;
use super::body::state::BodyState;
use super::contact::arena::Blocks;
use super::contact::block::Extra;
use super::contact::parting::Parting;
use super::impact::Impacts;
use super::joint::block::{JointBlock, JointRest};
use super::joint::coupling_row::CouplingRow;
use super::joint::six_dof::block::SixBlock;
use super::pass::Progress;
use super::plan::Plan;
use super::totals_rows::{Askers, ContactTally, JointTally, Peaks, TreeTally, Watch};
use super::tree::rows::{TreeBody, TreeRow};
use super::work::Bound;
use crate::base::bit_set::BitSet;
use crate::base::math::Vec3;
use crate::base::threads::disjoint::Rows;
use crate::geometry::collide::MeshScratch;
use crate::state::bodies::Bodies;
use crate::state::contacts::{Slots, Softened};
use crate::state::def::method::Method;
use crate::state::joints::Joint;
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;
use crate::step::solver_body::{SolverBody, Whitening};

/// Shared access to the solver's rows; each group touches only its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solver<'a> {
    pub(super) ctx: &'a StepContext,
    pub(super) method: &'a Method,
    pub(super) bodies: &'a Bodies,
    pub(super) shapes: &'a Shapes,
    pub(super) plan: &'a Plan,
    pub(super) line_of: &'a [u32],
    pub(super) lines: Rows<'a, SolverBody>,
    pub(super) whitening: Rows<'a, Whitening>,
    pub(super) aux: Rows<'a, Aux>,
    pub(super) acceleration: Rows<'a, Vec3>,
    pub(super) squeezes: Rows<'a, Squeeze>,
    /// States at the start of `round`; empty unless some body turns far or a group is solved in
    /// rounds.
    pub(super) states: Rows<'a, BodyState>,
    pub(super) round: u32,
    pub(super) frames: Rows<'a, Frames>,
    pub(super) meshes: Rows<'a, MeshScratch>,
    pub(super) blocks: Blocks<'a>,
    /// Empty, or one for each block.
    pub(super) extras: Rows<'a, Extra>,
    pub(super) has_extras: bool,
    /// Some contact that does not bounce may get an impact: see [`narrowphase::turns::blows`].
    pub(super) blows: bool,
    /// The two bodies of some contact rotate together: see [`narrowphase::turns::corotates`].
    pub(super) turning: Option<&'a BitSet>,
    /// Some overlap may be corrected by displacement; otherwise `partings` and `ways` are empty.
    pub(super) parts: bool,
    pub(super) partings: Rows<'a, Parting>,
    pub(super) ways: Rows<'a, SolverBody>,
    pub(super) joints: Rows<'a, JointBlock>,
    pub(super) joint_rests: Rows<'a, JointRest>,
    pub(super) sixdofs: Rows<'a, SixBlock>,
    pub(super) couplings: Rows<'a, CouplingRow>,
    pub(super) bounds: Rows<'a, Bound>,
    pub(super) tree_gains: Rows<'a, f64>,
    pub(super) tree_bodies: Rows<'a, TreeBody>,
    pub(super) tree_rows: Rows<'a, TreeRow>,
    /// Empty where `extras` is empty, and so is `free`.
    pub(super) impacts: Rows<'a, Impacts>,
    pub(super) free: Rows<'a, Option<bool>>,
    pub(super) begun: Rows<'a, u8>,
    pub(super) progress: Rows<'a, Progress>,
    pub(super) askers: Askers<'a>,
    pub(super) watches: Rows<'a, Watch>,
    pub(super) tallies: Rows<'a, ContactTally>,
    pub(super) peaks: Rows<'a, Peaks>,
    /// Empty unless some body or joint can break.
    pub(super) joint_tallies: Rows<'a, JointTally>,
    pub(super) six_tallies: Rows<'a, JointTally>,
    pub(super) tree_tallies: Rows<'a, TreeTally>,
    pub(super) contacts: Slots<'a>,
    pub(super) softened: &'a [Softened],
    pub(super) joint_slots: Rows<'a, Option<Joint>>,
}
