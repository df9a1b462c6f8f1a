//! Measurements of a run, for programs and for people.

pub(crate) mod audit;
pub(crate) mod measure;
pub(crate) mod page;
mod run;

pub(crate) use self::run::{Report, Run};
