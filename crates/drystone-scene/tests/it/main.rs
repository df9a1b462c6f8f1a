//! Tests of the catalog: what its scenes hold, what their parameters refuse, and how they behave.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "tests say what they found")]

mod catalog;
mod contract_determinism;
mod contract_snapshot;
mod scenario_machines;
mod scenario_slopes_and_joints;
mod scenario_standing;
mod scenario_steady;
mod scenario_survey;
