//! Contacts: blocks of eight manifolds, which are prepared, swept, rebuilt within a step, and
//! stored.

pub(crate) mod arena;
pub(crate) mod block;
pub(crate) mod drive;
pub(crate) mod kernel;
pub(crate) mod lent;
mod pair;
pub(crate) mod part;
pub(crate) mod parting;
pub(crate) mod prepare;
pub(crate) mod raw;
pub(crate) mod renew;
pub(crate) mod store;
pub(crate) mod surface;
pub(crate) mod sweep;
