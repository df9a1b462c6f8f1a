#![doc = include_str!("../manual/links.txt")]
#![doc = include_str!("../manual/README.md")]

// Links to chapters and items are defined in `links.txt`. It is included before each chapter, since
// the first definition of a label counts; on the repository's pages the definitions at the end of a
// chapter lead to the files. It begins with a comment, which ends the paragraph before it.

/// A world, ids, errors, time and frames, numbers.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/first_steps.md")]
pub mod first_steps {}

/// Names of Rapier, Avian, Box3D and Jolt, and what differs.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/from_other_engines.md")]
pub mod from_other_engines {}

/// Kinds, mass, forces and impulses, lifts, teleports, changing what lives.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/bodies.md")]
pub mod bodies {}

/// Forms, hulls, meshes, compounds, filters.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/shapes.md")]
pub mod shapes {}

/// Friction, restitution, rolling, belts, one-way surfaces, hooks.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/materials.md")]
pub mod materials {}

/// Hinges, sliders, wheels, ropes, motors, gears.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/joints.md")]
pub mod joints {}

/// Robots, cranes and chains in reduced coordinates.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/articulations.md")]
pub mod articulations {}

/// Ropes, cloths, dust.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/particles.md")]
pub mod particles {}

/// Joints that break, glue, fracture.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/breakage.md")]
pub mod breakage {}

/// A character that walks, climbs and rides.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/character.md")]
pub mod character {}

/// Touches, hits, forces, sensors.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/events.md")]
pub mod events {}

/// Rays, casts, overlaps, contacts.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/queries.md")]
pub mod queries {}

/// Copies, snapshots, deltas, journals, servers.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/saving_and_rollback.md")]
#[cfg(feature = "snapshot")]
pub mod saving_and_rollback {}

/// Energy, overlaps, errors, one collision by itself.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/audit.md")]
pub mod audit {}

/// All cores, the same bits, what breaks them.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/threads_and_determinism.md")]
pub mod threads_and_determinism {}

/// When bodies fall asleep and what wakes them.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/sleep.md")]
pub mod sleep {}

/// SI, sizes that work well, ranges of all numbers, faults.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/units_and_limits.md")]
pub mod units_and_limits {}

/// Symptoms, causes and cures; the knobs and their defaults.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/tuning.md")]
pub mod tuning {}

/// Other solvers, to compare.
#[doc = include_str!("../manual/links.txt")]
#[doc = include_str!("../manual/methods.md")]
pub mod methods {}
