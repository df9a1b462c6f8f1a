//! A tree over the packs of a mesh, eight boxes a node, for queries with a turned box.

use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater, lesser};
use crate::base::wide::{LANES, Lanes};
use crate::geometry::bvh::{Bvh, Children};

/// Marks a child that is a pack, not a node.
const LEAF: u32 = 1 << 31;

#[derive(Clone, Debug)]
struct Node {
    /// Coordinate, child [m, local].
    min: [Lanes; 3],
    max: [Lanes; 3],
    children: [u32; LANES],
    count: usize,
}

/// See the module.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
}

/// What is looked for: boxes that meet one box along the axes and another along its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    /// [m, frame of the mesh].
    pub(crate) bounds: Aabb,
    /// Middle of the turned box [m, frame of the mesh].
    pub(crate) center: Vec3,
    /// Unit axes of the turned box, and how far it reaches along each of them [m].
    pub(crate) axes: [Vec3; 3],
    pub(crate) half: Vec3,
}

impl Tree {
    /// Of a tree over packs whose items are their numbers.
    pub(super) fn new(packs: &Bvh) -> Self {
        let mut tree = Self::default();
        if let Some(root) = packs.root() {
            tree.add(packs, root);
        }
        tree
    }

    /// Adds a node for what is below `at`; returns its number.
    fn add(&mut self, packs: &Bvh, at: u32) -> u32 {
        let mut below = vec![at];
        // The largest is opened first, so that the boxes of a node are of like size.
        while below.len() < LANES {
            let open = |n: &u32| matches!(packs.children(*n), Children::Nodes(_));
            let area = |k: usize| packs.bounds(below[k]).half_area();
            let largest = (0..below.len())
                .filter(|k| open(&below[*k]))
                .max_by(|i, j| area(*i).total_cmp(&area(*j)).then(j.cmp(i)));
            let Some(k) = largest else { break };
            if let Children::Nodes([left, right]) = packs.children(below[k]) {
                below[k] = left;
                below.insert(k + 1, right);
            }
        }
        let number = u32::try_from(self.nodes.len()).unwrap_or(LEAF - 1);
        self.nodes.push(Node {
            min: [[f32::INFINITY; LANES]; 3],
            max: [[f32::NEG_INFINITY; LANES]; 3],
            children: [0; LANES],
            count: below.len(),
        });
        for (lane, &child) in below.iter().enumerate() {
            let bounds = packs.bounds(child);
            let name = match packs.children(child) {
                Children::Item(pack) => LEAF | pack,
                Children::Nodes(_) => self.add(packs, child),
            };
            let node = &mut self.nodes[number as usize];
            node.children[lane] = name;
            for axis in 0..3 {
                node.min[axis][lane] = bounds.min[axis];
                node.max[axis][lane] = bounds.max[axis];
            }
        }
        number
    }

    /// Lists the packs whose boxes may meet the window; returns how far the others are from it, at
    /// least [m]. `stack` is memory.
    pub(crate) fn find(&self, window: &Window, stack: &mut Vec<u32>, packs: &mut Vec<u32>) -> f32 {
        let mut others = f32::INFINITY;
        packs.clear();
        stack.clear();
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at as usize];
            let apart = node.apart_from(window);
            for (name, apart) in node.children[..node.count].iter().zip(apart) {
                if apart > 0.0 {
                    others = lesser(others, apart);
                } else if name & LEAF == 0 {
                    stack.push(*name);
                } else {
                    packs.push(name & !LEAF);
                }
            }
        }
        others
    }
}

impl Node {
    /// How far each child's box is apart from the window along one of its axes; above 0: they do not
    /// meet.
    #[inline]
    fn apart_from(&self, window: &Window) -> Lanes {
        let mut apart = [f32::NEG_INFINITY; LANES];
        for axis in 0..3 {
            let (low, high) = (window.bounds.min[axis], window.bounds.max[axis]);
            let (min, max) = (&self.min[axis], &self.max[axis]);
            for i in 0..LANES {
                apart[i] = greater(apart[i], greater(min[i] - high, low - max[i]));
            }
        }
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let (min, max, center) = (&self.min[axis], &self.max[axis], window.center[axis]);
            let mut middle = [0.0; LANES];
            let mut half = [0.0; LANES];
            for i in 0..LANES {
                middle[i] = 0.5 * (min[i] + max[i]) - center;
                half[i] = 0.5 * (max[i] - min[i]);
            }
            (middle, half)
        });
        for (k, u) in window.axes.iter().enumerate() {
            let (v, reach) = (u.abs(), window.half[k]);
            for i in 0..LANES {
                let middle = u.x * x.0[i] + u.y * y.0[i] + u.z * z.0[i];
                let half = v.x * x.1[i] + v.y * y.1[i] + v.z * z.1[i];
                let away = greater(middle, -middle);
                apart[i] = greater(apart[i], away - half - reach);
            }
        }
        apart
    }
}
