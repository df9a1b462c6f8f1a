//! From poses in the world to keys on nodes.

use std::path::Path;

use drystone::{Pose, Quat, Vec3};
use serde_json::{Value, json};

use super::file::{Output, bytes_of, list, push};
use super::motion::Motion;
use crate::error::SceneError;
use crate::gltf::{Document, Tree, read_tree};
use crate::read::json::At;
use crate::transform::{dot, slerp};

/// Keys are left out where interpolation comes this close to them [m].
const NEAR: f32 = 1.0e-4;
/// The same for rotations: difference of unit quaternions, half of 0.01 degrees [rad].
const TURN: f32 = 0.5 * 0.01 * core::f32::consts::PI / 180.0;

/// A node that moves: its transforms below its parent at the times from `first` on.
struct Track {
    node: usize,
    first: usize,
    /// It is gone after these.
    vanishes: bool,
    translations: Vec<Vec3>,
    rotations: Vec<Quat>,
    scale: Vec3,
    /// The file's own scale of the node does not do any more.
    rescaled: bool,
}

/// All keys of one kind, which share a buffer view.
#[derive(Default)]
struct Pool {
    numbers: Vec<f32>,
    accessors: Vec<(usize, usize)>,
}

/// Adds `motion` to a document as its first animation.
pub(super) fn add(
    output: &mut Output,
    document: &Document,
    node_of_body: &[usize],
    motion: &Motion,
) -> Result<(), SceneError> {
    let frames = motion.times.len();
    let fail = |problem: String| {
        Err(SceneError::new(Path::new(""), "", problem, "the motion of this scene"))
    };
    if motion.poses.len() != node_of_body.len() {
        return fail(format!(
            "a motion of {} bodies for {}",
            motion.poses.len(),
            node_of_body.len()
        ));
    }
    if let Some(b) = motion.poses.iter().position(|p| p.len() > frames) {
        return fail(format!("body {b} has {} poses for {frames} times", motion.poses[b].len()));
    }
    if !motion.times.windows(2).all(|w| w[0] < w[1]) {
        return fail("the times do not rise".to_owned());
    }
    let root = At::root(&document.json);
    let tree = read_tree(&root)?;
    show_a_scene(&mut output.json, &tree);
    let mut body_of_node = vec![None; tree.nodes.len()];
    for (body, &node) in node_of_body.iter().enumerate() {
        body_of_node[node] = Some(body);
    }
    let (mut tracks, mut absent) = (Vec::new(), Vec::new());
    for (body, &node) in node_of_body.iter().enumerate() {
        if motion.poses[body].is_empty() {
            if frames > 0 {
                absent.push(node);
            }
            continue;
        }
        let reparent = !parent_is_simple(&tree, node);
        let track = track(document, &tree, &body_of_node, motion, body, node, reparent);
        if track.moves() || track.first > 0 || track.vanishes {
            if reparent && tree.nodes[node].parent.is_some() {
                move_to_scene(&mut output.json, &tree, node);
            }
            tracks.push(track);
        }
    }
    if tracks.is_empty() && absent.is_empty() {
        return Ok(());
    }
    release(&mut output.json, &tracks);
    write_tracks(output, &motion.times, &tracks, &absent);
    Ok(())
}

/// A viewer shows a scene: makes one of all roots if there is none, and says which if that is left
/// open.
fn show_a_scene(json: &mut Value, tree: &Tree) {
    if list(json, "scenes").is_empty() {
        let root = |n: &usize| tree.nodes[*n].parent.is_none();
        let roots: Vec<usize> = tree.order.iter().copied().filter(root).collect();
        push(json, "scenes", json!({"nodes": roots}));
    }
    if json.get("scene").is_none() {
        json["scene"] = json!(0);
    }
}

/// True if the parent only moves, turns and scales evenly: then the node's local transform is again
/// translation, rotation and its own scale.
fn parent_is_simple(tree: &Tree, node: usize) -> bool {
    let Some(parent) = tree.nodes[node].parent else { return true };
    let s = tree.nodes[parent].scale;
    let even = (s.x - s.y).abs().max((s.x - s.z).abs()) <= 1.0e-4 * s.x.abs();
    even && s.x > 1.0e-6 && !tree.nodes[parent].sheared
}

fn track(
    document: &Document,
    tree: &Tree,
    body_of_node: &[Option<usize>],
    motion: &Motion,
    body: usize,
    node: usize,
    reparent: bool,
) -> Track {
    let poses = &motion.poses[body];
    let first = motion.first(body);
    let vanishes = first + poses.len() < motion.times.len();
    let parent = if reparent { None } else { tree.nodes[node].parent };
    // The body whose motion carries the parent, if there is one.
    let mut carrier = parent;
    while let Some(c) = carrier
        && body_of_node[c].is_none()
    {
        carrier = tree.nodes[c].parent;
    }
    let parent_scale = parent.map_or(1.0, |p| tree.nodes[p].scale.x);
    let parent_pose = |frame: usize| -> Pose {
        let Some(p) = parent else { return Pose::IDENTITY };
        let rest = tree.nodes[p].pose;
        let Some((c, b)) = carrier.and_then(|c| Some((c, body_of_node[c]?))) else { return rest };
        let before = motion.first(b);
        let Some(now) = motion.poses[b].get(frame.saturating_sub(before)) else { return rest };
        now.compose(&tree.nodes[c].pose.relative(&rest))
    };
    let mut translations = Vec::with_capacity(poses.len());
    let mut rotations: Vec<Quat> = Vec::with_capacity(poses.len());
    for (k, pose) in poses.iter().enumerate() {
        let local = parent_pose(first + k).relative(pose);
        let mut q = local.rotation.normalized();
        // Neighbors in the same half of the sphere: some viewers interpolate as they stand.
        if rotations.last().is_some_and(|p| dot(*p, q) < 0.0) {
            q = Quat::new(-q.x, -q.y, -q.z, -q.w);
        }
        translations.push(local.position * (1.0 / parent_scale));
        rotations.push(q);
    }
    let scale = if parent.is_some() {
        tree.nodes[node].scale * (1.0 / parent_scale)
    } else {
        tree.nodes[node].scale
    };
    let at = At::root(&document.json).nth("nodes", node);
    let own =
        at.filter(|a| a.get("matrix").is_none()).and_then(|a| a.vec3_or("scale", Vec3::ONE).ok());
    let rescaled = own.is_none_or(|o| (o - scale).length() > 1.0e-5 * scale.length());
    Track { node, first, vanishes, translations, rotations, scale, rescaled }
}

impl Track {
    fn moves(&self) -> bool {
        let (t, q) = (self.translations[0], self.rotations[0]);
        self.translations.iter().any(|p| (*p - t).length() > NEAR)
            || self.rotations.iter().any(|r| apart(*r, q) > TURN)
    }
}

/// Half the angle between two rotations, for small ones [rad].
fn apart(a: Quat, b: Quat) -> f32 {
    let s = if dot(a, b) < 0.0 { -1.0 } else { 1.0 };
    let d = [a.x - s * b.x, a.y - s * b.y, a.z - s * b.z, a.w - s * b.w];
    d.iter().map(|v| v * v).sum::<f32>().sqrt()
}

/// The numbers of the keys to keep: the ends, and where `error(from, to, k)` of key `k` between two
/// kept ones exceeds 1, the worst one, again and again.
fn thin(count: usize, error: impl Fn(usize, usize, usize) -> f32) -> Vec<usize> {
    if count < 3 {
        return (0..count).collect();
    }
    let mut keep = vec![false; count];
    keep[0] = true;
    keep[count - 1] = true;
    // Short spans first: bouncing and rolling bodies need many keys, and a long span costs its
    // length at every level.
    const SPAN: usize = 256;
    let mut spans: Vec<(usize, usize)> = Vec::new();
    let mut from = 0;
    while from < count - 1 {
        let to = (from + SPAN).min(count - 1);
        keep[to] = true;
        spans.push((from, to));
        from = to;
    }
    while let Some((from, to)) = spans.pop() {
        let (mut worst, mut at) = (1.0, from);
        for k in from + 1..to {
            let e = error(from, to, k);
            if e > worst {
                (worst, at) = (e, k);
            }
        }
        if at > from {
            keep[at] = true;
            spans.extend([(from, at), (at, to)]);
        }
    }
    (0..count).filter(|&k| keep[k]).collect()
}

/// Takes the animated nodes out of animations that are there already.
fn release(json: &mut Value, tracks: &[Track]) {
    if json.get("animations").is_none() {
        return;
    }
    let ours = |channel: &Value| {
        let node = channel.pointer("/target/node").and_then(Value::as_u64);
        tracks.iter().any(|t| Some(t.node as u64) == node)
    };
    let animations = list(json, "animations");
    for animation in animations.iter_mut() {
        list(animation, "channels").retain(|c| !ours(c));
    }
    animations.retain(|a| a["channels"].as_array().is_some_and(|c| !c.is_empty()));
}

/// Makes a node a root of the shown scene.
fn move_to_scene(json: &mut Value, tree: &Tree, node: usize) {
    if let Some(parent) = tree.nodes[node].parent {
        let siblings = list(&mut list(json, "nodes")[parent], "children");
        siblings.retain(|c| c.as_u64() != Some(node as u64));
        if siblings.is_empty()
            && let Some(object) = list(json, "nodes")[parent].as_object_mut()
        {
            object.remove("children");
        }
    }
    let scene = json.get("scene").and_then(Value::as_u64).unwrap_or(0);
    let scenes = list(json, "scenes");
    if let Some(scene) = usize::try_from(scene).ok().and_then(|s| scenes.get_mut(s)) {
        push(scene, "nodes", json!(node));
    }
}

/// Nodes that are `absent` have no size at any time.
fn write_tracks(output: &mut Output, all_times: &[f32], tracks: &[Track], absent: &[usize]) {
    let mut key_times = Pool::default();
    let mut vectors = Pool::default();
    let mut turns = Pool::default();
    // Channel: node, path, interpolation, number in `key_times`, number in its own pool.
    let mut channels: Vec<(usize, &str, &str, usize, usize)> = Vec::new();
    for track in tracks {
        let times = &all_times[track.first..];
        let part =
            |from: usize, to: usize, k: usize| (times[k] - times[from]) / (times[to] - times[from]);
        let (t, q) = (&track.translations, &track.rotations);
        let moved = thin(t.len(), |from, to, k| {
            let guess = t[from] + (t[to] - t[from]) * part(from, to, k);
            (guess - t[k]).length() / NEAR
        });
        let turned = thin(q.len(), |from, to, k| {
            apart(slerp(q[from], q[to], part(from, to, k)), q[k]) / TURN
        });
        if t.iter().any(|p| (*p - t[0]).length() > NEAR) {
            let input = key_times.add(moved.iter().map(|&k| times[k]), 1);
            let keys = vectors.add(moved.iter().flat_map(|&k| t[k].to_array()), 3);
            channels.push((track.node, "translation", "LINEAR", input, keys));
        }
        if q.iter().any(|r| apart(*r, q[0]) > TURN) {
            let input = key_times.add(turned.iter().map(|&k| times[k]), 1);
            let keys = turns.add(turned.iter().flat_map(|&k| q[k].to_array()), 4);
            channels.push((track.node, "rotation", "LINEAR", input, keys));
        }
        if track.first > 0 || track.vanishes {
            // Not there yet, or not any more: without size.
            let mut shown = vec![(times[0], track.scale)];
            if track.first > 0 {
                shown.insert(0, (all_times[0], Vec3::ZERO));
            }
            if track.vanishes {
                shown.push((times[t.len()], Vec3::ZERO));
            }
            let input = key_times.add(shown.iter().map(|(time, _)| *time), 1);
            let keys = vectors.add(shown.iter().flat_map(|(_, s)| s.to_array()), 3);
            channels.push((track.node, "scale", "STEP", input, keys));
        }
        let node = &mut list(&mut output.json, "nodes")[track.node];
        if let Some(object) = node.as_object_mut() {
            object.remove("matrix");
            object.insert("translation".to_owned(), json!(t[0].to_array()));
            object.insert("rotation".to_owned(), json!(q[0].to_array()));
            if track.rescaled {
                object.insert("scale".to_owned(), json!(track.scale.to_array()));
            }
        }
    }
    for node in absent {
        let input = key_times.add([all_times[0]], 1);
        let keys = vectors.add([0.0; 3], 3);
        channels.push((*node, "scale", "STEP", input, keys));
    }
    let inputs = key_times.write(output, "SCALAR", 1);
    let vectors = vectors.write(output, "VEC3", 3);
    let turns = turns.write(output, "VEC4", 4);
    let samplers: Vec<Value> = channels
        .iter()
        .map(|(_, path, interpolation, input, keys)| {
            let keys = if *path == "rotation" { turns[*keys] } else { vectors[*keys] };
            json!({"input": inputs[*input], "output": keys, "interpolation": interpolation})
        })
        .collect();
    let channels: Vec<Value> = channels
        .iter()
        .enumerate()
        .map(|(i, (node, path, ..))| json!({"sampler": i, "target": {"node": node, "path": path}}))
        .collect();
    if channels.is_empty() {
        return;
    }
    let animation = json!({"name": "simulation", "samplers": samplers, "channels": channels});
    list(&mut output.json, "animations").insert(0, animation);
}

impl Pool {
    /// Adds the keys of one sampler; gives their number in the pool.
    fn add(&mut self, numbers: impl IntoIterator<Item = f32>, width: usize) -> usize {
        let begin = self.numbers.len();
        self.numbers.extend(numbers);
        let count = (self.numbers.len() - begin) / width;
        self.accessors.push((begin, count));
        self.accessors.len() - 1
    }

    /// Writes the view and the accessors; gives the accessors' numbers in the document.
    fn write(self, output: &mut Output, kind: &str, width: usize) -> Vec<usize> {
        if self.numbers.is_empty() {
            return Vec::new();
        }
        let view = output.view(&bytes_of(&self.numbers), None);
        let mut made = Vec::with_capacity(self.accessors.len());
        for (begin, count) in self.accessors {
            let mut accessor = json!({
                "bufferView": view, "byteOffset": begin * 4,
                "componentType": 5126, "count": count, "type": kind,
            });
            if width == 1 {
                // Times rise.
                accessor["min"] = json!([self.numbers[begin]]);
                accessor["max"] = json!([self.numbers[begin + count - 1]]);
            }
            made.push(output.accessor(accessor));
        }
        made
    }
}
