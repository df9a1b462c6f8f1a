//! Boxes of all shapes in two trees: fixed shapes, and shapes that may move.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::bodies::NONE;
use super::shapes::Shapes;
use crate::base::aabb::Aabb;
use crate::base::threads::jobs::Jobs;
use crate::geometry::rtree::RTree;

/// The trees, and the shapes that must search for new pairs.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Bounds {
    pub(crate) fixed: RTree,
    pub(crate) moving: RTree,
    /// Rows of shapes whose box in the moving tree is new or changed. A row may occur twice, or
    /// belong to a shape that was removed since.
    pub(crate) moved: Vec<u32>,
    /// The same for the fixed tree.
    pub(crate) placed: Vec<u32>,
    /// Number of changes of the fixed tree.
    pub(crate) fixed_changes: u64,
}

impl Clone for Bounds {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { fixed, moving, moved, placed, fixed_changes } = from;
        self.fixed.clone_from(fixed);
        self.moving.clone_from(moving);
        self.moved.clone_from(moved);
        self.placed.clone_from(placed);
        self.fixed_changes = *fixed_changes;
    }
}

impl Bounds {
    fn tree(&mut self, fixed: bool) -> (&mut RTree, &mut Vec<u32>) {
        if fixed {
            self.fixed_changes += 1;
            (&mut self.fixed, &mut self.placed)
        } else {
            (&mut self.moving, &mut self.moved)
        }
    }

    /// Inserts a shape with this box.
    pub(crate) fn insert(&mut self, row: u32, fixed: bool, fat: Aabb, shapes: &mut Shapes) {
        let shape = shapes.at_mut(row);
        (shape.fixed, shape.fat) = (fixed, fat);
        let (tree, changed) = self.tree(fixed);
        tree.insert(&fat, row);
        changed.push(row);
    }

    /// Removes a shape from its tree, if it is there. Shapes of bodies that were put aside are not.
    pub(crate) fn remove(&mut self, row: u32, shapes: &Shapes) {
        let fixed = shapes.at(row).fixed;
        let tree = if fixed { &self.fixed } else { &self.moving };
        if tree.leaf(row) != NONE {
            self.tree(fixed).0.remove(row);
        }
    }

    /// Replaces the box of a shape.
    pub(crate) fn replace(&mut self, row: u32, fat: Aabb, shapes: &mut Shapes) {
        let shape = shapes.at_mut(row);
        shape.fat = fat;
        let (tree, changed) = self.tree(shape.fixed);
        tree.replace(row, &fat);
        changed.push(row);
    }

    /// Rebalances the trees.
    pub(crate) fn tidy(&mut self, jobs: &Jobs<'_>) {
        self.fixed.tidy(jobs);
        self.moving.tidy(jobs);
    }
}
