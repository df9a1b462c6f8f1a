//! A run that is saved, and goes on.

use core::fmt::Write as _;
use std::sync::Arc;

use drystone::World;
use drystone::snapshot::SnapshotError;
use serde::{Deserialize, Serialize};

use super::running::{BuildError, Running};
use crate::scene::{Scene, Script};

/// A [`Running`] scene without the data of the scene itself: for files, in any format of serde.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SavedRun {
    scene: u32,
    world: Vec<u8>,
    /// With a world, frames, looks and a script that are none.
    run: Running,
}

/// Why a run does not go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// The scene cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The run was saved of another scene.
    #[error("it was saved of another scene")]
    OtherScene,
    /// Its world is none.
    #[error(transparent)]
    World(#[from] SnapshotError),
    /// Its lists do not fit each other.
    #[error("the run is not whole: {0}")]
    Unsound(&'static str),
}

/// A checksum of the bytes that are written into it.
struct Checksum(crc32fast::Hasher);

impl core::fmt::Write for Checksum {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

impl Scene {
    /// A checksum over the world at the start, the names and the script. It identifies the scene.
    fn fingerprint(&self, start: &Running) -> u32 {
        let mut sum = Checksum(crc32fast::Hasher::new());
        sum.0.update(&start.world.snapshot());
        // A checksum takes whatever it is given.
        let _ = write!(sum, "{:?}{:?}{:?}", start.names, self.frames, self.script);
        sum.0.finalize()
    }

    /// A run of this scene as it is now: [`Self::resume`] goes on with it, with the same bits.
    ///
    /// # Errors
    /// The scene cannot be built, so that `run` is not of it.
    pub fn save(&self, run: &Running) -> Result<SavedRun, BuildError> {
        let bare = Running {
            world: World::default(),
            bodies: run.bodies.clone(),
            names: run.names.clone(),
            joints: run.joints.clone(),
            articulations: run.articulations.clone(),
            couplings: run.couplings.clone(),
            strands: run.strands.clone(),
            frames: Vec::new(),
            visuals: Arc::default(),
            brought: run.brought.clone(),
            origins: run.origins.clone(),
            pieces: run.pieces.clone(),
            script: Script::None,
            steps: run.steps,
        };
        let scene = self.fingerprint(&self.build()?);
        Ok(SavedRun { scene, world: run.world.snapshot(), run: bare })
    }

    /// Goes on with a run that [`Self::save`] saved of this scene.
    ///
    /// # Errors
    /// The run is of another scene, or is none.
    pub fn resume(&self, saved: &SavedRun) -> Result<Running, ResumeError> {
        let start = self.build()?;
        if self.fingerprint(&start) != saved.scene {
            return Err(ResumeError::OtherScene);
        }
        let run = &saved.run;
        let names = run.names.len();
        if names != run.bodies.len() {
            return Err(ResumeError::Unsound("bodies have not one name each"));
        }
        if run.brought.len() < start.brought.len() || run.brought.len() > names {
            return Err(ResumeError::Unsound("bodies of the scene are not there"));
        }
        if run.origins.values().any(|origin| *origin >= names) {
            return Err(ResumeError::Unsound("a piece is of no body"));
        }
        if run.steps >= 1 << 53 {
            return Err(ResumeError::Unsound("it took more steps than can be"));
        }
        Ok(Running {
            world: World::restore(&saved.world)?,
            frames: start.frames,
            visuals: start.visuals,
            script: start.script,
            ..run.clone()
        })
    }
}
