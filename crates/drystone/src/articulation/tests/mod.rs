//! Tests of trees.

mod trees;
mod experiment;
mod mujoco;
