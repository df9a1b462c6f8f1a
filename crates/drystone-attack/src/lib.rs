//! A search for failures of drystone. It makes worlds, programs of calls, files, snapshots and
//! command lines from seeds, runs them, and checks properties that always hold. `docs/attack.md` of
//! the repository describes its use.

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
