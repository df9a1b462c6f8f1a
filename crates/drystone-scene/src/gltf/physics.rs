//! From nodes with `KHR_physics_rigid_bodies` to bodies.

use std::collections::BTreeMap;

use drystone::math::Sym3;
use drystone::{BodyDef, BodyKind, Filter, MassDef, Material, Pose, Quat, Shape, ShapeDef, Vec3};

use super::document::Document;
use super::geometry::Geometry;
use super::joints::{self, Described};
use super::nodes::Tree;
use super::surface;
use crate::error::SceneError;
use crate::mass::mass_of;
use crate::read::json::At;
use crate::scene::SceneJoint;

/// Name of the extension.
pub(crate) const EXTENSION: &str = "KHR_physics_rigid_bodies";

/// Name of the mark, in a node's `extras`, of a static body whose colliders hang below it. The
/// extension has no such thing; [`crate::bake::write_scene`] writes it.
pub(crate) const STATIC_BODY: &str = "staticBody";

/// Mass that stands for an infinite one [kg].
const INFINITE_MASS: f32 = 1.0e9;

/// A body and its node.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) node: usize,
    pub(crate) def: BodyDef,
}

/// True if the document has the extension at all.
pub(crate) fn is_present(root: &At<'_>) -> Result<bool, SceneError> {
    if root.dig(&["extensions", EXTENSION]).is_some() {
        return Ok(true);
    }
    Ok(root.list("nodes")?.iter().any(|n| n.dig(&["extensions", EXTENSION]).is_some()))
}

/// The nodes with physics, before shapes are made.
struct Nodes<'a> {
    /// The extension object of each node that has one and is in the scene.
    extension: BTreeMap<usize, At<'a>>,
    /// The node that each node belongs to: with motion, or marked as a static body.
    motion: Vec<Option<usize>>,
    /// For members of a compound trigger: the node that stands for it.
    trigger_of: BTreeMap<usize, usize>,
}

/// The bodies of the document, in the order of the node tree, and its joints.
pub(crate) fn read(
    document: &Document,
    tree: &Tree,
    notes: &mut Vec<String>,
) -> Result<(Vec<Found>, Vec<SceneJoint>), SceneError> {
    let root = At::root(&document.json);
    let top = root.dig(&["extensions", EXTENSION]);
    let materials = surface::materials(top.as_ref(), notes)?;
    let filters = surface::filters(top.as_ref(), notes)?;
    let nodes = survey(&root, tree, notes)?;
    let mut geometry = Geometry::new(document, tree)?;
    // Bodies by node; a body stands where the node that names it stands in the tree.
    let mut found: BTreeMap<usize, BodyDef> = BTreeMap::new();
    for (&node, extension) in &nodes.extension {
        if let Some(motion) = extension.get("motion") {
            found.insert(node, moving(&motion, tree, node)?);
        }
    }
    for &node in &tree.order {
        let Some(extension) = nodes.extension.get(&node) else { continue };
        let parts = [("collider", false), ("trigger", true)];
        for (key, sensor) in parts {
            let Some(at) = extension.get(key) else { continue };
            let at = at.object()?;
            if sensor && at.get("nodes").is_some() {
                continue;
            }
            let group = if sensor { nodes.trigger_of.get(&node).copied() } else { None };
            let owner = nodes.motion[node].or(group).unwrap_or(node);
            let body = found.entry(owner).or_insert_with(|| fixed(tree, owner));
            let shapes = geometry.shapes(&at, node, body.kind, notes)?;
            let material = part(&at, "physicsMaterial", &materials, "physicsMaterials")?;
            let filter =
                part(&at, "collisionFilter", &filters[..filters.len() - 1], "collisionFilters")?;
            let template = Template {
                pose: tree.below(owner, node),
                material: material.unwrap_or_else(surface::bare),
                filter: filter.unwrap_or(filters[filters.len() - 1]),
                sensor,
                node,
            };
            body.shapes.extend(shapes.into_iter().map(|s| template.shape(s, owner == node)));
        }
    }
    let mut out = Vec::new();
    for &node in &tree.order {
        let Some(mut def) = found.remove(&node) else { continue };
        if let Some(motion) = nodes.extension.get(&node).and_then(|e| e.get("motion")) {
            set_mass(&motion, tree, node, &mut def, notes)?;
        } else if def.shapes.is_empty() {
            continue;
        }
        out.push(Found { node, def });
    }
    let joints = join(&root, tree, &nodes, &mut out, notes)?;
    Ok((out, joints))
}

/// The joints of the nodes, in the order of the tree. An end that no body holds is held by a body
/// without shapes, which comes after the others.
fn join(
    root: &At<'_>,
    tree: &Tree,
    nodes: &Nodes<'_>,
    bodies: &mut Vec<Found>,
    notes: &mut Vec<String>,
) -> Result<Vec<SceneJoint>, SceneError> {
    let list = match root.dig(&["extensions", EXTENSION]) {
        Some(top) => top.list("physicsJoints")?,
        None => Vec::new(),
    };
    let mut described: Vec<Option<Described>> = list.iter().map(|_| None).collect();
    let mut joints = Vec::new();
    let mut body_of: BTreeMap<usize, usize> = BTreeMap::new();
    for (number, found) in bodies.iter().enumerate() {
        body_of.entry(found.node).or_insert(number);
    }
    for &node in &tree.order {
        let Some(at) = nodes.extension.get(&node).and_then(|e| e.get("joint")) else { continue };
        let at = at.object()?;
        let other = at.need("connectedNode")?.index(tree.nodes.len(), "nodes")?;
        let number = at.need("joint")?.index(list.len(), "physicsJoints")?;
        let collide_connected = at.flag("enableCollision")?;
        let mut told = Vec::new();
        if described[number].is_none() {
            described[number] = Some(joints::describe(&list[number], &mut told)?);
        }
        notes.append(&mut told);
        let Some(description) = &described[number] else { continue };
        let ends = [node, other].map(|end| owner(tree, nodes, &body_of, end));
        let moves = |end: &Option<usize>| {
            end.is_some_and(|body| bodies[body].def.kind == BodyKind::Dynamic)
        };
        let left_out = if ends[0].is_some() && ends[0] == ends[1] {
            Some("both its nodes belong to one body")
        } else if !ends.iter().any(moves) {
            Some("neither of its nodes belongs to a body that forces move")
        } else if description.kinds.is_empty() {
            Some("it holds nothing")
        } else {
            None
        };
        if let Some(why) = left_out {
            notes.push(format!("{}: {}: left out, {why}", tree.name(node), at.place()));
            continue;
        }
        let mut frames = [Pose::IDENTITY; 2];
        let mut numbers = [0; 2];
        for (i, (end, body)) in [node, other].into_iter().zip(ends).enumerate() {
            numbers[i] = body.unwrap_or_else(|| {
                bodies.push(Found { node: end, def: fixed(tree, end) });
                *body_of.entry(end).or_insert(bodies.len() - 1)
            });
            let held = bodies[numbers[i]].node;
            frames[i] = tree.below(held, end);
        }
        for kind in &description.kinds {
            let kind = description.in_frames(*kind, frames[0].rotation, frames[1].rotation);
            let [a, b] = [0, 1].map(|i| (numbers[i], frames[i].position));
            joints.push(SceneJoint { collide_connected, ..SceneJoint::new(a, b, kind) });
        }
    }
    Ok(joints)
}

/// Which of the bodies, given by their nodes, a node belongs to: that of its motion, else the
/// nearest one above it that is there.
fn owner(
    tree: &Tree,
    nodes: &Nodes<'_>,
    body_of: &BTreeMap<usize, usize>,
    node: usize,
) -> Option<usize> {
    let body = |node: usize| body_of.get(&node).copied();
    if let Some(motion) = nodes.motion[node] {
        return body(motion);
    }
    let mut at = Some(node);
    while let Some(node) = at {
        if let Some(found) = body(node) {
            return Some(found);
        }
        at = tree.nodes[node].parent;
    }
    None
}

/// Properties that all shapes of one collider share.
struct Template {
    pose: Pose,
    material: Material,
    filter: Filter,
    sensor: bool,
    node: usize,
}

impl Template {
    fn shape(&self, shape: Shape, own: bool) -> ShapeDef {
        ShapeDef {
            // The body's own node: no rounding.
            pose: if own { Pose::IDENTITY } else { self.pose },
            material: self.material,
            filter: self.filter,
            sensor: self.sensor,
            user_data: self.node as u64,
            ..ShapeDef::new(shape)
        }
    }
}

/// The entry of `list` that the member `key` of a collider names.
fn part<T: Copy>(at: &At<'_>, key: &str, list: &[T], what: &str) -> Result<Option<T>, SceneError> {
    at.get(key).map(|i| Ok(list[i.index(list.len(), what)?])).transpose()
}

/// Reads which nodes take part and how they belong together.
fn survey<'a>(
    root: &At<'a>,
    tree: &Tree,
    notes: &mut Vec<String>,
) -> Result<Nodes<'a>, SceneError> {
    let mut extension = BTreeMap::new();
    let mut outside = 0;
    for (node, at) in root.list("nodes")?.iter().enumerate() {
        let Some(e) = at.dig(&["extensions", EXTENSION]) else { continue };
        if !tree.nodes[node].in_scene {
            outside += 1;
            continue;
        }
        extension.insert(node, e.object()?);
    }
    if outside > 0 {
        notes.push(format!("{outside} nodes with physics are not in the scene and left out"));
    }
    let mut motion = vec![None; tree.nodes.len()];
    let list = root.list("nodes")?;
    for &node in &tree.order {
        let moves = extension.get(&node).is_some_and(|e: &At<'_>| e.get("motion").is_some());
        let marked = list[node].dig(&["extras", STATIC_BODY]).map_or(Ok(false), |m| m.bool())?;
        let own = moves || (marked && tree.nodes[node].in_scene);
        motion[node] =
            if own { Some(node) } else { tree.nodes[node].parent.and_then(|p| motion[p]) };
    }
    let mut trigger_of = BTreeMap::new();
    for (&node, e) in &extension {
        let Some(list) = e.get("trigger").and_then(|t| t.get("nodes")) else { continue };
        for member in list.items()? {
            let m = member.index(tree.nodes.len(), "nodes")?;
            trigger_of.insert(m, node);
        }
    }
    Ok(Nodes { extension, motion, trigger_of })
}

fn fixed(tree: &Tree, node: usize) -> BodyDef {
    let pose = tree.nodes[node].pose;
    BodyDef::fixed().with_position(pose.position).with_rotation(pose.rotation)
}

/// A dynamic or kinematic body without its shapes and mass.
fn moving(motion: &At<'_>, tree: &Tree, node: usize) -> Result<BodyDef, SceneError> {
    motion.clone().object()?;
    let pose = tree.nodes[node].pose;
    let kinematic = motion.flag("isKinematic")?;
    // Velocities are given in the node's own frame.
    let linear = pose.direction(motion.vec3_or("linearVelocity", Vec3::ZERO)?);
    let angular = pose.direction(motion.vec3_or("angularVelocity", Vec3::ZERO)?);
    let def = BodyDef {
        kind: if kinematic { BodyKind::Kinematic } else { BodyKind::Dynamic },
        gravity_scale: motion.get("gravityFactor").map_or(Ok(1.0), |g| g.f32())?,
        ..BodyDef::dynamic()
    };
    Ok(def
        .with_position(pose.position)
        .with_rotation(pose.rotation)
        .with_linear_velocity(linear)
        .with_angular_velocity(angular))
}

/// Sets mass, center and inertia. Values that the file leaves out come from the shapes.
fn set_mass(
    motion: &At<'_>,
    tree: &Tree,
    node: usize,
    def: &mut BodyDef,
    notes: &mut Vec<String>,
) -> Result<(), SceneError> {
    let name = tree.name(node);
    let given = motion.get("mass").map(|m| m.at_least_zero()).transpose()?;
    let diagonal = match motion.get("inertiaDiagonal") {
        Some(at) => {
            at.items()?.iter().try_for_each(|i| i.at_least_zero().map(|_| ()))?;
            Some(at.vec3()?)
        }
        None => None,
    };
    let turn = motion.get("inertiaOrientation").map_or(Ok(Quat::IDENTITY), |q| q.quat())?;
    let center = motion.get("centerOfMass").map(|c| c.vec3()).transpose()?;
    if def.kind != BodyKind::Dynamic {
        return Ok(());
    }
    if given == Some(0.0) {
        notes.push(format!("{name}: mass 0 means infinite, {INFINITE_MASS} kg is used"));
    }
    let mass = given.map(|m| if m > 0.0 { m } else { INFINITE_MASS });
    // The center of mass is a point of the node and moves with its scale.
    let center = center.map(|c| c.mul_each(tree.nodes[node].scale));
    let solid = def.shapes.iter().any(|s| !s.sensor);
    if solid && diagonal.is_none() && center.is_none() {
        def.mass = mass.map_or(MassDef::FromShapes, MassDef::Mass);
        return Ok(());
    }
    let own = mass_of(&def.shapes);
    if own.mass <= 0.0 && (mass.is_none() || diagonal.is_none()) {
        let used =
            "mass 1 kg and the inertia of a ball of 0.5 m radius are used where none is given";
        notes.push(format!("{name}: it has no shape with a volume; {used}"));
    }
    let mass = mass.unwrap_or(if own.mass > 0.0 { own.mass } else { 1.0 });
    let inertia = match diagonal {
        // A component of 0 stands for infinity, which is how the engine says locked too.
        Some(d) => Sym3::rotated_diagonal(turn, d),
        None if own.mass > 0.0 => own.inertia.scaled(mass / own.mass),
        None => Sym3::diagonal(Vec3::splat(0.1 * mass)),
    };
    def.mass = MassDef::Exact { mass, center: center.unwrap_or(own.center), inertia };
    Ok(())
}
