//! Finds the trees of joints that are solved directly, and orders their joints.
//!
//! Bodies connected by joints form components. A component is solved directly if its joints are
//! balls or six-axis joints and close no loop over moving bodies. In addition, some body in it must
//! pass on the weight of many times its own mass, or one of its joints must request direct solving.
//! A six-axis joint without a locked axis connects nothing. All other components are solved joint
//! by joint.
//!
//! A static or kinematic body connects nothing: a joint to it is a leaf. The forest is rebuilt only
//! when a joint is added or removed, or when a body on a joint wakes or falls asleep. See
//! docs/decisions/017-direct-joint-trees.md.

use core::ops::Range;

use super::group::Group;
use super::joint_class::SIX_DIRECT;
use super::layout::Layout;
use crate::base::simd::wide::LANES;
use crate::state::bodies::{Bodies, NONE};
use crate::state::colors::Colors;
use crate::state::joints::{JointModel, Joints};

/// A joint of a tree; its bodies are indices into [`Forest::bodies`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeJoint {
    pub(crate) row: u32,
    pub(crate) child: u32,
    /// [`NONE`]: the world.
    pub(crate) parent: u32,
    /// The child is the joint's body A.
    pub(crate) is_child_a: bool,
    /// Block and lane of a six-axis joint, as block × lanes + lane; [`NONE`] for a ball joint.
    pub(crate) six_dof: u32,
}

/// A tree. Its bodies stand after their children, so the root is last. Its joints to the world
/// stand first, then the joint from each body except the root to its parent, in the order of
/// bodies.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub(crate) bodies: Range<usize>,
    pub(crate) joints: Range<usize>,
    /// Factor on the tree's compliance.
    pub(crate) slack: f64,
    /// Number of drives and limits of its joints, and the position of their mutual responses.
    pub(crate) scalars: usize,
    pub(crate) gains: Range<usize>,
}

/// Factor on the compliance of a tree that the world holds at two or more places. Its joints may
/// contradict each other, and only compliance bounds their impulses then. (With 1, a chain of 6 m
/// between posts 0.2 m too far apart flew apart within two seconds.)
const HELD_TWICE: f64 = 10.0;

/// A joint's end at a moving body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct End {
    body: u32,
    joint: u32,
    /// The body at the other end, or [`NONE`].
    other: u32,
    is_a: bool,
}

/// All awake trees.
#[derive(Clone, Debug, Default)]
pub(crate) struct Forest {
    pub(crate) trees: Vec<Tree>,
    /// Rows in the table of bodies.
    pub(crate) bodies: Vec<u32>,
    pub(crate) joints: Vec<TreeJoint>,
    /// Numbers of trees by group.
    pub(crate) order: Vec<u32>,
    ratio: f32,
    keys: Vec<(u32, u32)>,
    ends: Vec<End>,
    /// Representative of the component of each body row on a joint.
    roots: Vec<u32>,
    /// Whether the component of each representative cannot be solved directly.
    unfit: Vec<bool>,
    /// Whether some joint of the component requests direct solving.
    asked: Vec<bool>,
    /// Rows and places of six-axis joints.
    places: Vec<(u32, u32)>,
    /// Parent's number of each body of a tree, and the joint end that leads to the parent.
    parents: Vec<(u32, Option<End>)>,
    sides: Vec<Side>,
}

/// Load on a body from the far side of the root.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    mass: f64,
    /// The two largest loads that pull on the body.
    pulls: [f64; 2],
    /// Number of joints to the world.
    holds: usize,
}

impl Side {
    fn pull(&mut self, load: f64) {
        if load > self.pulls[0] {
            self.pulls = [load, self.pulls[0]];
        } else if load > self.pulls[1] {
            self.pulls[1] = load;
        }
    }
}

fn number(n: usize) -> u32 {
    u32::try_from(n).expect("fewer than 2^32 bodies")
}

impl Forest {
    /// True if trees were chosen with this mass ratio.
    pub(crate) fn is_by(&self, ratio: f32) -> bool {
        self.ratio.to_bits() == ratio.to_bits()
    }

    /// Finds the trees among the joints in the colors, and marks their joints.
    pub(crate) fn form(
        &mut self,
        bodies: &Bodies,
        joints: &mut Joints,
        colors: &Colors,
        solver_row_of: &[u32],
        ratio: f32,
    ) {
        self.ratio = ratio;
        self.trees.clear();
        self.bodies.clear();
        self.joints.clear();
        self.ends.clear();
        let all = || {
            let colorings = [&colors.joints, &colors.joints_fixed];
            let colors = colorings.into_iter().flat_map(|coloring| &coloring.colors);
            colors.flat_map(|color| color.members.iter().copied())
        };
        if all().next().is_none() {
            return;
        }
        let end = |body: u32| if solver_row_of[body as usize] == 0 { NONE } else { body };
        self.begin_components(bodies);
        for row in all() {
            let joint = joints.at_mut(row);
            joint.is_direct = false;
            let (a, b) = (end(joint.body_a), end(joint.body_b));
            // A joint may still name a body that was deactivated.
            if (a, b) != (NONE, NONE) && connects(&joint.model) {
                let fits = matches!(joint.model, JointModel::Ball | JointModel::SixDof(_));
                self.connect(a, b, fits, joint.articulated);
            }
        }
        for row in all() {
            let joint = joints.at(row);
            let (a, b) = (end(joint.body_a), end(joint.body_b));
            if (a, b) == (NONE, NONE) || !connects(&joint.model) {
                continue;
            }
            let root = find(&mut self.roots, if a == NONE { b } else { a });
            if self.unfit[root as usize] {
                continue;
            }
            for (body, other, is_a) in [(a, b, true), (b, a, false)] {
                if body != NONE {
                    self.ends.push(End { body, joint: row, other, is_a });
                }
            }
        }
        self.ends.sort_unstable();
        self.keys.clear();
        for end in &self.ends {
            if self.keys.last().is_none_or(|(_, body)| *body != end.body) {
                self.keys.push((find(&mut self.roots, end.body), end.body));
            }
        }
        self.keys.sort_unstable();
        let keys = core::mem::take(&mut self.keys);
        for component in keys.chunk_by(|a, b| a.0 == b.0) {
            // The joints of a single body cannot conflict.
            if component.len() > 1 {
                self.grow(component[0].1, component.len(), bodies, joints);
            }
        }
        self.keys = keys;
    }

    /// Makes each body a component of its own.
    fn begin_components(&mut self, bodies: &Bodies) {
        self.roots.clear();
        self.unfit.clear();
        let n = bodies.rows.slot_count();
        self.roots.extend(0..number(n));
        self.unfit.resize(n, false);
        self.asked.clear();
        self.asked.resize(n, false);
        for row in &bodies.awake {
            self.unfit[*row as usize] = bodies.at(*row).inertia.locks.linear != [false; 3];
        }
    }

    /// Unites the components of a joint's bodies, or records a loop. The body with the lowest row
    /// represents a component.
    fn connect(&mut self, a: u32, b: u32, fits: bool, asks: bool) {
        let one = find(&mut self.roots, if a == NONE { b } else { a });
        self.unfit[one as usize] |= !fits;
        self.asked[one as usize] |= asks;
        if a == NONE || b == NONE {
            return;
        }
        let other = find(&mut self.roots, b);
        let (low, high) = (one.min(other), one.max(other));
        self.unfit[low as usize] |= one == other || self.unfit[high as usize];
        self.asked[low as usize] |= self.asked[high as usize];
        self.roots[high as usize] = low;
    }

    fn ends_of(&self, body: u32) -> Range<usize> {
        let first = self.ends.partition_point(|e| e.body < body);
        first..self.ends.partition_point(|e| e.body <= body)
    }

    /// Adds the tree of `root` if it needs a direct solve.
    fn grow(&mut self, root: u32, count: usize, bodies: &Bodies, joints: &mut Joints) {
        let (first_body, first_joint) = (self.bodies.len(), self.joints.len());
        let last = first_body + count - 1;
        self.bodies.resize(first_body + count, NONE);
        self.parents.clear();
        self.parents.resize(count, (NONE, None));
        // Walk outward from the root, and fill the list from its end to its beginning.
        self.bodies[last] = root;
        let mut free = last;
        for at in (first_body..=last).rev() {
            let body = self.bodies[at];
            let up = self.parents[at - first_body].1;
            for i in self.ends_of(body) {
                let end = self.ends[i];
                if up.is_some_and(|up| up.joint == end.joint) {
                    continue;
                }
                if end.other == NONE {
                    let child = number(at);
                    let is_child_a = end.is_a;
                    self.joints.push(TreeJoint {
                        row: end.joint,
                        child,
                        parent: NONE,
                        is_child_a,
                        six_dof: NONE,
                    });
                } else {
                    free -= 1;
                    self.bodies[free] = end.other;
                    self.parents[free - first_body] = (number(at), Some(end));
                }
            }
        }
        debug_assert!(free == first_body, "a component without loops is a tree");
        let holds = self.joints.len() - first_joint;
        for at in first_body..last {
            let (parent, end) = self.parents[at - first_body];
            let end = end.expect("all but the root were met by a joint");
            let (child, is_child_a) = (number(at), !end.is_a);
            self.joints.push(TreeJoint {
                row: end.joint,
                child,
                parent,
                is_child_a,
                six_dof: NONE,
            });
        }
        let slack = if holds > 1 { HELD_TWICE } else { 1.0 };
        let joints_of = first_joint..self.joints.len();
        let mut scalars = 0;
        for joint in &self.joints[joints_of.clone()] {
            if let JointModel::SixDof(six_dof) = &joints.at(joint.row).model {
                scalars += six_dof.def.scalar_count();
            }
        }
        let first_gain = self.trees.last().map_or(0, |tree| tree.gains.end);
        let gains = first_gain..first_gain + scalars * scalars;
        let bodies_of = first_body..last + 1;
        let tree = Tree { bodies: bodies_of, joints: joints_of, slack, scalars, gains };
        let is_asked = self.asked[find(&mut self.roots, root) as usize];
        if is_asked || self.strain(&tree, bodies) >= f64::from(self.ratio) {
            for joint in &self.joints[tree.joints.clone()] {
                joints.at_mut(joint.row).is_direct = true;
            }
            self.trees.push(tree);
        } else {
            self.bodies.truncate(first_body);
            self.joints.truncate(first_joint);
        }
    }

    /// The maximum load that a body of the tree passes on, relative to its own mass: the second
    /// largest of the masses that pull on it. A support by the world counts as the total mass.
    fn strain(&mut self, tree: &Tree, bodies: &Bodies) -> f64 {
        let (first, n) = (tree.bodies.start, tree.bodies.len());
        let rows = &self.bodies[tree.bodies.clone()];
        let mass = |i: usize| f64::from(bodies.at(rows[i]).inertia.mass);
        let total: f64 = (0..n).map(mass).sum();
        let sides = &mut self.sides;
        sides.clear();
        sides.extend((0..n).map(|i| Side { mass: mass(i), ..Side::default() }));
        let held = |joint: &&TreeJoint| joint.parent == NONE;
        let holds = self.joints[tree.joints.clone()].iter().take_while(held).count();
        for joint in &self.joints[tree.joints.clone()][..holds] {
            let side = &mut sides[joint.child as usize - first];
            side.holds += 1;
            side.pull(total);
        }
        // First toward the root: loads from below. Then back: loads from above.
        let links = &self.joints[tree.joints.clone()][holds..];
        for joint in links {
            let (child, parent) = (joint.child as usize - first, joint.parent as usize - first);
            let below = sides[child];
            let up = &mut sides[parent];
            up.mass += below.mass;
            up.holds += below.holds;
            up.pull(if below.holds > 0 { total } else { below.mass });
        }
        for joint in links {
            let child = &mut sides[joint.child as usize - first];
            child.pull(if holds > child.holds { total } else { total - child.mass });
        }
        (0..n).fold(0.0, |maximum, i| {
            crate::base::double::greater(sides[i].pulls[1] / mass(i), maximum)
        })
    }
}

impl Forest {
    /// Records the block and lane of each six-axis joint.
    pub(crate) fn locate(&mut self, six_dof: &Layout) {
        self.places.clear();
        if self.joints.is_empty() {
            return;
        }
        let direct = six_dof.batches.iter().filter(|batch| batch.class & SIX_DIRECT != 0);
        for block in direct.flat_map(|batch| batch.blocks.clone()) {
            let lanes = six_dof.owners[block].iter().enumerate();
            let owned = lanes.filter(|(_, row)| **row != NONE);
            self.places.extend(owned.map(|(lane, row)| (*row, number(block * LANES + lane))));
        }
        self.places.sort_unstable();
        for joint in &mut self.joints {
            let found = self.places.binary_search_by_key(&joint.row, |(row, _)| *row);
            joint.six_dof = found.map_or(NONE, |at| self.places[at].1);
        }
    }

    /// Sorts the trees by group.
    pub(crate) fn place(
        &mut self,
        group_of_row: &[u32],
        solver_row_of: &[u32],
        groups: &mut [Group],
    ) {
        let (trees, bodies) = (&self.trees, &self.bodies);
        let group = |tree: &u32| {
            let body = bodies[trees[*tree as usize].bodies.start];
            group_of_row[solver_row_of[body as usize] as usize]
        };
        self.order.clear();
        self.order.extend(0..number(trees.len()));
        self.order.sort_unstable_by_key(|tree| (group(tree), *tree));
        for (number, of) in (0..).zip(groups) {
            let first = self.order.partition_point(|tree| group(tree) < number);
            of.trees = first..self.order.partition_point(|tree| group(tree) <= number);
        }
    }
}

/// False for a six-axis joint without a locked axis.
fn connects(link: &JointModel) -> bool {
    !matches!(link, JointModel::SixDof(six_dof) if !six_dof.def.holds_any())
}

/// The representative of a body's component.
fn find(roots: &mut [u32], body: u32) -> u32 {
    let mut at = body;
    while roots[at as usize] != at {
        roots[at as usize] = roots[roots[at as usize] as usize];
        at = roots[at as usize];
    }
    at
}
