//! Tests of the plugin, without a window.

mod bodies;
mod casters;
mod character;
mod complaints;
mod determinism;
mod events;
mod fracture;
mod game;
mod hierarchy;
mod joints;
mod ownership;
mod queries;
mod random;
mod strands;
