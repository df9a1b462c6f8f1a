//! The measuring loop of the benchmarks: a scene is run by an engine, step by step, and what came of it is
//! one [`Row`]. The command `drystone bench` runs drystone with it; the workspace `bench/` runs its peers
//! with the same loop, in processes of their own.
//!
//! [`measure`] times the steps and copies poses at some of them. Everything that judges a run,
//! [`Checker`] and [`stands`], looks at those copies after the last step: it costs the timed steps
//! nothing, and it is the same for every engine.

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
