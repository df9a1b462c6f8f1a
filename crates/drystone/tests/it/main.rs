//! All integration tests, one binary.
#![expect(clippy::unwrap_used, reason = "helpers of tests outside test functions")]

mod contract_limits;
mod contract_executor;
mod contract_world;
mod property_hull;
mod property_snapshot;
mod regression;
mod scenario_articulated;
mod scenario_audit;
mod scenario_breakage;
mod scenario_couplings;
mod scenario_freezing;
mod scenario_fracture;
mod scenario_fast_bodies;
mod scenario_friction;
mod scenario_ghosts;
mod scenario_glue;
mod scenario_hits;
mod scenario_impacts;
mod scenario_joint_work;
mod scenario_inertia;
mod scenario_joints;
mod scenario_mesh;
mod scenario_methods;
mod scenario_motion;
mod scenario_particles;
mod scenario_pinned;
mod scenario_queries;
mod scenario_groups;
mod scenario_threads;
mod scenario_tumble;
mod scenario_turning;
mod scenario_whirl;
mod scenario_seams;
mod scenario_sleep_wake;
mod scenario_sixdof;
