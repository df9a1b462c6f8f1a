//! `simulate --snapshot` and `--resume`: a run as a file.

use std::path::{Path, PathBuf};

use drystone_scene::{BuildError, ResumeError, Running, SavedRun, Scene};
use serde::{Deserialize, Serialize};

use super::chunk;
use crate::cli::{Settings, Source, is_rate};
use crate::load::{Loaded, build, load_with, refused};
use crate::output::{Failure, Output, probe, read};

/// First bytes of such a file.
const KIND: [u8; 8] = *b"drystrun";

/// The command line that gives a scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Recipe {
    /// The scene.
    pub(crate) source: Source,
    /// The settings of its world.
    pub(crate) settings: Settings,
}

impl Recipe {
    /// The scene with its settings.
    pub(crate) fn load(&self) -> Result<Loaded, Failure> {
        load_with(&self.source, &self.settings)
    }
}

/// A run, saved.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Snapshot {
    /// How its scene is made.
    pub(crate) recipe: Recipe,
    /// Steps a second.
    pub(crate) hz: f32,
    /// Time simulated [s].
    pub(crate) time: f64,
    run: SavedRun,
}

impl Snapshot {
    /// The snapshot of a run of `scene` as it is now.
    pub(crate) fn of(
        recipe: &Recipe,
        scene: &Scene,
        running: &Running,
        hz: f32,
        time: f64,
    ) -> Result<Self, BuildError> {
        Ok(Self { recipe: recipe.clone(), hz, time, run: scene.save(running)? })
    }

    /// From a file.
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = read(path, KIND)?;
        let wrong = |e: &str| Failure::failed(format_args!("{}: {e}", path.display()));
        let mut rest =
            chunk::after_title(&bytes, KIND, "snapshot that `simulate --snapshot` wrote")
                .map_err(|e| wrong(&e))?;
        let snapshot: Option<Self> = chunk::take(&mut rest).filter(|_| rest.is_empty());
        let snapshot = snapshot.ok_or_else(|| wrong("the snapshot was cut off or changed"))?;
        if is_rate(snapshot.hz) && snapshot.time >= 0.0 && snapshot.time.is_finite() {
            return Ok(snapshot);
        }
        Err(wrong("its time is out of range"))
    }

    /// The run, of `scene`, which the user calls `source`; `file` is the file it was read from.
    fn resume(&self, scene: &Scene, source: &str, file: &Path) -> Result<Running, Failure> {
        scene.resume(&self.run).map_err(|e| match e {
            ResumeError::OtherScene => Failure::failed(format_args!(
                "{}: the snapshot is of another scene than {source} is now",
                file.display()
            )),
            ResumeError::Build(e) => refused(source, &e),
            e => Failure::failed(format_args!("{}: {e}", file.display())),
        })
    }
}

/// A run begins: a scene's own, or one that was saved.
pub(crate) fn begin(
    recipe: &Recipe,
    scene: &Scene,
    saved: Option<(&Snapshot, &Path)>,
) -> Result<Running, Failure> {
    match saved {
        Some((snapshot, file)) => snapshot.resume(scene, &recipe.source.scene, file),
        None => build(scene, &recipe.source.scene),
    }
}

/// A snapshot that is to be written at the end.
#[derive(Debug)]
pub(crate) struct SnapshotFile(PathBuf);

impl SnapshotFile {
    /// The file can be written; its old content stays until then.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        probe(path)?;
        Ok(Self(path.to_owned()))
    }

    /// Writes it; returns the path.
    pub(crate) fn finish(self, snapshot: &Snapshot) -> Result<PathBuf, Failure> {
        let wrong = |e| Failure::failed(format_args!("{}: {e}", self.0.display()));
        let chunk = chunk::put(snapshot).map_err(wrong)?;
        let mut file = Output::create(&self.0)?;
        file.write(&chunk::title(KIND))?;
        file.write(&chunk)?;
        file.finish()
    }
}
