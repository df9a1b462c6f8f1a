//! The measuring loop of the benchmarks: an engine runs a scene step by step, and the result is one
//! [`Row`]. The command `drystone bench` runs drystone with it. The workspace `bench/` runs its
//! peers with the same loop, in processes of their own.
//!
//! [`measure`] times the steps and copies poses at some of them. The judges of a run, [`Checker`]
//! and [`stands`], read those copies after the last step. They cost the timed steps nothing, and
//! are the same for every engine.

mod check;
mod engine;
mod linkage;
mod listing;
mod own;
mod row;
mod run;
mod scaling;
mod scenes;
mod series;
mod standing;

pub use check::Checker;
pub use engine::{BodyState, Engine, EngineError, density_factor, hash_states};
pub use linkage::{Linkage, Turn, linkages};
pub use listing::listing;
pub use own::Own;
pub use row::{Deviation, MsPerStep, Row, Stages};
pub use run::{Order, measure};
pub use scaling::{Scaling, scaling, scaling_listing};
pub use scenes::{SceneError, default_steps, expand, times_first_step};
pub use series::{Series, StageClock, count_as_f64, milliseconds};
pub use standing::{stands, still_stands};
