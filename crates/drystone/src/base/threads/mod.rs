//! Threads: the worker team, jobs that are shared out to it, and rows that workers write side by side.

pub(crate) mod stamps;
pub(crate) mod jobs;
pub(crate) mod checked;
pub(crate) mod sync;
pub(crate) mod team;
pub(crate) mod disjoint;
pub(crate) mod shared;
pub(crate) mod pieces;
