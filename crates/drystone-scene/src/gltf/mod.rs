//! glTF 2.0 with physics: `KHR_implicit_shapes` and `KHR_physics_rigid_bodies`.
//!
//! A node with `motion` is a body; colliders on it and below it are its shapes. A collider with no
//! `motion` above it is a static body of its own. Joints hold them together. Without these
//! extensions bodies can be made from the meshes, see [`AutoColliders`]. Nothing in a file is
//! trusted: every number, index and length is checked, and an error names the place in one line.

mod accessor;
mod auto;
mod document;
mod film;
mod geometry;
mod image;
mod info;
mod joints;
mod loaded;
mod material;
mod mesh;
mod nodes;
mod physics;
mod surface;
mod visual;

use std::path::{Path, PathBuf};

use drystone::{BodyDef, Vec3};

use crate::error::SceneError;
use crate::read::json::At;
use crate::read::{auto as from_meshes, names, stem};
use crate::scene::{Scene, SceneBody};

use self::loaded::unplayed;

pub(crate) use self::document::resource;
pub(crate) use self::nodes::{Tree, read as read_tree};
pub(crate) use self::physics::STATIC_BODY;
pub(crate) use self::surface::{COMBINE, GEOMETRIC_MEAN};

pub use self::document::Document;
pub use self::film::film;
pub use self::info::info;
pub use self::loaded::{LoadedGltf, Options};
pub use crate::read::auto::AutoColliders;
pub use crate::scene::Film;

/// Extensions that may be required: those read here, and those that only concern pictures.
const KNOWN: [&str; 8] = [
    "KHR_implicit_shapes",
    "KHR_collision_shapes",
    "KHR_physics_rigid_bodies",
    "KHR_mesh_quantization",
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
    "KHR_node_visibility",
    "KHR_texture_transform",
];
const PICTURES: [&str; 5] =
    ["KHR_materials_", "KHR_texture_", "KHR_lights_punctual", "KHR_xmp", "EXT_texture_"];

/// Reads a `.gltf` or `.glb` file.
///
/// # Errors
/// A line that names the file, the place in it, what is wrong and what is allowed.
pub fn load(path: &Path, options: &Options) -> Result<LoadedGltf, SceneError> {
    let document = document::open(path)?;
    interpret(document, &stem(path), options).map_err(|e| e.in_file(path))
}

/// Reads a scene from the bytes of a `.gltf` or `.glb` file called `name` whose relative URIs start
/// from `folder`.
///
/// # Errors
/// A line that names the place in the file, what is wrong and what is allowed.
pub fn from_slice(
    bytes: &[u8],
    name: &str,
    folder: &Path,
    options: &Options,
) -> Result<LoadedGltf, SceneError> {
    let file = PathBuf::from(name);
    let loaded =
        document::parse(bytes, folder.to_path_buf()).and_then(|d| interpret(d, name, options));
    loaded.map_err(|e| e.in_file(&file))
}

fn interpret(document: Document, name: &str, options: &Options) -> Result<LoadedGltf, SceneError> {
    let root = At::root(&document.json);
    let mut scene = Scene::new(name, "read from a glTF file");
    extensions(&root, &mut scene.notes)?;
    let tree = nodes::read(&root)?;
    let mut gravity = scene.config.gravity;
    if let Some(at) = root.dig(&["asset", "extras", "gravity"]) {
        gravity = at.vec3()?;
    }
    scene.config.gravity = options.gravity.unwrap_or(gravity);
    if let Some(at) = root.dig(&["asset", "extras", "drystone"]) {
        times(&at, &mut scene)?;
    }
    let (found, joints) = if physics::is_present(&root)? {
        physics::read(&document, &tree, &mut scene.notes)?
    } else {
        let Some(how) = options.auto_colliders else {
            let allowed = "physics in the file, or --auto-colliders hull|mesh|box";
            return Err(root.error("it has no physics to simulate", allowed));
        };
        let up = (-scene.config.gravity).normalize_or(Vec3::Y);
        (auto::bodies(&document, &tree, how, up, &mut scene.notes)?, Vec::new())
    };
    if found.is_empty() {
        return Err(
            root.error("it has no body", "at least one node with a collider, a trigger or motion")
        );
    }
    unread(&root, &tree, &mut scene.notes)?;
    let list = root.list("nodes")?;
    let node_of_body: Vec<usize> = found.iter().map(|f| f.node).collect();
    let names = names::unique(&node_of_body, |node| tree.name(node));
    for (found, name) in found.into_iter().zip(names) {
        check(&found.def, &list[found.node])?;
        let def = BodyDef { user_data: found.node as u64, ..found.def };
        scene.bodies.push(SceneBody { name, def });
    }
    scene.joints = joints;
    scene.summary = from_meshes::summary(scene.bodies.iter().map(|b| &b.def));
    Ok(LoadedGltf { scene, document, node_of_body })
}

/// How a scene is run: what [`crate::bake::save_scene`] writes of it.
fn times(at: &At<'_>, scene: &mut Scene) -> Result<(), SceneError> {
    if let Some(at) = at.get("hz") {
        scene.hz = at.f32()?;
        if !(1.0e-3..=1.0e6).contains(&scene.hz) {
            return Err(at.wrong("0.001 to 1e6"));
        }
    }
    if let Some(at) = at.get("seconds") {
        scene.seconds = at.at_least_zero()?;
        if scene.seconds > 1.0e9 {
            return Err(at.wrong("0 to 1e9 [s]"));
        }
    }
    Ok(())
}

/// The engine's own check, with its error in the terms of the file.
fn check(def: &BodyDef, node: &At<'_>) -> Result<(), SceneError> {
    def.validate()
        .map_err(|e| node.error(format!("{} of its body is {}", e.field(), e.value()), e.allowed()))
}

/// Refuses required extensions that are not known; notes the others.
fn extensions(root: &At<'_>, notes: &mut Vec<String>) -> Result<(), SceneError> {
    let is_picture = |name: &str| PICTURES.iter().any(|p| name.starts_with(p));
    for at in root.list("extensionsRequired")? {
        let name = at.text()?;
        if !KNOWN.contains(&name) && !is_picture(name) {
            return Err(at.error(
                format!("the extension \"{name}\" is required and not known"),
                "KHR_implicit_shapes, KHR_physics_rigid_bodies, KHR_mesh_quantization and extensions of materials and lights",
            ));
        }
    }
    for at in root.list("extensionsUsed")? {
        let name = at.text()?;
        if !KNOWN.contains(&name) {
            notes.push(format!("extension {name}: not read, kept when baking"));
        }
    }
    Ok(())
}

/// Notes the parts of the document that have no part in the simulation.
fn unread(root: &At<'_>, tree: &Tree, notes: &mut Vec<String>) -> Result<(), SceneError> {
    let animations = root.list("animations")?.len();
    if animations > 0 {
        notes.push(unplayed(animations));
    }
    let skins = root.list("skins")?.len();
    if skins > 0 {
        notes.push(format!("{skins} skins: not applied"));
    }
    let away = tree.nodes.iter().filter(|n| !n.in_scene).count();
    if away > 0 {
        notes.push(format!("{away} nodes are not in the default scene"));
    }
    Ok(())
}
