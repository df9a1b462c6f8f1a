//! Tests of trees.

mod trees;
mod whole;
mod closed_forms;
mod definitions;
mod identities;
mod lanes;
mod mujoco;
mod passive;
mod rows;
