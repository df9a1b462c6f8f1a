//! The same links in reduced coordinates: trees for articulations, beside the bodies and joints.

use drystone::articulation::{Articulation, LinkDef, RowSoftness, TreeCoupling, TreeJoint};
use drystone::{BodyKind, MassDef, Pose, Vec3};

use super::link::{Dof, Hold, Link, Way};
use crate::scene::{Scene, SceneTree};

/// Words of the notes that are about joints between bodies alone.
const OF_JOINTS: [&str; 4] = [
    "counts only with --reduced",
    "stand bodies that take",
    "taken as one ball joint",
    "taken as one of its swing",
];

/// Makes articulations of the trees of a scene when it is built, in place of their joints. Notes
/// about these joints are taken out. False if it has no tree.
pub fn reduce(scene: &mut Scene) -> bool {
    if scene.trees.is_empty() {
        return false;
    }
    scene.reduced = true;
    let is_of_all = |note: &String| !OF_JOINTS.iter().any(|words| note.contains(words));
    scene.notes.retain(is_of_all);
    scene.left_out.retain(is_of_all);
    true
}

/// A group of links that is one body, as the scene has it.
#[derive(Clone, Debug)]
pub(super) struct Made {
    /// Its first link.
    pub(super) head: usize,
    /// Number of its body, and of its parent's.
    pub(super) body: usize,
    pub(super) parent: Option<usize>,
    /// Numbers of the joints that hold it, and of the bodies between them.
    pub(super) joints: core::ops::Range<usize>,
    pub(super) between: core::ops::Range<usize>,
    /// Share of its mass that its body has, beside those between its joints.
    pub(super) share: f32,
}

impl Made {
    /// A group that no joint holds.
    pub(super) const fn alone(head: usize, body: usize) -> Self {
        Self { head, body, parent: None, joints: 0..0, between: 0..0, share: 1.0 }
    }
}

/// Place of a joint of the file in a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct InTree {
    tree: usize,
    link: usize,
    joint: usize,
    reference: f64,
}

/// Adds the trees of these links to the scene. Gives the place of each joint that has one
/// coordinate.
pub(super) fn trees(
    links: &[Link<'_>],
    made: &[Made],
    world: &[Pose],
    scene: &mut Scene,
) -> Vec<(String, InTree)> {
    let (mut places, mut trees) = (Vec::new(), Vec::<SceneTree>::new());
    // Tree and link of each group.
    let mut at: Vec<Option<(usize, usize)>> = vec![None; made.len()];
    // Bodies came one after the other.
    let of_body = |body: usize| made.binary_search_by_key(&body, |m| m.body).ok();
    for (g, group) in made.iter().enumerate() {
        let link = &links[group.head];
        let parent = group.parent.and_then(of_body);
        let kind = |body: usize| scene.bodies[body].def.kind;
        let MassDef::Exact { mass, center, inertia } = scene.bodies[group.body].def.mass else {
            continue;
        };
        let scale = f64::from(group.share).recip();
        let pose = match parent {
            Some(parent) if at[parent].is_some() => {
                world[made[parent].head].relative(&world[group.head])
            }
            _ => world[group.head],
        };
        let mut def = LinkDef::default().with_position(wide(pose.position)).with_mass(
            f64::from(mass) * scale,
            wide(center),
            [inertia.xx, inertia.yy, inertia.zz, inertia.xy, inertia.xz, inertia.yz]
                .map(|x| f64::from(x) * scale),
        );
        let [x, y, z, w] = pose.rotation.to_array();
        def.rotation = [w, x, y, z].map(f64::from);
        let (tree, index) = match (&link.hold, parent) {
            (Hold::Free, _) => {
                def.joints.push(TreeJoint::free());
                trees.push(SceneTree::default());
                (trees.len() - 1, 0)
            }
            (Hold::Joints(dofs), Some(parent)) => {
                let place = match at[parent] {
                    Some((tree, index)) => {
                        def.parent = Some(index);
                        (tree, trees[tree].bodies.len())
                    }
                    // A base that moves by itself is no base of a tree.
                    None if kind(made[parent].body) != BodyKind::Static => continue,
                    None => {
                        trees.push(SceneTree::default());
                        (trees.len() - 1, 0)
                    }
                };
                for dof in dofs {
                    if matches!(dof.way, Way::Hinge | Way::Slide) {
                        let (tree, link) = place;
                        let joint = def.joints.len();
                        let reference = f64::from(dof.reference);
                        let at = InTree { tree, link, joint, reference };
                        places.push((dof.name.clone(), at));
                    }
                    add_joint(dof, &mut def.joints);
                }
                place
            }
            _ => continue,
        };
        at[g] = Some((tree, index));
        let tree = &mut trees[tree];
        tree.bodies.push(group.body);
        tree.def.links.push(def);
        tree.joints.extend(group.joints.clone());
        tree.between.extend(group.between.clone());
    }
    let numbers: Vec<Option<usize>> = trees
        .into_iter()
        .map(|tree| {
            is_possible(&tree, &mut scene.notes).then(|| {
                scene.trees.push(tree);
                scene.trees.len() - 1
            })
        })
        .collect();
    places
        .into_iter()
        .filter_map(|(name, place): (String, InTree)| {
            Some((name, InTree { tree: numbers[place.tree]?, ..place }))
        })
        .collect()
}

/// Adds a joint of the file to those of a link.
fn add_joint(dof: &Dof, joints: &mut Vec<TreeJoint>) {
    let [rest, stiffness, damping] = dof.spring.map(f64::from);
    let reference = f64::from(dof.reference);
    let dress = |mut joint: TreeJoint| {
        joint.anchor = wide(dof.anchor);
        joint.reference = reference;
        joint.damping = damping;
        joint.stiffness = stiffness;
        joint.rest = rest + reference;
        joint.friction = f64::from(dof.friction);
        joint.armature = f64::from(dof.armature);
        joint.range = dof.range.map(|range| range.map(|x| f64::from(x) + reference));
        joint
    };
    match dof.way {
        Way::Hinge => joints.push(dress(TreeJoint::hinge(wide(dof.axis)))),
        Way::Slide => joints.push(dress(TreeJoint::slide(wide(dof.axis)))),
        Way::Ball => {
            let ball = dress(TreeJoint::ball());
            joints.push(TreeJoint { reference: 0.0, rest: 0.0, ..ball });
        }
        Way::Planar => {
            let x = dof.axis.any_perpendicular();
            let y = dof.axis.cross(x);
            let free = |joint: TreeJoint| TreeJoint { range: None, stiffness: 0.0, ..dress(joint) };
            joints.extend(TreeJoint::planar(wide(x), wide(y)).into_iter().map(free));
        }
    }
}

/// Lets a joint follow another in its tree: `ratio` times its coordinate plus `offset`, as the file
/// counts both.
pub(super) fn couple(own: InTree, other: InTree, [ratio, offset]: [f32; 2], scene: &mut Scene) {
    let [ratio, offset] = [ratio, offset].map(f64::from);
    if own.tree != other.tree {
        scene.notes.push(
            "a joint follows one of another robot: not with --reduced, where it moves freely"
                .into(),
        );
        return;
    }
    let start = offset + ratio * other.reference - own.reference;
    scene.trees[own.tree].def.couplings.push(TreeCoupling {
        follower: (own.link, own.joint),
        leader: Some((other.link, other.joint)),
        polynomial: [start, ratio, 0.0, 0.0, 0.0],
        softness: RowSoftness::Rigid,
    });
}

fn wide(v: Vec3) -> [f64; 3] {
    v.to_array().map(f64::from)
}

/// Whether a tree can be an articulation; if not, notes why. A lone body that nothing holds is
/// none.
fn is_possible(tree: &SceneTree, notes: &mut Vec<String>) -> bool {
    if tree.def.links.len() == 1 && tree.joints.is_empty() {
        return false;
    }
    let made = Articulation::new(&tree.def, [0.0; 3]);
    if let Err(e) = &made {
        notes.push(format!("with --reduced, a tree stays bodies and joints: {e}"));
    }
    made.is_ok()
}
