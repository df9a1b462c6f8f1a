//! The tables that the solver reads.

use crate::state::bodies::Bodies;
use crate::state::breakage::Breakage;
use crate::state::islands::Islands;
use crate::state::joints::Joints;
use crate::state::shapes::Shapes;
use crate::step::narrowphase;

/// The tables that the solver reads and never writes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input<'a> {
    pub(crate) bodies: &'a Bodies,
    pub(crate) shapes: &'a Shapes,
    pub(crate) islands: &'a Islands,
    /// Lists the contacts that close fast.
    pub(crate) closing: &'a narrowphase::scratch::Scratch,
    /// Some body or joint can break, so impulses of contacts and joints are summed.
    pub(crate) breakage: bool,
}

impl<'a> Input<'a> {
    pub(crate) fn new(
        bodies: &'a Bodies,
        shapes: &'a Shapes,
        islands: &'a Islands,
        closing: &'a narrowphase::scratch::Scratch,
        breakage: &Breakage,
        joints: &Joints,
    ) -> Self {
        let breakage = joints.breakable > 0 || breakage.any();
        Self { bodies, shapes, islands, closing, breakage }
    }
}
