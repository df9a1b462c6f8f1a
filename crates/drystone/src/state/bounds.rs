//! Boxes of all shapes in two trees: what stays where it is, and what may move.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::bodies::NONE;
use super::shapes::Shapes;
use crate::base::aabb::Aabb;
use crate::base::jobs::Jobs;
use crate::geometry::rtree::RTree;

/// The trees, and which shapes must look for new pairs.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Bounds {
    pub(crate) fixed: RTree,
    pub(crate) moving: RTree,
    /// Rows of shapes whose box in the moving tree is new or changed. Rows of shapes that were removed
    /// since may be among them, and a row may be there twice.
    pub(crate) moved: Vec<u32>,
    /// The same of the fixed tree.
    pub(crate) placed: Vec<u32>,
    /// How often the fixed tree changed.
    pub(crate) fixed_changes: u64,
}

impl Clone for Bounds {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Into the lists that are there.
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

    /// Enters a shape with this box.
    pub(crate) fn insert(&mut self, row: u32, fixed: bool, fat: Aabb, shapes: &mut Shapes) {
        let shape = shapes.at_mut(row);
        (shape.fixed, shape.fat) = (fixed, fat);
        let (tree, changed) = self.tree(fixed);
        tree.insert(&fat, row);
        changed.push(row);
    }

    /// Takes a shape out, if it is in: those of bodies that were put aside are not.
    pub(crate) fn remove(&mut self, row: u32, shapes: &Shapes) {
        let fixed = shapes.at(row).fixed;
        let tree = if fixed { &self.fixed } else { &self.moving };
        if tree.leaf(row) != NONE {
            self.tree(fixed).0.remove(row);
        }
    }

    /// Gives a shape another box.
    pub(crate) fn replace(&mut self, row: u32, fat: Aabb, shapes: &mut Shapes) {
        let shape = shapes.at_mut(row);
        shape.fat = fat;
        let (tree, changed) = self.tree(shape.fixed);
        tree.replace(row, &fat);
        changed.push(row);
    }

    /// Puts the trees in order.
    pub(crate) fn tidy(&mut self, jobs: &Jobs<'_>) {
        self.fixed.tidy(jobs);
        self.moving.tidy(jobs);
    }
}
