//! Layer 2: the tables, all that lives from step to step, and the definitions that rows are made of.

pub(crate) mod config;
pub(crate) mod method;
pub(crate) mod def;
pub(crate) mod material;
pub(crate) mod events;
