//! Joints: ball and distance joints in blocks of eight, six-axis joints, couplings and pulleys.

pub(crate) mod ball_distance;
pub(crate) mod block;
pub(crate) mod coupling;
pub(crate) mod coupling_row;
pub(crate) mod lent;
pub(crate) mod pivot;
pub(crate) mod prepare;
pub(crate) mod root;
pub(crate) mod six_dof;
pub(crate) mod sweep;
