//! Six-axis joints: blocks of eight, their locked axes, drives and limits.

pub(crate) mod angles;
pub(crate) mod block;
pub(crate) mod drive;
pub(crate) mod kernel;
pub(crate) mod kernel_anchored;
pub(crate) mod locked_axes;
pub(crate) mod placed;
pub(crate) mod prepare;
