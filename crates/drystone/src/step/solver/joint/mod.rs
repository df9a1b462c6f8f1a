//! Joints: ball joints and distances in blocks of eight, joints of six axes, couplings.

pub(crate) mod ball_distance;
pub(crate) mod block;
pub(crate) mod coupling;
pub(crate) mod coupling_row;
pub(crate) mod pivot;
pub(crate) mod prepare;
pub(crate) mod root;
pub(crate) mod six_dof;
pub(crate) mod sweep;
