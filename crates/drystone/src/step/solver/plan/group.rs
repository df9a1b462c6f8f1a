//! Groups of islands: the unit of parallel work.

use core::ops::Range;

use crate::state::bodies::body::Subdivision;

/// Islands that are solved together.
#[derive(Clone, Debug, Default)]
pub(crate) struct Group {
    pub(crate) solver_rows: Range<usize>,
    pub(crate) contacts: Range<usize>,
    pub(crate) joints: Range<usize>,
    pub(crate) six_dof: Range<usize>,
    /// Range in [`Plan::couplings`].
    pub(crate) couplings: Range<usize>,
    /// Range in [`Plan::articulations`].
    pub(crate) articulations: Range<usize>,
    /// Range in [`Forest::order`].
    pub(crate) trees: Range<usize>,
    /// Island numbers of [`Bins`].
    pub(crate) bins: Range<usize>,
    /// Range in [`Bins::solver_rows`].
    pub(crate) bin_rows: Range<usize>,
    pub(crate) subdivision: Subdivision,
}

pub(crate) fn number(n: usize) -> u32 {
    u32::try_from(n).expect("fewer than 2^32 bodies")
}
