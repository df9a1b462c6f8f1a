//! Writing a simulated scene as glTF: the document with one animation of its nodes.
//!
//! Core glTF only, so any viewer plays it: translation and rotation of one node a body. A document
//! that was read keeps all it had, physics too; for a scene that comes from no file a document with
//! meshes, materials and physics is made.

mod animation;
mod build;
mod file;
mod joints;
pub mod solids;
mod unsaid;

pub(crate) use self::animation::slerp;
pub(crate) use self::build::{MeshPart, document_of_meshes};

pub use self::unsaid::{Unsaid, unsaid};

use std::path::Path;

use drystone::Pose;

use crate::error::SceneError;
use crate::file::Ending;
use crate::gltf::LoadedGltf;
use crate::scene::{Scene, SceneBody};

/// Where the bodies were at some times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Times, rising [s].
    pub times: Vec<f32>,
    /// Poses of each body's origin at these times [world], `[body][time]`. A shorter list belongs to
    /// the last times: the body appeared later and is hidden before.
    pub poses: Vec<Vec<Pose>>,
    /// Of each body, at how many of the last times it was gone: its poses are those before, and it is hidden
    /// again. Bodies beyond the end of the list stay.
    pub gone: Vec<usize>,
}

impl Motion {
    /// No motion of the bodies of a scene: every node is where the document has it.
    #[must_use]
    pub fn still(scene: &Scene) -> Self {
        Self { poses: vec![Vec::new(); scene.bodies.len()], ..Self::default() }
    }

    /// The first of the times at which a body was there.
    fn first(&self, body: usize) -> usize {
        let gone = self.gone.get(body).copied().unwrap_or(0);
        self.times.len().saturating_sub(gone + self.poses[body].len())
    }
}

/// Writes the document that was read with `motion` as its first animation, as binary glTF or, if
/// the name ends in `.gltf`, as text with all data inside. If it has no mesh at all, the shapes are
/// given one each, so that there is something to see. The file has its name when it is whole.
///
/// # Errors
/// If the file cannot be written or the motion is not of these bodies.
pub fn write(path: &Path, loaded: &LoadedGltf, motion: &Motion) -> Result<Ending, SceneError> {
    let document = build::shown(loaded);
    let mut output = file::Output::of(&document).map_err(|e| e.in_file(path))?;
    animation::add(&mut output, &document, &loaded.node_of_body, motion)
        .and_then(|()| output.write(path))
        .map_err(|e| e.in_file(path))
}

/// Writes a scene that comes from no file, with meshes made for its shapes, and `motion` as its
/// animation. The bodies that the scene's script brings count as bodies after all others, and then come
/// those that bodies broke into: they are to be seen, and no part of the scene's physics.
///
/// # Errors
/// If the file cannot be written or the motion is not of these bodies.
pub fn write_scene(
    path: &Path,
    scene: &Scene,
    pieces: &[SceneBody],
    motion: &Motion,
) -> Result<Ending, SceneError> {
    let (document, nodes) = build::document(scene, pieces);
    let mut output = file::Output::of(&document).map_err(|e| e.in_file(path))?;
    animation::add(&mut output, &document, &nodes, motion)
        .and_then(|()| output.write(path))
        .map_err(|e| e.in_file(path))
}

/// Writes a scene as glTF with physics, with meshes made for its shapes: motion, colliders, triggers, materials, filters, and
/// joints with their limits and drives. [`unsaid`] tells what is left out. The file has its name when it is whole.
///
/// # Errors
/// If the file cannot be written.
pub fn save_scene(path: &Path, scene: &Scene) -> Result<Ending, SceneError> {
    let document = build::physics(scene);
    let output = file::Output::of(&document).map_err(|e| e.in_file(path))?;
    output.write(path).map_err(|e| e.in_file(path))
}
