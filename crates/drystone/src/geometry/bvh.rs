//! A static binary tree of bounding boxes, for the triangles of a mesh.

use crate::base::aabb::Aabb;

const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    /// First child, or NONE for a leaf (then `right` is the leaf's item).
    left: u32,
    right: u32,
}

/// The children of a node.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Children {
    Nodes([u32; 2]),
    Item(u32),
}

/// A tree of items' boxes. An item is the caller's number; a leaf is its position in the tree.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    root: u32,
}

impl Default for Bvh {
    fn default() -> Self {
        Self { nodes: Vec::new(), root: NONE }
    }
}

impl Bvh {
    /// Builds a tree over `boxes`; item `i` is box `i`.
    pub(crate) fn build(boxes: &[Aabb]) -> Self {
        let mut tree = Self::default();
        tree.nodes.reserve(boxes.len() * 2);
        let mut items: Vec<u32> = Vec::with_capacity(boxes.len());
        for (i, bounds) in (0_u32..).zip(boxes) {
            tree.nodes.push(Node { bounds: *bounds, left: NONE, right: i });
            items.push(i);
        }
        if !items.is_empty() {
            tree.root = tree.build_over(&mut items);
        }
        tree
    }

    /// Returns the root node.
    pub(crate) fn root(&self) -> Option<u32> {
        (self.root != NONE).then_some(self.root)
    }

    /// Returns the children of a node.
    pub(crate) fn children(&self, node: u32) -> Children {
        let n = &self.nodes[node as usize];
        if n.left == NONE { Children::Item(n.right) } else { Children::Nodes([n.left, n.right]) }
    }

    /// Bounding box of a node.
    pub(crate) fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    /// Returns groups of at most `maximum` items that lie near each other: the largest subtrees of
    /// up to `maximum` leaves. Items in a group are sorted by number.
    pub(crate) fn groups(&self, maximum: usize) -> Vec<Vec<u32>> {
        let mut groups = Vec::new();
        let mut stack: Vec<u32> = if self.root == NONE { Vec::new() } else { vec![self.root] };
        let mut below = Vec::new();
        while let Some(at) = stack.pop() {
            let mut group = Vec::new();
            below.clear();
            below.push(at);
            while let Some(n) = below.pop() {
                let node = &self.nodes[n as usize];
                if node.left != NONE {
                    below.extend([node.right, node.left]);
                } else if group.len() < maximum {
                    group.push(node.right);
                } else {
                    group.clear();
                    break;
                }
            }
            if group.is_empty() {
                let node = &self.nodes[at as usize];
                stack.extend([node.right, node.left]);
            } else {
                group.sort_unstable();
                groups.push(group);
            }
        }
        groups
    }

    /// Splits along the longest axis of the centers, in eight bins by the surface area heuristic.
    fn build_over(&mut self, leaves: &mut [u32]) -> u32 {
        if let [only] = leaves {
            return *only;
        }
        let centers = leaves
            .iter()
            .map(|l| self.nodes[*l as usize].bounds.center())
            .fold(Aabb::EMPTY, |b, c| Aabb::new(b.min.min(c), b.max.max(c)));
        let size = centers.max - centers.min;
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let middle = if size[axis] > 0.0 && size[axis].is_finite() {
            self.split_by_bins(leaves, axis, centers.min[axis], size[axis])
        } else {
            leaves.len() / 2
        };
        let (low, high) = leaves.split_at_mut(middle);
        let left = self.build_over(low);
        let right = self.build_over(high);
        let bounds = self.nodes[left as usize].bounds.union(&self.nodes[right as usize].bounds);
        self.nodes.push(Node { bounds, left, right });
        u32::try_from(self.nodes.len() - 1).expect("fewer than 2^32 nodes fit in memory")
    }

    /// Partitions the leaves into two sides, neither of them empty; returns the size of the first.
    fn split_by_bins(&self, leaves: &mut [u32], axis: usize, low: f32, size: f32) -> usize {
        const BINS: usize = 8;
        let scale = 8.0 / size;
        let bin_of = |leaf: u32| {
            let x = (self.nodes[leaf as usize].bounds.center()[axis] - low) * scale;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
            let bin = x.clamp(0.0, 7.0) as usize;
            bin
        };
        let mut count = [0_usize; BINS];
        let mut bounds = [Aabb::EMPTY; BINS];
        for leaf in leaves.iter() {
            let b = bin_of(*leaf);
            count[b] += 1;
            bounds[b] = bounds[b].union(&self.nodes[*leaf as usize].bounds);
        }
        let mut after = [Aabb::EMPTY; BINS];
        for b in (0..BINS - 1).rev() {
            after[b] = after[b + 1].union(&bounds[b + 1]);
        }
        let (mut best, mut cost, mut before, mut n) = (0, f32::INFINITY, Aabb::EMPTY, 0);
        for b in 0..BINS - 1 {
            before = before.union(&bounds[b]);
            n += count[b];
            if n == 0 || n == leaves.len() {
                continue;
            }
            #[expect(clippy::cast_precision_loss, reason = "a cost, not a count")]
            let c =
                before.half_area() * n as f32 + after[b].half_area() * (leaves.len() - n) as f32;
            if c < cost {
                (best, cost) = (b, c);
            }
        }
        let middle = partition(leaves, |leaf| bin_of(leaf) <= best);
        if middle == 0 || middle == leaves.len() { leaves.len() / 2 } else { middle }
    }
}

/// Moves the items that satisfy `first` to the front, keeping order on both sides.
fn partition(items: &mut [u32], first: impl Fn(u32) -> bool) -> usize {
    let rest: Vec<u32> = items.iter().copied().filter(|i| !first(*i)).collect();
    let mut n = 0;
    for k in 0..items.len() {
        if first(items[k]) {
            items[n] = items[k];
            n += 1;
        }
    }
    items[n..].copy_from_slice(&rest);
    n
}
