//! The state of a world: the scene that runs, and names of bodies that were added by hand.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use drystone::BodyId;
use drystone_scene::{BuildError, Running, SavedRun, Scene, own};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

use crate::errors::{no_snapshot, unreadable};

/// The state of a world.
#[derive(Clone)]
pub(crate) struct State {
    pub(crate) scene: Arc<Scene>,
    /// The file or the built-in name of the scene, for messages.
    pub(crate) source: String,
    pub(crate) run: Running,
    /// Bodies that were added by hand with a name.
    pub(crate) names: BTreeMap<String, BodyId>,
}

/// The state as bytes. The scene is a text, because it is the only form that files of it have.
#[derive(Serialize, Deserialize)]
struct Stored {
    scene: String,
    source: String,
    run: SavedRun,
    names: BTreeMap<String, BodyId>,
}

/// The first bytes of a stored state.
const KIND: &[u8; 8] = b"drypysn1";

impl State {
    pub(crate) fn new(scene: Arc<Scene>, source: &str) -> Result<Self, BuildError> {
        let run = scene.build()?;
        Ok(Self::of(scene, source, run))
    }

    pub(crate) fn of(scene: Arc<Scene>, source: &str, run: Running) -> Self {
        Self { scene, source: source.to_owned(), run, names: BTreeMap::new() }
    }

    /// Length of a step where none is given [s].
    pub(crate) fn dt(&self) -> f32 {
        1.0 / self.scene.hz
    }

    /// The body of this name that is there.
    pub(crate) fn named(&self, name: &str) -> Option<BodyId> {
        let brought = || {
            let place = self.run.names.iter().position(|known| known == name)?;
            self.run.bodies.get(place).copied()
        };
        let id = self.names.get(name).copied().or_else(brought)?;
        self.run.world.body(id).map(|_| id)
    }

    /// The name of a body; empty where it has none.
    pub(crate) fn name_of(&self, id: BodyId) -> &str {
        let by_hand = self.names.iter().find(|(_, known)| **known == id);
        let brought = || {
            let place = self.run.bodies.iter().position(|known| *known == id)?;
            self.run.names.get(place)
        };
        by_hand.map(|(name, _)| name).or_else(brought).map_or("", String::as_str)
    }

    /// The state as bytes.
    pub(crate) fn to_bytes(&self) -> PyResult<Vec<u8>> {
        let scene = own::to_text(&self.scene).map_err(|e| unreadable(&e))?;
        let run = self.scene.save(&self.run).map_err(|e| no_snapshot(&e.to_string()))?;
        let (source, names) = (self.source.clone(), self.names.clone());
        let stored = Stored { scene, source, run, names };
        let body = postcard::to_stdvec(&stored).map_err(|e| no_snapshot(&e.to_string()))?;
        Ok([KIND.as_slice(), &body].concat())
    }

    /// The state of [`Self::to_bytes`]; the bytes need not be trusted.
    pub(crate) fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        let body = bytes.strip_prefix(KIND);
        let body = body.ok_or_else(|| no_snapshot("these bytes are no snapshot"))?;
        let stored: Stored = match postcard::take_from_bytes(body) {
            Ok((stored, [])) => stored,
            _ => return Err(no_snapshot("the snapshot was cut off or changed")),
        };
        let scene = own::from_text(&stored.scene, "", Path::new(""));
        let scene = Arc::new(scene.map_err(|e| no_snapshot(&e.to_string()))?);
        let run = scene.resume(&stored.run).map_err(|e| no_snapshot(&e.to_string()))?;
        Ok(Self { scene, source: stored.source, run, names: stored.names })
    }
}
