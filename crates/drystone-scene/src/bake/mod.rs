//! Writing a simulated scene as glTF: the document with one animation of its nodes.
//!
//! Core glTF only, so any viewer plays it: translation and rotation of one node a body. A document
//! that was read keeps all it had, physics too; for a scene that comes from no file a document with
//! meshes, materials and physics is made.

mod animation;
mod build;
mod file;
mod joints;
mod motion;
mod physics;
pub mod solids;
mod unsaid;

use std::path::Path;

use crate::error::SceneError;
use crate::file::Ending;
use crate::gltf::{Document, LoadedGltf};
use crate::obj::LoadedObj;
use crate::scene::{Scene, SceneBody};

pub use self::motion::Motion;
pub use self::unsaid::{Unsaid, unsaid};

/// Writes the document that was read with `motion` as its first animation, as binary glTF or, if
/// the name ends in `.gltf`, as text with all data inside. If it has no mesh at all, the shapes are
/// given one each, so that there is something to see. The file has its name when it is whole.
///
/// # Errors
/// If the file cannot be written or the motion is not of these bodies.
pub fn write(path: &Path, loaded: &LoadedGltf, motion: &Motion) -> Result<Ending, SceneError> {
    animated(path, &build::shown(loaded), &loaded.node_of_body, motion)
}

/// Writes the objects of an `.obj` file with a mesh each, and `motion` as their animation, as
/// [`write()`] does.
///
/// # Errors
/// If the file cannot be written or the motion is not of these bodies.
pub fn write_objects(
    path: &Path,
    loaded: &LoadedObj,
    motion: &Motion,
) -> Result<Ending, SceneError> {
    // The node of an object has the object's number.
    let document = build::objects(&loaded.scene.name, &loaded.objects);
    animated(path, &document, &loaded.object_of_body, motion)
}

/// Writes a scene that comes from no file, with meshes made for its shapes, and `motion` as its
/// animation. In `motion`, the bodies of the scene come first, then those that its script adds,
/// then the pieces that bodies broke into. Pieces are visible, but no part of the scene's physics.
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
    animated(path, &document, &nodes, motion)
}

/// Writes a document with `motion` of its bodies' nodes.
fn animated(
    path: &Path,
    document: &Document,
    node_of_body: &[usize],
    motion: &Motion,
) -> Result<Ending, SceneError> {
    let mut output = file::Output::of(document).map_err(|e| e.in_file(path))?;
    animation::add(&mut output, document, node_of_body, motion)
        .and_then(|()| output.write(path))
        .map_err(|e| e.in_file(path))
}

/// Writes a scene as glTF with physics, with meshes made for its shapes: motion, colliders,
/// triggers, materials, filters, and joints with their limits and drives. [`unsaid`] lists the
/// features that are left out. The file has its name when it is whole.
///
/// # Errors
/// If the file cannot be written.
pub fn save_scene(path: &Path, scene: &Scene) -> Result<Ending, SceneError> {
    let document = build::physics(scene);
    let output = file::Output::of(&document).map_err(|e| e.in_file(path))?;
    output.write(path).map_err(|e| e.in_file(path))
}
