//! All integration tests in one binary. Tests that save worlds need the feature `snapshot`.
#![expect(clippy::unwrap_used, reason = "helpers of tests outside test functions")]

#[cfg(feature = "snapshot")]
mod contract_limits;
mod property_articulations;
#[cfg(feature = "snapshot")]
mod scenario_articulations;
#[cfg(feature = "snapshot")]
mod contract_executor;
mod contract_events;
mod contract_queries;
mod contract_world;
mod floors;
mod property_hull;
#[cfg(feature = "snapshot")]
mod property_rollback;
#[cfg(feature = "snapshot")]
mod property_snapshot;
#[cfg(feature = "snapshot")]
mod regression;
#[cfg(feature = "snapshot")]
mod regression_snapshot;
mod scenario_articulated;
mod scenario_audit;
mod scenario_blows;
mod scenario_breakage;
#[cfg(feature = "snapshot")]
mod changes;
mod scenario_clock;
mod scenario_couplings;
mod scenario_freezing;
#[cfg(feature = "snapshot")]
mod scenario_forces;
mod scenario_fracture;
mod scenario_fast_bodies;
#[cfg(feature = "snapshot")]
mod scenario_friction;
mod scenario_ghosts;
mod scenario_glue;
mod scenario_hits;
#[cfg(feature = "snapshot")]
mod scenario_hooks;
mod scenario_impacts;
mod scenario_joint_work;
mod scenario_jointed_bounces;
mod scenario_inertia;
mod scenario_joints;
#[cfg(feature = "snapshot")]
mod scenario_joint_names;
mod scenario_mesh;
mod scenario_methods;
mod scenario_motion;
mod scenario_mover;
#[cfg(feature = "snapshot")]
mod scenario_one_way;
mod scenario_particles;
#[cfg(feature = "snapshot")]
mod scenario_parting;
mod scenario_pinned;
mod scenario_queries;
mod scenario_put_down;
#[cfg(feature = "snapshot")]
mod scenario_rollback;
mod scenario_groups;
mod scenario_thin_stacks;
mod scenario_threads;
mod scenario_tumble;
#[cfg(feature = "snapshot")]
mod scenario_soft_contacts;
mod scenario_draw;
mod scenario_length_scale;
#[cfg(feature = "snapshot")]
mod scenario_origin;
mod scenario_turning;
mod scenario_turntable;
mod scenario_whirl;
mod scenario_wide_gaps;
#[cfg(feature = "snapshot")]
mod scenario_rules;
mod scenario_seams;
mod sleep_wake;
mod scenario_sixdof;
mod scenario_springs;
mod scenario_squeezed;
mod scenario_stops;
