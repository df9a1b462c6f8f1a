//! How a document is read, and the result.

use std::sync::Arc;

use drystone::Vec3;

use super::document::Document;
use super::visual;
use crate::read::auto::AutoColliders;
use crate::scene::Scene;

/// How to read a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// For files without physics: make bodies from meshes.
    pub auto_colliders: Option<AutoColliders>,
    /// Gravity instead of the file's [m/s², world].
    pub gravity: Option<Vec3>,
}

/// A file as read.
#[derive(Clone, Debug)]
pub struct LoadedGltf {
    /// Its bodies and settings.
    pub scene: Scene,
    /// The document itself, for baking.
    pub document: Document,
    /// The node of each body, as numbers in the document's list of nodes.
    pub node_of_body: Vec<usize>,
}

impl LoadedGltf {
    /// Reads the meshes, materials and images of its nodes into [`Scene::visuals`]. Broken ones are
    /// left out, with a line among the scene's notes; they have no part in the simulation.
    pub fn read_visuals(&mut self) {
        let (visuals, notes) = visual::read(&self.document, &self.node_of_body);
        self.scene.visuals = Arc::new(visuals);
        self.scene.notes.extend(notes);
    }

    /// The number of animations in the document.
    #[must_use]
    pub fn animations(&self) -> usize {
        self.document.json.get("animations").and_then(|a| a.as_array()).map_or(0, Vec::len)
    }
}

/// The note on animations that do not move bodies.
pub(super) fn unplayed(animations: usize) -> String {
    format!("{animations} animations: not applied to the bodies, kept when baking")
}
