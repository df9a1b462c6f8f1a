//! The motion of a run, kept for the baked file.

use std::path::{Path, PathBuf};

use drystone::{BodyId, BodyKind, World};
use drystone_scene::bake::{self, Motion};

use crate::load::{Loaded, dropped};
use crate::output::{Failure, probe};

/// Poses of the moving bodies over the run; 28 bytes a body and step.
#[derive(Debug)]
pub(crate) struct Bake {
    path: PathBuf,
    motion: Motion,
}

impl Bake {
    /// Nothing kept yet; the file can be written.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        probe(path)?;
        Ok(Self { path: path.to_owned(), motion: Motion::default() })
    }

    /// Adds the poses at `time` [s]. Static bodies have none; a body that joins late has fewer.
    pub(crate) fn add(&mut self, time: f64, world: &World, bodies: &[BodyId]) {
        let Motion { times, poses } = &mut self.motion;
        let time = seconds(time);
        if times.last().is_some_and(|&last| last >= time) {
            // Steps shorter than what f32 tells apart.
            return;
        }
        times.push(time);
        poses.resize_with(poses.len().max(bodies.len()), Vec::new);
        for (&id, poses) in bodies.iter().zip(poses) {
            if let Some(body) = world.body(id).filter(|b| b.kind() != BodyKind::Static) {
                poses.push(body.pose());
            }
        }
    }

    /// Writes the file; returns its path.
    pub(crate) fn finish(mut self, loaded: &Loaded) -> Result<PathBuf, Failure> {
        // Those that the script has not dropped yet.
        let scene = loaded.scene();
        let all = scene.bodies.len() + dropped(scene).len();
        self.motion.poses.resize_with(all, Vec::new);
        match loaded {
            Loaded::BuiltIn(scene) | Loaded::Read(scene) => {
                bake::write_scene(&self.path, scene, &self.motion)
            }
            Loaded::Gltf(loaded) => bake::write(&self.path, loaded, &self.motion),
        }
        .map_err(Failure::failed)?;
        Ok(self.path)
    }
}

/// The file keeps times as f32.
#[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
const fn seconds(time: f64) -> f32 {
    time as f32
}
