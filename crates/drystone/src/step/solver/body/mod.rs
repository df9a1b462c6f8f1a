//! Solver bodies: whitened rows, their preparation and integration.

pub(crate) mod grow_heavier;
pub(crate) mod integrate;
pub(crate) mod island_motion;
pub(crate) mod lent;
pub(crate) mod prepare;
pub(crate) mod row;
pub(crate) mod squeeze;
pub(crate) mod solved;
pub(crate) mod state;
