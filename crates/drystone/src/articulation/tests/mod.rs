//! Tests of trees.

mod trees;
mod experiment;
