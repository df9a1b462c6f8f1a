//! Boxes of all shapes in two trees: what stays where it is, and what may move.

use super::shapes::Shapes;
use crate::base::aabb::Aabb;
use crate::geometry::bvh::Bvh;

/// The trees, and which shapes must look for new pairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bounds {
    pub(crate) fixed: Bvh,
    pub(crate) moving: Bvh,
    /// Rows of shapes whose box in the tree is new or changed.
    pub(crate) moved: Vec<u32>,
    /// Inserted into the fixed tree since it was built.
    grown: usize,
}

impl Bounds {
    /// Enters a shape with this box.
    pub(crate) fn insert(&mut self, row: u32, fixed: bool, fat: Aabb, shapes: &mut Shapes) {
        let tree = if fixed { &mut self.fixed } else { &mut self.moving };
        let leaf = tree.insert(fat, row);
        let shape = shapes.at_mut(row);
        (shape.leaf, shape.fixed, shape.fat) = (leaf, fixed, fat);
        self.moved.push(row);
        self.grown += usize::from(fixed);
    }

    /// Takes a shape out.
    pub(crate) fn remove(&mut self, row: u32, shapes: &Shapes) {
        let shape = shapes.at(row);
        let tree = if shape.fixed { &mut self.fixed } else { &mut self.moving };
        tree.remove(shape.leaf);
        self.moved.retain(|r| *r != row);
    }

    /// Gives a shape another box.
    pub(crate) fn replace(&mut self, row: u32, fat: Aabb, shapes: &mut Shapes) {
        let shape = shapes.at_mut(row);
        let tree = if shape.fixed { &mut self.fixed } else { &mut self.moving };
        tree.replace(shape.leaf, fat);
        shape.fat = fat;
        self.moved.push(row);
    }

    /// Builds the fixed tree anew when it was mostly grown leaf by leaf.
    pub(crate) fn tidy(&mut self, shapes: usize) {
        if self.grown > 64 && self.grown * 2 > shapes {
            self.fixed.rebuild();
            self.grown = 0;
        }
    }
}
