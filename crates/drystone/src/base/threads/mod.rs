//! Threads: the worker team, the jobs that it shares out, and rows that workers write in parallel.

pub(crate) mod stamps;
pub(crate) mod jobs;
pub(crate) mod checked;
pub(crate) mod sync;
pub(crate) mod team;
pub(crate) mod disjoint;
pub(crate) mod shared;
pub(crate) mod pieces;
