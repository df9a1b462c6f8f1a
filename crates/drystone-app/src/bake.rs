//! The motion of a run, kept for the baked file.

use std::path::{Path, PathBuf};

use drystone::{BodyId, Pose, World};
use drystone_scene::{Motion, Scene};

use crate::output::{Failure, probe};

/// Poses of all bodies over the run. 28 bytes a body and step.
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

    /// Adds the poses at `time` [s].
    pub(crate) fn add(&mut self, time: f64, world: &World, bodies: &[BodyId]) {
        self.motion.times.push(seconds(time));
        let pose = |&id: &BodyId| {
            world.body(id).map_or(Pose::IDENTITY, |b| Pose::new(b.position(), b.rotation()))
        };
        self.motion.poses.push(bodies.iter().map(pose).collect());
    }

    /// Writes the file; returns its path.
    pub(crate) fn finish(self, scene: &Scene) -> Result<PathBuf, Failure> {
        drystone_scene::bake(scene, &self.motion, &self.path)
            .map_err(|e| Failure::failed(format_args!("{}: {e}", self.path.display())))?;
        Ok(self.path)
    }
}

/// The file keeps times as f32.
#[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
const fn seconds(time: f64) -> f32 {
    time as f32
}
