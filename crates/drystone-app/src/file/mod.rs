//! Files of a run: its trajectory, events, snapshot, recording and baked motion.

pub(crate) mod bake;
pub(crate) mod chunk;
pub(crate) mod events;
pub(crate) mod record;
pub(crate) mod snapshot;
pub(crate) mod trace;
