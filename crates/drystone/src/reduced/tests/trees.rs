//! Trees for tests: chains, robots, and random ones.

use crate::base::random::Random;
use crate::reduced::step::TreeState;
use crate::reduced::tree::Tree;
use crate::reduced::{LinkDef, TreeDef, TreeJoint};

pub(super) const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// A number from `low` to `high`.
pub(super) fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * random.unit()
}

/// A number below `count`.
pub(super) fn below(random: &mut Random, count: usize) -> usize {
    let count_wide = u32::try_from(count).unwrap_or(u32::MAX);
    let pick = (random.unit() * f64::from(count_wide)).floor();
    (0..count).rev().find(|&i| f64::from(u32::try_from(i).unwrap_or(0)) <= pick).unwrap_or(0)
}

/// A vector of components from −1 to 1.
pub(super) fn vector(random: &mut Random) -> [f64; 3] {
    core::array::from_fn(|_| between(random, -1.0, 1.0))
}

/// Which forces a random tree has.
#[derive(Clone, Copy)]
#[expect(clippy::struct_excessive_bools, reason = "each force is there or not")]
pub(super) struct Kind {
    pub(super) links: [usize; 2],
    pub(super) armature: bool,
    pub(super) damping: bool,
    pub(super) springs: bool,
    pub(super) limits: bool,
    pub(super) friction: bool,
}

pub(super) const BARE: Kind = Kind {
    links: [2, 40],
    armature: false,
    damping: false,
    springs: false,
    limits: false,
    friction: false,
};

/// A random link of about `size` [m] with a mass from 1 g to 100 kg.
fn link(random: &mut Random, parent: Option<usize>, size: f64) -> LinkDef {
    let mass = 10.0_f64.powf(between(random, -3.0, 2.0));
    let scale = mass * size * size * between(random, 0.02, 0.1);
    let moments: [f64; 3] = core::array::from_fn(|_| scale * between(random, 1.0, 2.0));
    let products: [f64; 3] = core::array::from_fn(|_| scale * between(random, -0.2, 0.2));
    let inertia = [moments[0], moments[1], moments[2], products[0], products[1], products[2]];
    let center = vector(random).map(|x| 0.5 * size * x);
    let position = vector(random).map(|x| size * x);
    let rotation = core::array::from_fn(|_| between(random, -1.0, 1.0));
    let position = if parent.is_none() { [0.0; 3] } else { position };
    LinkDef { parent, position, rotation, ..LinkDef::default() }.with_mass(mass, center, inertia)
}

/// A random tree and a random state; limits start violated by up to 20°.
pub(super) fn random_tree(random: &mut Random, kind: &Kind) -> (TreeDef, Vec<f64>, Vec<f64>) {
    let count = kind.links[0] + below(random, kind.links[1] - kind.links[0] + 1);
    let mut def = TreeDef::default();
    let size = between(random, 0.05, 0.5);
    for i in 0..count {
        // Half of the trees' links continue a chain.
        let parent = match i {
            0 => None,
            _ if random.unit() < 0.5 => Some(i - 1),
            _ => Some(below(random, i)),
        };
        let mut link = link(random, parent, size);
        let kinds = below(random, 10);
        link.joints = match (i, kinds) {
            (0, 0..=4) => vec![TreeJoint::free()],
            (_, 0..=4) => vec![TreeJoint::hinge(vector(random))],
            (_, 5) => vec![TreeJoint::slide(vector(random))],
            (_, 6) => vec![TreeJoint::ball()],
            (_, 7) => (0..3).map(|_| TreeJoint::hinge(vector(random))).collect(),
            (_, 8) => TreeJoint::planar([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            _ => vec![TreeJoint::hinge([0.0, 1.0, 0.0])],
        };
        let free = link.joints[0].kind == crate::reduced::TreeJointKind::Free;
        for joint in link.joints.iter_mut().filter(|_| !free) {
            if kind.armature && random.unit() < 0.5 {
                joint.armature = 10.0_f64.powf(between(random, -4.0, 0.0));
            }
            if kind.damping && random.unit() < 0.5 {
                joint.damping = 10.0_f64.powf(between(random, -3.0, 1.0));
            }
            if kind.springs && random.unit() < 0.5 {
                joint.stiffness = 10.0_f64.powf(between(random, -1.0, 3.0));
                joint.rest = between(random, -0.5, 0.5);
            }
            if kind.friction && random.unit() < 0.3 {
                joint.friction = between(random, 0.0, 1.0);
            }
            if kind.limits && random.unit() < 0.7 {
                if joint.kind == crate::reduced::TreeJointKind::Ball {
                    joint.range = Some([0.0, between(random, 0.2, 1.0)]);
                } else {
                    let low = between(random, -1.0, 0.35);
                    joint.range = Some([low, low + between(random, 0.1, 1.5)]);
                }
            }
        }
        def.links.push(link);
    }
    let tree = Tree::new(&def, GRAVITY).unwrap();
    let state = TreeState::new(&tree);
    let v = (0..tree.v_count()).map(|_| between(random, -1.0, 1.0)).collect();
    (def, state.q, v)
}
