//! URDF, the Unified Robot Description Format: links, and the joints between them, as a tree.
//!
//! Read with an XML parser that keeps the line of every element, not with `urdf-rs`
//! (`docs/decisions/019-robot-files.md`). Links that fixed joints hold are one body with their
//! parent. Links with a joint between them do not collide, nor do links that overlap as the file
//! has them. Elements that only concern pictures, motors or sensors are left out; those that could
//! matter are noted.

mod element;
mod geometry;
mod inertia;
mod massless;
mod overlap;
mod tree;
mod unread;
mod xacro;

use std::path::Path;

use drystone::{BodyDef, ShapeDef, vec3};

use self::tree::Reader;
use crate::error::SceneError;
use crate::links::{Anchored, Hold, assemble};
use crate::read::xml::{self, Element};
use crate::scene::Scene;

/// Whether the first link is held by the world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Base {
    /// As it looks. A link called `world` is held, and so is one on which exactly one joint moves,
    /// as an arm's does. A link with several joints, as on legs or wheels, is free, and so is a
    /// single body.
    #[default]
    Auto,
    /// Held.
    Fixed,
    /// Free.
    Floating,
}

/// How to read a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// The base of the first link.
    pub base: Base,
    /// Height of a ground to add [m]; `None`: there is none, as the format has none.
    pub ground: Option<f32>,
}

/// Reads a `.urdf` file.
///
/// # Errors
/// A line that names the file, the place in it, what is wrong and what is allowed.
pub fn load(path: &Path, options: &Options) -> Result<Scene, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let text = xml::file(path)?;
    from_text(&text, folder, options).map_err(|e| e.in_file(path))
}

/// Reads a scene from the text of a `.urdf` file whose meshes are beside or above `folder`.
///
/// # Errors
/// A line that names the place in the file, what is wrong and what is allowed.
pub fn from_text(text: &str, folder: &Path, options: &Options) -> Result<Scene, SceneError> {
    let text = xml::mended(text);
    let document = xml::parse(&text)?;
    let robot = Element::root(&document, "robot")?;
    xacro::refuse(&robot)?;
    let mut scene = Scene::new(robot.get("name").unwrap_or("robot"), "");
    scene.config.gravity = vec3(0.0, 0.0, -9.81);
    if let Some(height) = options.ground {
        let ground = ShapeDef::half_space([0.0, 0.0, 1.0], height);
        scene.add("ground", BodyDef::fixed().with_shape(ground));
    }
    let mut reader = Reader::new(folder);
    let links = reader.tree(&robot, options)?;
    let first = scene.bodies.len();
    let mut assembled = assemble(&links, Anchored::Passes, &mut scene)?;
    reader.couple(&assembled, &mut scene);
    let (notes, left_out) = (&mut scene.notes, &mut scene.left_out);
    left_out.extend(reader.notes.iter().filter(|n| n.contains("left out")).cloned());
    notes.append(&mut reader.notes);
    let unread = unread::all(&robot);
    left_out.extend(unread.physics.iter().cloned());
    notes.extend(unread.physics);
    notes.extend(unread.driven);
    overlap::exclude(&links, &mut assembled, first, &mut scene);
    let joints = links.iter().filter(|l| matches!(l.hold, Hold::Joints(_))).count();
    scene.summary = format!("a robot of {} links and {joints} joints that move", links.len());
    Ok(scene)
}
