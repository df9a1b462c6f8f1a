//! All integration tests, one binary.

mod contract_world;
mod property_hull;
mod scenario_motion;
