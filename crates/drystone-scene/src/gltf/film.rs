//! The animations of a document as a film: motion without physics.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use drystone::{BodyDef, BodyKind, Quat, Vec3};

use super::accessor;
use super::document::Document;
use super::loaded::{LoadedGltf, unplayed};
use super::nodes::{Tree, read as read_tree};
use super::visual;
use crate::error::SceneError;
use crate::read::json::At;
use crate::scene::{Between, Film, Keys, Link, Sampler, Scene, SceneBody, Script};

/// The scene that plays the animations of a file: no body obeys physics.
///
/// # Errors
/// A line that names the place in the file, what is wrong and what is allowed.
pub fn film(loaded: LoadedGltf) -> Result<Scene, SceneError> {
    let file = std::path::PathBuf::from(&loaded.scene.name);
    play(loaded).map_err(|e| e.in_file(&file))
}

fn play(loaded: LoadedGltf) -> Result<Scene, SceneError> {
    let LoadedGltf { mut scene, document, mut node_of_body } = loaded;
    let root = At::root(&document.json);
    let tree = read_tree(&root)?;
    let list = root.list("nodes")?;
    let mut keys: BTreeMap<usize, Keys> = BTreeMap::new();
    let mut seconds = 0.0_f32;
    for animation in root.list("animations")? {
        for channel in animation.list("channels")? {
            let target = channel.need("target")?;
            let Some(node) = target.get("node") else { continue };
            let node = node.index(list.len(), "nodes")?;
            let path = target.need("path")?;
            let (kind, width) = match path.text()? {
                "translation" | "scale" => ("VEC3", 3),
                "rotation" => ("VEC4", 4),
                _ => continue,
            };
            let at = animation.entry("samplers", &channel.need("sampler")?)?;
            let sampler = sampler(&document, &at, kind, width)?;
            seconds = seconds.max(sampler.times.last().copied().unwrap_or(0.0));
            let keys = match keys.entry(node) {
                Entry::Occupied(entry) => entry.into_mut(),
                Entry::Vacant(entry) => {
                    let rest = rest(&list[node])?;
                    entry.insert(Keys { rest, ..Keys::default() })
                }
            };
            // The first animation that moves a node wins.
            let slot = match path.text()? {
                "translation" => &mut keys.translation,
                "rotation" => &mut keys.rotation,
                _ => &mut keys.scale,
            };
            slot.get_or_insert(sampler);
        }
    }
    if seconds <= 0.0 {
        return Err(root.error("it has no animation of nodes", "a film: keys for nodes over time"));
    }
    add_moving_meshes(&list, &tree, &keys, &mut scene, &mut node_of_body);
    let (visuals, notes) = visual::read(&document, &node_of_body);
    scene.visuals = Arc::new(visuals);
    // This plays the animations, and materials had been read before.
    let unplayed = unplayed(root.list("animations")?.len());
    scene.notes.retain(|note| *note != unplayed);
    let mut known: BTreeSet<String> = scene.notes.iter().cloned().collect();
    scene.notes.extend(notes.into_iter().filter(|note| known.insert(note.clone())));
    let mut there = Vec::new();
    let mut late = Vec::new();
    for (mut body, node) in std::mem::take(&mut scene.bodies).into_iter().zip(node_of_body) {
        let chain = chain(&tree, &keys, node);
        let moves = chain.iter().any(|link| link.keys.is_some());
        body.def.kind = if moves { BodyKind::Kinematic } else { BodyKind::Static };
        body.def.linear_velocity = Vec3::ZERO;
        body.def.angular_velocity = Vec3::ZERO;
        match chain.last().and_then(Link::appears) {
            Some(from) => late.push((from, body, chain)),
            None => {
                scene.bodies.push(body);
                there.push(chain);
            }
        }
    }
    let film = Film::new(there, late, seconds);
    for number in 0..scene.bodies.len() {
        let pose = film.pose(number, 0.0);
        let def = &mut scene.bodies[number].def;
        (def.position, def.rotation) = (pose.position, pose.rotation);
    }
    scene.joints.clear();
    // They hang on bodies by numbers, which have changed.
    scene.frames.clear();
    scene.seconds = seconds;
    scene.summary = format!("a film of {seconds} s");
    scene.script = Script::Film(Arc::new(film));
    Ok(scene)
}

/// Adds bodies without shapes for nodes that move and show something, but are part of no body.
fn add_moving_meshes(
    list: &[At<'_>],
    tree: &Tree,
    keys: &BTreeMap<usize, Keys>,
    scene: &mut Scene,
    node_of_body: &mut Vec<usize>,
) {
    let mut held = vec![false; tree.nodes.len()];
    let mut moved = vec![false; tree.nodes.len()];
    for &node in &*node_of_body {
        held[node] = true;
    }
    for &node in &tree.order {
        if let Some(parent) = tree.nodes[node].parent {
            held[node] |= held[parent];
            moved[node] |= moved[parent];
        }
        moved[node] |= keys.contains_key(&node);
        let shows = tree.nodes[node].in_scene && list[node].get("mesh").is_some();
        if shows && moved[node] && !held[node] {
            let pose = tree.nodes[node].pose;
            let def = BodyDef { user_data: node as u64, ..BodyDef::kinematic() };
            let def = def.with_position(pose.position).with_rotation(pose.rotation);
            // No two nodes have the same number.
            scene
                .bodies
                .push(SceneBody { name: format!("{} (node {node})", tree.name(node)), def });
            node_of_body.push(node);
            held[node] = true;
        }
    }
}

fn sampler(
    document: &Document,
    at: &At<'_>,
    kind: &str,
    width: usize,
) -> Result<Sampler, SceneError> {
    let between = match at.get("interpolation") {
        None => Between::Linear,
        Some(way) => match way.text()? {
            "LINEAR" => Between::Linear,
            "STEP" => Between::Step,
            "CUBICSPLINE" => Between::Cubic,
            _ => return Err(way.wrong("\"LINEAR\", \"STEP\" or \"CUBICSPLINE\"")),
        },
    };
    let (input, output) = (at.need("input")?, at.need("output")?);
    let times = accessor::numbers(document, &input, "SCALAR", 1)?;
    if !times.windows(2).all(|w| w[0] < w[1]) {
        return Err(input.error("its times do not rise", "times that rise"));
    }
    let numbers = accessor::numbers(document, &output, kind, width)?;
    let values: Vec<[f32; 4]> = numbers
        .chunks_exact(width)
        .map(|chunk| std::array::from_fn(|i| chunk.get(i).copied().unwrap_or(0.0)))
        .collect();
    let wanted = times.len() * if between == Between::Cubic { 3 } else { 1 };
    if values.len() != wanted || times.is_empty() {
        let problem = format!("has {} values for {} times", values.len(), times.len());
        return Err(output.error(problem, "a value for each time, three for cubic curves"));
    }
    Ok(Sampler { times, values, between })
}

/// The transform of a node that is animated.
fn rest(at: &At<'_>) -> Result<(Vec3, Quat, Vec3), SceneError> {
    if let Some(matrix) = at.get("matrix") {
        return Err(matrix.error("moves by keys", "translation, rotation and scale in its place"));
    }
    let rotation = at.get("rotation").map_or(Ok(Quat::IDENTITY), |at| at.quat())?;
    Ok((at.vec3_or("translation", Vec3::ZERO)?, rotation, at.vec3_or("scale", Vec3::ONE)?))
}

/// A node and the nodes above it, ancestors first.
fn chain(tree: &Tree, keys: &BTreeMap<usize, Keys>, node: usize) -> Vec<Link> {
    let mut chain = Vec::new();
    let mut at = Some(node);
    while let Some(number) = at {
        let node = &tree.nodes[number];
        let keys = keys.get(&number).cloned();
        chain.push(Link { local: node.local, turn: node.turn, keys });
        at = node.parent;
    }
    chain.reverse();
    chain
}
