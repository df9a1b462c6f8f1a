//! Tests of trees.

mod trees;
mod closed_forms;
mod definitions;
mod identities;
mod lanes;
mod mujoco;
mod passive;
mod rows;
