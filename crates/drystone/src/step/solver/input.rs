//! The tables that the solver reads.

use crate::state::bodies::Bodies;
use crate::state::islands::Islands;
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
