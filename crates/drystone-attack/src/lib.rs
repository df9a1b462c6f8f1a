//! A search for what breaks drystone: worlds, programs of calls, files, snapshots and command lines, each made from a
//! seed, run, and held against what must be true of any of them. `docs/attack.md` of the repository says how it is used.

pub mod apply;
mod ask;
pub mod calls;
pub mod campaign;
pub mod commands;
pub mod damage;
pub mod files;
pub mod finding;
pub mod generate;
pub mod hunt;
pub mod minimize;
mod names;
pub mod numbers;
pub mod op;
pub mod oracle;
pub mod probe;
pub mod process;
pub mod report;
pub mod rng;
pub mod run;
pub mod seeds;
pub mod snapshots;
pub mod soak;
pub mod source;
mod source_calls;
mod text;
pub mod unit;
mod values;
pub mod variants;
