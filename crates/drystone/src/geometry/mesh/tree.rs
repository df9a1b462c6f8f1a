//! A tree over the packs of a mesh, eight boxes per node, for queries with boxes, rotated boxes and
//! rays.

use fearless_simd::{Simd, SimdBase};

use crate::base::aabb::Aabb;
use crate::base::math::Vec3;
use crate::base::simd::wide::{
    LANES, Wide, above, bits, load, max, min, prefetch, reduce_min, select, splat,
};
use crate::geometry::boxes::{Boxes, Ray, nearest_first};
use crate::geometry::bvh::{Bvh, Children};

/// Marks a child that is a pack, not a node.
const LEAF: u32 = 1 << 31;

#[derive(Clone, Debug)]
struct Node {
    /// Bounding boxes of the children [m, local].
    boxes: Boxes,
    children: [u32; LANES],
    count: usize,
}

/// A tree over packs, see the module.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
}

/// The region of a query: a box along the mesh's axes and a rotated box; a result overlaps both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    /// Box along the axes [m, frame of the mesh].
    pub(crate) bounds: Aabb,
    /// Center of the rotated box [m, frame of the mesh].
    pub(crate) center: Vec3,
    /// Unit axes of the rotated box, and its half extents along them [m].
    pub(crate) axes: [Vec3; 3],
    pub(crate) half: Vec3,
}

impl Tree {
    /// Builds the tree from a tree over packs whose items are their numbers.
    pub(super) fn new(packs: &Bvh) -> Self {
        let mut tree = Self::default();
        if let Some(root) = packs.root() {
            tree.add(packs, root);
        }
        tree
    }

    /// Adds a node for the subtree `at`; returns its number.
    fn add(&mut self, packs: &Bvh, at: u32) -> u32 {
        let mut below = vec![at];
        // Opens the largest first, so that the boxes of a node have similar sizes.
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
        self.nodes.push(Node { boxes: Boxes::EMPTY, children: [0; LANES], count: below.len() });
        for (lane, &child) in below.iter().enumerate() {
            let bounds = packs.bounds(child);
            let name = match packs.children(child) {
                Children::Item(pack) => LEAF | pack,
                Children::Nodes(_) => self.add(packs, child),
            };
            let node = &mut self.nodes[number as usize];
            node.children[lane] = name;
            node.boxes.set(lane, bounds);
        }
        number
    }

    /// Lists the packs whose boxes may overlap the window. Returns a lower bound on the distance of
    /// the others from it [m]. `stack` is scratch memory.
    #[inline(always)]
    pub(crate) fn find<S: Simd>(
        &self,
        simd: S,
        window: &Window,
        stack: &mut Vec<u32>,
        packs: &mut Vec<u32>,
    ) -> f32 {
        let none = splat(simd, f32::INFINITY);
        let mut others = none;
        packs.clear();
        stack.clear();
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at as usize];
            let apart = node.apart_from(simd, window);
            let outside = above(apart, splat(simd, 0.0));
            others = min(select(outside, apart, none), others);
            // Lanes not in use are infinitely far, or NaN where infinities cancel.
            let mut inside = !bits(outside) & ((1 << node.count) - 1);
            while inside != 0 {
                let name = node.children[inside.trailing_zeros() as usize];
                inside &= inside - 1;
                if name & LEAF == 0 {
                    prefetch(&self.nodes[name as usize]);
                    stack.push(name);
                } else {
                    packs.push(name & !LEAF);
                }
            }
        }
        reduce_min(others)
    }

    /// Calls `visit` with every pack whose box the segment up to `t = max_fraction` may hit, near
    /// ones first. `visit` returns the new max: smaller to shorten the ray, negative to stop.
    pub(crate) fn ray(&self, ray: &Ray, max_fraction: f32, mut visit: impl FnMut(u32) -> f32) {
        let mut max = max_fraction;
        self.ray_below(0, ray, &mut max, &mut visit);
    }

    fn ray_below(&self, node: u32, ray: &Ray, max: &mut f32, visit: &mut impl FnMut(u32) -> f32) {
        let Some(node) = self.nodes.get(node as usize) else { return };
        nearest_first(node.boxes.entries(ray, *max), max, |lane, max| {
            let name = node.children[lane];
            if name & LEAF == 0 {
                self.ray_below(name, ray, max, visit);
            } else {
                *max = visit(name & !LEAF);
            }
        });
    }

    /// Calls `visit` with every pack whose box overlaps `bounds`.
    pub(crate) fn query(&self, bounds: &Aabb, visit: &mut impl FnMut(u32)) {
        self.query_below(0, bounds, visit);
    }

    fn query_below(&self, node: u32, bounds: &Aabb, visit: &mut impl FnMut(u32)) {
        let Some(node) = self.nodes.get(node as usize) else { return };
        let mut met = node.boxes.overlaps(bounds);
        while met != 0 {
            let name = node.children[met.trailing_zeros() as usize];
            met &= met - 1;
            if name & LEAF == 0 {
                self.query_below(name, bounds, visit);
            } else {
                visit(name & !LEAF);
            }
        }
    }
}

impl Node {
    /// Maximum separation of each child's box from the window over the axes; above 0: no overlap.
    #[inline(always)]
    fn apart_from<S: Simd>(&self, simd: S, window: &Window) -> Wide<S> {
        let mut apart = splat(simd, f32::NEG_INFINITY);
        let mut middles = [apart; 3];
        let mut halves = [apart; 3];
        let a_half = splat(simd, 0.5);
        for axis in 0..3 {
            let (low, high) =
                (load(simd, &self.boxes.min[axis]), load(simd, &self.boxes.max[axis]));
            let above = low - splat(simd, window.bounds.max[axis]);
            let below = splat(simd, window.bounds.min[axis]) - high;
            apart = max(apart, max(above, below));
            middles[axis] = a_half * (low + high) - splat(simd, window.center[axis]);
            halves[axis] = a_half * (high - low);
        }
        for k in 0..3 {
            let (u, reach) = (window.axes[k], window.half[k]);
            let v = u.abs();
            let middle = splat(simd, u.x) * middles[0]
                + splat(simd, u.y) * middles[1]
                + splat(simd, u.z) * middles[2];
            let half = splat(simd, v.x) * halves[0]
                + splat(simd, v.y) * halves[1]
                + splat(simd, v.z) * halves[2];
            apart = max(apart, middle.abs() - half - splat(simd, reach));
        }
        apart
    }
}

#[cfg(test)]
mod tests {
    use super::{Ray, Tree};
    use crate::base::aabb::Aabb;
    use crate::base::math::{Vec3, vec3};
    use crate::geometry::bvh::Bvh;

    fn boxes(n: u32) -> Vec<Aabb> {
        let mut s = 12345_u32;
        let mut next = || {
            s = s.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (s >> 8) as f32 / 16_777_216.0 * 20.0
        };
        (0..n)
            .map(|_| {
                let p = vec3(next(), next(), next());
                Aabb::new(p, p + Vec3::splat(0.1 + 0.1 * next()))
            })
            .collect()
    }

    #[test]
    fn a_query_finds_what_brute_force_finds() {
        let all = boxes(300);
        let tree = Tree::new(&Bvh::build(&all));
        for probe in boxes(30) {
            let mut found = Vec::new();
            tree.query(&probe, &mut |i| found.push(i));
            found.sort_unstable();
            let brute = (0_u32..).zip(&all).filter(|(_, b)| b.overlaps(&probe)).map(|(i, _)| i);
            assert_eq!(found, brute.collect::<Vec<u32>>());
        }
    }

    #[test]
    fn a_ray_meets_what_brute_force_meets() {
        let all = boxes(300);
        let tree = Tree::new(&Bvh::build(&all));
        for probe in boxes(100) {
            let (from, displacement) = (probe.min, (probe.min - probe.max) * 10.0);
            let mut found = Vec::new();
            tree.ray(&Ray::new(from, displacement), 1.0, |i| {
                found.push(i);
                1.0
            });
            found.sort_unstable();
            let inv = vec3(1.0 / displacement.x, 1.0 / displacement.y, 1.0 / displacement.z);
            let meets = |b: &Aabb| b.meets_ray(from, inv, 1.0);
            let brute = (0_u32..).zip(&all).filter(|(_, b)| meets(b)).map(|(i, _)| i);
            assert_eq!(found, brute.collect::<Vec<u32>>());
            let mut calls = 0;
            tree.ray(&Ray::new(from, displacement), 1.0, |_| {
                calls += 1;
                -1.0
            });
            assert_eq!(calls, found.len().min(1), "a negative answer stops the ray");
        }
    }
}
