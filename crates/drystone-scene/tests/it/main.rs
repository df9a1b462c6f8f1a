//! Tests of the catalog: what its scenes hold, what their parameters refuse, and how they behave.

mod catalog;
mod contract_determinism;
mod scenario_slopes_and_joints;
mod scenario_standing;
