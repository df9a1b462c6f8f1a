//! Trees of joints: solved directly, by elimination from the leaves to the root.

pub(crate) mod lent;
pub(crate) mod rows;
pub(crate) mod six_dof;
pub(crate) mod sweep;
