//! The node tree: parents, transforms, and which nodes are in the scene.

use drystone::math::Mat3;
use drystone::{Pose, Quat, Vec3, vec3};

use crate::error::SceneError;
use crate::read::json::At;
use crate::transform::{Affine, nearest_rotation, split};

/// Most nodes within each other: films and joints go through all that are above one.
const MOST_DEEP: usize = 1024;

/// A node of the file.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) name: Option<String>,
    pub(crate) parent: Option<usize>,
    pub(crate) children: Vec<usize>,
    /// To the parent.
    pub(crate) local: Affine,
    /// The rotation in it.
    pub(crate) turn: Quat,
    /// To the world.
    pub(crate) world: Affine,
    /// World position and rotation, scale left out.
    pub(crate) pose: Pose,
    /// Scale along the node's own axes [1], with sign; exact unless `sheared`.
    pub(crate) scale: Vec3,
    /// The world transform is more than translation, rotation and scale.
    pub(crate) sheared: bool,
    /// Part of the scene that is shown.
    pub(crate) in_scene: bool,
}

/// All nodes, and the order in which parents come before children (scene roots first, in file
/// order).
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    pub(crate) order: Vec<usize>,
}

impl Tree {
    /// The name of a node: its own, or `#index`.
    pub(crate) fn name(&self, node: usize) -> String {
        match &self.nodes[node].name {
            Some(name) if !name.is_empty() => name.clone(),
            _ => format!("#{node}"),
        }
    }
}

impl Tree {
    /// The pose of a node in the frame of another one above it.
    pub(crate) fn below(&self, above: usize, node: usize) -> Pose {
        let (outer, inner) = (&self.nodes[above], &self.nodes[node]);
        // The file gives this number itself: no rounding.
        if inner.parent == Some(above) && outer.scale == Vec3::ONE && !outer.sheared {
            return Pose::new(inner.local.translation, inner.turn);
        }
        outer.pose.relative(&inner.pose)
    }
}

/// Reads the node tree of a document.
pub(crate) fn read(root: &At<'_>) -> Result<Tree, SceneError> {
    let list = root.list("nodes")?;
    let mut nodes = Vec::with_capacity(list.len());
    let mut turns = Vec::with_capacity(list.len());
    let mut scales = Vec::with_capacity(list.len());
    for at in &list {
        let (local, turn, own_scale) = local_transform(&at.clone().object()?)?;
        scales.push(own_scale);
        let name = at.get("name").map(|n| n.text().map(str::to_owned)).transpose()?;
        let mut children = Vec::new();
        for child in at.list("children")? {
            children.push(child.index(list.len(), "nodes")?);
        }
        turns.push(turn);
        nodes.push(Node {
            name,
            parent: None,
            children,
            local,
            turn,
            world: local,
            pose: Pose::IDENTITY,
            scale: Vec3::ONE,
            sheared: false,
            in_scene: false,
        });
    }
    for i in 0..nodes.len() {
        for (k, child) in nodes[i].children.clone().into_iter().enumerate() {
            if let Some(other) = nodes[child].parent.replace(i) {
                let problem = format!("node {child} is a child of node {other} already");
                let children = list[i].need("children")?.items()?;
                return Err(children[k].error(problem, "a tree: one parent a node, no cycle"));
            }
        }
    }
    let order = depth_first(&nodes);
    if order.len() != nodes.len() {
        // Every node has at most one parent, so nodes that no root reaches run in a circle.
        let mut seen = vec![false; nodes.len()];
        order.iter().for_each(|&n| seen[n] = true);
        let lost = seen.iter().position(|s| !s).unwrap_or(0);
        return Err(list[lost].error("it is its own ancestor", "a tree: no cycle of nodes"));
    }
    let mut depth = vec![0_usize; nodes.len()];
    for &i in &order {
        depth[i] = nodes[i].parent.map_or(0, |p| depth[p] + 1);
        if depth[i] > MOST_DEEP {
            let allowed = format!("up to {MOST_DEEP} nodes above one another");
            return Err(list[i].error("it stands too deep in other nodes", &allowed));
        }
    }
    mark_scene(root, &mut nodes, &order)?;
    let mut turn_world = turns.clone();
    for &i in &order {
        if let Some(p) = nodes[i].parent {
            nodes[i].world = nodes[p].world.compose(&nodes[i].local);
            turn_world[i] = (turn_world[p] * turns[i]).normalized();
        }
        let world = nodes[i].world;
        if !(world.translation.is_finite() && finite(&world.linear)) {
            return Err(list[i].error("its world transform is not finite", "finite numbers"));
        }
        let (rotation, scale, sheared) = split(world.linear, turn_world[i]);
        nodes[i].pose = Pose::new(world.translation, rotation);
        nodes[i].scale = scale;
        nodes[i].sheared = sheared;
        // The file gives this number itself: no rounding.
        let is_plain =
            nodes[i].parent.is_none_or(|p| nodes[p].scale == Vec3::ONE && !nodes[p].sheared);
        if let Some(own) = scales[i].filter(|_| is_plain && rotation == turn_world[i]) {
            nodes[i].scale = own;
        }
    }
    Ok(Tree { nodes, order })
}

fn finite(m: &Mat3) -> bool {
    m.x.is_finite() && m.y.is_finite() && m.z.is_finite()
}

/// Parents before children, from the nodes without parent, in file order.
fn depth_first(nodes: &[Node]) -> Vec<usize> {
    let mut order = Vec::with_capacity(nodes.len());
    let mut stack: Vec<usize> =
        (0..nodes.len()).rev().filter(|&i| nodes[i].parent.is_none()).collect();
    while let Some(i) = stack.pop() {
        order.push(i);
        stack.extend(nodes[i].children.iter().rev());
    }
    order
}

/// Marks what hangs below the roots of the default scene; without scenes everything is in it.
fn mark_scene(root: &At<'_>, nodes: &mut [Node], order: &[usize]) -> Result<(), SceneError> {
    let scenes = root.list("scenes")?;
    let chosen = match root.get("scene") {
        Some(at) => Some(at.index(scenes.len(), "scenes")?),
        None => (!scenes.is_empty()).then_some(0),
    };
    let Some(chosen) = chosen else {
        nodes.iter_mut().for_each(|n| n.in_scene = true);
        return Ok(());
    };
    for at in scenes[chosen].list("nodes")? {
        let i = at.index(nodes.len(), "nodes")?;
        nodes[i].in_scene = true;
    }
    for &i in order {
        if let Some(p) = nodes[i].parent {
            nodes[i].in_scene |= nodes[p].in_scene;
        }
    }
    Ok(())
}

/// A node's own transform, its rotation alone, and its scale if the file says it.
fn local_transform(at: &At<'_>) -> Result<(Affine, Quat, Option<Vec3>), SceneError> {
    if let Some(matrix) = at.get("matrix") {
        let m = matrix.numbers::<16>()?;
        let column = |i: usize| vec3(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
        let linear = Mat3 { x: column(0), y: column(1), z: column(2) };
        let near = |a: f32, b: f32| (a - b).abs() < 1.0e-4;
        if !(near(m[3], 0.0) && near(m[7], 0.0) && near(m[11], 0.0) && near(m[15], 1.0)) {
            return Err(matrix
                .error("its last row is not 0, 0, 0, 1", "an affine matrix, column by column"));
        }
        let (rotation, _, _) = split(linear, nearest_rotation(linear));
        return Ok((Affine { linear, translation: column(3) }, rotation, None));
    }
    let translation = at.vec3_or("translation", Vec3::ZERO)?;
    let rotation = at.get("rotation").map_or(Ok(Quat::IDENTITY), |at| at.quat())?;
    let scale = at.vec3_or("scale", Vec3::ONE)?;
    let r = rotation.to_mat3();
    let linear = Mat3 { x: r.x * scale.x, y: r.y * scale.y, z: r.z * scale.z };
    let own = at.get("scale").map(|_| scale);
    Ok((Affine { linear, translation }, rotation, own))
}
