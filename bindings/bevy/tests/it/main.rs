//! Tests of the plugin, without a window.

mod bodies;
mod game;
mod hierarchy;
mod ownership;
