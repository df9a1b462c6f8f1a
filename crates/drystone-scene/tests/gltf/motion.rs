//! Motion that is written, and read by other means.

use std::fs;
use std::path::Path;

use drystone::{BodyDef, BodyKind, Pose, Quat, Vec3, vec3};
use drystone_scene::Scene;
use drystone_scene::bake::Motion;
use serde_json::Value;

/// The world pose of each node of a written file at a time, by the rules of viewers.
pub(crate) fn sampled(path: &Path, time: f32) -> (Vec<Pose>, ::gltf::Document) {
    // The other reader also validates the file.
    let (document, buffers) = {
        let bytes = fs::read(path).unwrap();
        let file = ::gltf::Gltf::from_slice(&bytes).unwrap_or_else(|e| panic!("{e}"));
        let blob = file.blob.clone().unwrap_or_else(|| {
            let json: Value = serde_json::from_slice(&bytes).unwrap();
            let uri = json["buffers"][0]["uri"].as_str().unwrap_or(",").to_owned();
            use base64::Engine as _;
            base64::engine::general_purpose::STANDARD
                .decode(uri.split(',').nth(1).unwrap())
                .unwrap()
        });
        (file.document, blob)
    };
    let mut local: Vec<Pose> = document
        .nodes()
        .map(|n| {
            let (t, r, _) = n.transform().decomposed();
            Pose::new(t, r)
        })
        .collect();
    if let Some(animation) = document.animations().next() {
        for channel in animation.channels() {
            let reader = channel.reader(|_| Some(&buffers));
            let times: Vec<f32> = reader.read_inputs().unwrap().collect();
            let after = times.iter().position(|t| *t >= time).unwrap_or(times.len() - 1);
            let before = if times[after] > time { after.saturating_sub(1) } else { after };
            let span = times[after] - times[before];
            let part = if span > 0.0 { (time - times[before]) / span } else { 0.0 };
            let pose = &mut local[channel.target().node().index()];
            use ::gltf::animation::util::ReadOutputs;
            match reader.read_outputs().unwrap() {
                ReadOutputs::Translations(keys) => {
                    let keys: Vec<Vec3> = keys.map(Vec3::from).collect();
                    pose.position = keys[before] + (keys[after] - keys[before]) * part;
                }
                ReadOutputs::Rotations(keys) => {
                    let keys: Vec<Quat> = keys.into_f32().map(Quat::from).collect();
                    let turn = keys[after] * keys[before].conjugate();
                    pose.rotation = keys[before].turned_by(turn.to_rotation_vector() * part);
                }
                _ => {}
            }
        }
    }
    let mut world = local.clone();
    let mut stack: Vec<_> = document.default_scene().unwrap().nodes().collect();
    while let Some(node) = stack.pop() {
        for child in node.children() {
            let scale = node.transform().decomposed().2[0];
            let mut inner = local[child.index()];
            inner.position *= scale;
            world[child.index()] = world[node.index()].compose(&inner);
            stack.push(child);
        }
    }
    (world, document)
}

pub(crate) fn assert_poses(path: &Path, nodes: &[usize], motion: &Motion) {
    for (f, &time) in motion.times.iter().enumerate() {
        let (world, _) = sampled(path, time);
        for (b, &node) in nodes.iter().enumerate() {
            let (is, should) = (world[node], motion.poses[b][f]);
            assert!(
                (is.position - should.position).length() < 3e-4,
                "body {b} at {time}: {is:?} {should:?}"
            );
            assert!(
                (is.rotation * should.rotation.conjugate()).angle() < 5e-4,
                "body {b} at {time}"
            );
        }
    }
}

/// Bodies that fly and spin, each in its own way, from where they are.
pub(crate) fn flight(scene: &Scene, frames: u16) -> Motion {
    let times: Vec<f32> = (0..frames).map(|f| f32::from(f) / 60.0).collect();
    let pose = |b: usize, def: &BodyDef, t: f32| {
        if def.kind == BodyKind::Static {
            return Pose::new(def.position, def.rotation);
        }
        let k = f32::from(u8::try_from(b).unwrap()) + 1.0;
        let position = def.position + vec3(k * t, 3.0 * t - 4.9 * t * t, 0.2 * t);
        Pose::new(
            position,
            Quat::from_rotation_vector(vec3(k * t, 2.0 * t, 5.0 * t * t)) * def.rotation,
        )
    };
    let poses = scene.bodies.iter().enumerate();
    let poses = poses.map(|(b, s)| times.iter().map(|&t| pose(b, &s.def, t)).collect()).collect();
    Motion { times, poses, ..Motion::default() }
}
