//! MJCF, the format of MuJoCo: bodies within bodies, with geoms and joints.
//!
//! Read: bodies, frames, geoms (plane, sphere, capsule, cylinder, box, ellipsoid and mesh as
//! hulls), masses. Joints (free, hinge, slide, ball; several on a body) with ranges, springs,
//! damping and friction. Default classes, `include`, `replicate`, `attach`, contact bits and
//! excludes, `connect` and `weld`, tendons of two sites, gravity and the flags of `option`. Other
//! elements are counted and noted.

mod defaults;
mod describe;
mod geom;
mod joint;
mod mass;
mod mesh;
mod model;
mod option;
mod relations;
mod unread;
mod walk;

use std::path::Path;

use roxmltree::Document;

use self::model::{Files, Model};
use self::option::Options;
use self::walk::Walk;
use crate::error::SceneError;
use crate::links::{Anchored, assemble};
use crate::read::xml;
use crate::robot::{Joint, JointType, Robot};
use crate::scene::Scene;

/// Notes on these are not about the motion of bodies.
const STILL: [&str; 4] = ["<sensor>", "<keyframe>", "<custom>", "geoms: an ellipsoid"];

/// Reads an `.xml` file.
///
/// # Errors
/// A line that names the file, the place in it, what is wrong and what is allowed.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    let text = xml::file(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    from_text(&text, folder).map_err(|e| e.in_file(path))
}

/// Reads a scene from the text of an `.xml` file whose other files are beside or below `folder`.
///
/// # Errors
/// A line that names the place in the file, what is wrong and what is allowed.
pub fn from_text(text: &str, folder: &Path) -> Result<Scene, SceneError> {
    with_models(text, folder, interpret)
}

/// Reads a robot's joints, tendons, actuators, sensors and keyframes from an `.xml` file.
///
/// # Errors
/// A line that names the file, the place in it, what is wrong and what is allowed.
pub fn describe(path: &Path) -> Result<Robot, SceneError> {
    let text = xml::file(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    describe_text(&text, folder).map_err(|e| e.in_file(path))
}

/// Reads the same from the text of an `.xml` file whose other files are beside or below `folder`.
///
/// # Errors
/// A line that names the place in the file, what is wrong and what is allowed.
pub fn describe_text(text: &str, folder: &Path) -> Result<Robot, SceneError> {
    with_models(text, folder, |models| {
        let mut walk = Walk::new(models, Options::read(&models[0])?);
        walk.run()?;
        describe::robot(walk)
    })
}

fn with_models<T>(
    text: &str,
    folder: &Path,
    read: impl FnOnce(&[Model<'_>]) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    let files = Files::read(text, folder)?;
    let documents = files
        .texts
        .iter()
        .map(|(name, text)| {
            let document = xml::parse(text);
            document.map_err(|e| if name.is_empty() { e } else { e.in_place(name) })
        })
        .collect::<Result<Vec<Document<'_>>, SceneError>>()?;
    let models = files.models(&documents)?;
    read(&models)
}

fn interpret(models: &[Model<'_>]) -> Result<Scene, SceneError> {
    let main = &models[0];
    let option = Options::read(main)?;
    let mut scene = Scene::new(main.name, "");
    scene.config.gravity = option.gravity;
    if let Some(step) = option.timestep {
        // Substeps no longer than the file's steps, for which its stiffness was chosen.
        let substeps = f64::from(scene.config.method.substeps());
        let fitting = 1.0 / (f64::from(step) * substeps);
        #[expect(clippy::cast_possible_truncation, reason = "60 to 2000")]
        let hz = fitting.clamp(60.0, 2000.0) as f32;
        scene.hz = hz;
        scene.notes.push(format!(
            "timestep {step} s: taken as {hz} steps per second of {substeps} substeps each"
        ));
    }
    let mut walk = Walk::new(models, option);
    walk.run()?;
    let resists = |j: &&Joint| {
        j.kind == JointType::Free
            && (j.damping[0] > 0.0 || j.stiffness[0] > 0.0 || j.friction > 0.0)
    };
    for _ in 0..walk.robot.joints.iter().filter(resists).count() {
        walk.ignore("free joints: their damping, stiffness and frictionloss are not read");
    }
    let filters = geom::filters(option.contacts, &mut walk.links);
    scene.notes.extend(filters);
    scene.left_out.extend(walk.notes.iter().filter(|n| n.contains("left out")).cloned());
    scene.notes.append(&mut walk.notes);
    let mut assembled = assemble(&walk.links, Anchored::Collides, &mut scene)?;
    relations::add(&mut walk, &mut assembled, &mut scene)?;
    for (what, count) in &walk.ignored {
        let note = format!("{count} {what}");
        if !STILL.iter().any(|section| what.starts_with(section)) {
            scene.left_out.push(note.clone());
        }
        scene.notes.push(note);
    }
    let unread = unread::attributes(models);
    scene.left_out.extend(unread.physics.iter().cloned());
    scene.notes.extend(unread.physics);
    scene.notes.extend(unread.solver);
    let moving = scene.bodies.iter().filter(|b| b.def.kind == drystone::BodyKind::Dynamic).count();
    scene.summary = format!("{moving} moving bodies and {} joints", scene.joints.len());
    Ok(scene)
}
