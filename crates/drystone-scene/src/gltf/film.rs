//! The animations of a document, played on its bodies: motion without physics.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use drystone::math::Mat3;
use drystone::{BodyDef, BodyKind, Pose, Quat, Vec3, vec3};

use super::accessor;
use super::json::At;
use super::nodes::{Affine, Tree, split};
use super::{LoadedGltf, read_tree, visual};
use crate::bake::slerp;
use crate::error::SceneError;
use crate::scene::{Scene, SceneBody, Script};

/// Where the bodies of a file are over time, by its animations.
#[derive(Clone, Debug)]
pub struct Film {
    /// The node of each body, ancestors first.
    chains: Vec<Vec<Link>>,
    /// Bodies that are without size at first and from when on they are there [s], in the order of their times;
    /// after those of the scene.
    late: Vec<(f32, SceneBody)>,
    /// From when on each body is gone [s]; at infinity if it stays.
    gone: Vec<f32>,
    seconds: f32,
}

/// A node above a body, or its own.
#[derive(Clone, Debug)]
struct Link {
    local: Affine,
    turn: Quat,
    keys: Option<Keys>,
}

/// What moves a node.
#[derive(Clone, Debug, Default)]
struct Keys {
    translation: Option<Sampler>,
    rotation: Option<Sampler>,
    scale: Option<Sampler>,
    /// Its transform otherwise.
    rest: (Vec3, Quat, Vec3),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Between {
    Step,
    Linear,
    Cubic,
}

#[derive(Clone, Debug)]
struct Sampler {
    times: Vec<f32>,
    /// Three a key for cubic curves: the slope before it, itself, the slope after it.
    values: Vec<[f32; 4]>,
    between: Between,
}

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
                std::collections::btree_map::Entry::Occupied(entry) => entry.into_mut(),
                std::collections::btree_map::Entry::Vacant(entry) => {
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
    // Animations are what is played here, and materials had been read before.
    let unplayed = super::unplayed(root.list("animations")?.len());
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
    late.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (count, gone) = (late.len(), Vec::new());
    let mut film = Film { chains: there, late: Vec::with_capacity(count), gone, seconds };
    for (from, body, chain) in late {
        film.late.push((from, body));
        film.chains.push(chain);
    }
    let vanishes = |chain: &Vec<Link>| chain.last().and_then(Link::vanishes);
    film.gone = film.chains.iter().map(|c| vanishes(c).unwrap_or(f32::INFINITY)).collect();
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
            // Of the document's numbers no two are alike.
            scene
                .bodies
                .push(SceneBody { name: format!("{} (node {node})", tree.name(node)), def });
            node_of_body.push(node);
            held[node] = true;
        }
    }
}

impl Film {
    /// How long it is [s].
    #[must_use]
    pub const fn seconds(&self) -> f32 {
        self.seconds
    }

    /// Where a body is at a time [s], by its number [world].
    #[must_use]
    pub fn pose(&self, body: usize, time: f32) -> Pose {
        let mut world = Affine { linear: Mat3::IDENTITY, translation: Vec3::ZERO };
        let mut turn = Quat::IDENTITY;
        for link in self.chains.get(body).into_iter().flatten() {
            let (local, own) = link.at(time);
            world = world.compose(&local);
            turn = (turn * own).normalized();
        }
        let (rotation, _, _) = split(world.linear, turn);
        Pose::new(world.translation, rotation)
    }

    /// Whether a body that was there is gone at a time [s], by its number.
    pub(crate) fn is_gone(&self, body: usize, time: f32) -> bool {
        self.gone.get(body).is_some_and(|from| *from <= time)
    }

    /// The late body of a number among all that is to be there at a time [s].
    pub(crate) fn late(&self, number: usize, time: f32) -> Option<&SceneBody> {
        let first = self.chains.len() - self.late.len();
        let (from, body) = self.late.get(number.checked_sub(first)?)?;
        (*from <= time).then_some(body)
    }
}

impl Link {
    fn at(&self, time: f32) -> (Affine, Quat) {
        let Some(keys) = &self.keys else { return (self.local, self.turn) };
        let (translation, rotation, scale) = keys.rest;
        let vector = |sampler: &Option<Sampler>, rest: Vec3| {
            sampler.as_ref().map_or(rest, |s| {
                let [x, y, z, _] = s.at(time, false);
                vec3(x, y, z)
            })
        };
        let turn = keys.rotation.as_ref().map_or(rotation, |s| Quat::from(s.at(time, true)));
        let turn = turn.normalized();
        let (r, s) = (turn.to_mat3(), vector(&keys.scale, scale));
        let linear = Mat3 { x: r.x * s.x, y: r.y * s.y, z: r.z * s.z };
        (Affine { linear, translation: vector(&keys.translation, translation) }, turn)
    }

    /// When it gets a size, if it has none at first [s]; never is at infinity.
    fn appears(&self) -> Option<f32> {
        let scale = self.keys.as_ref()?.scale.as_ref()?;
        let size =
            |key: usize| scale.values.get(key).is_some_and(|v| v.iter().any(|x| x.abs() > 0.0));
        if scale.between != Between::Step || size(0) {
            return None;
        }
        let first = (1..scale.times.len()).find(|&key| size(key));
        Some(first.map_or(f32::INFINITY, |key| scale.times[key]))
    }

    /// When it loses its size for good, if it has one before [s].
    fn vanishes(&self) -> Option<f32> {
        let scale = self.keys.as_ref()?.scale.as_ref()?;
        let size =
            |key: &usize| scale.values.get(*key).is_some_and(|v| v.iter().any(|x| x.abs() > 0.0));
        if scale.between != Between::Step {
            return None;
        }
        let last = (0..scale.times.len()).rev().find(size)?;
        scale.times.get(last + 1).copied()
    }
}

impl Sampler {
    fn at(&self, time: f32, turns: bool) -> [f32; 4] {
        let cubic = self.between == Between::Cubic;
        let value = |key: usize, part: usize| {
            let at = if cubic { 3 * key + part } else { key };
            self.values.get(at).copied().unwrap_or_default()
        };
        let next = self.times.partition_point(|t| *t <= time);
        if next == 0 || next == self.times.len() {
            return value(next.saturating_sub(1), 1);
        }
        let (from, to) = (next - 1, next);
        let length = self.times[to] - self.times[from];
        let t = (time - self.times[from]) / length;
        let (a, b) = (value(from, 1), value(to, 1));
        match self.between {
            Between::Step => a,
            Between::Linear if turns => {
                slerp(Quat::from(a).normalized(), Quat::from(b).normalized(), t).to_array()
            }
            Between::Linear => std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t),
            Between::Cubic => {
                let (out, into) = (value(from, 2), value(to, 0));
                let (t2, t3) = (t * t, t * t * t);
                std::array::from_fn(|i| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a[i]
                        + (t3 - 2.0 * t2 + t) * length * out[i]
                        + (3.0 * t2 - 2.0 * t3) * b[i]
                        + (t3 - t2) * length * into[i]
                })
            }
        }
    }
}

fn sampler(
    document: &super::Document,
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

/// A node and what is above it, ancestors first.
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
