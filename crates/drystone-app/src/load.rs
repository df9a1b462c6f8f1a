//! From what the user wrote to a scene: a built-in one by name, or a file.

use std::io::ErrorKind;
use std::path::Path;

use drystone_scene::Scene;
use drystone_scene::gltf;

use crate::cli::{AutoColliders, Source, has_extension};
use crate::output::Failure;

/// Endings that mean a file even where there is none.
const FILES: [&str; 3] = ["gltf", "glb", "obj"];

/// Reads or makes the scene.
///
/// Built-in names win over files of the same name, so that a folder `tower` hides nothing; write
/// `./tower` for the file.
pub(crate) fn load(source: &Source) -> Result<Scene, Failure> {
    let path = Path::new(&source.scene);
    let looks_like_a_file = has_extension(path, &FILES) || path.components().count() > 1;
    if !looks_like_a_file {
        match drystone_scene::named(&source.scene) {
            Ok(_) if source.auto_colliders.is_some() => {
                return Err(Failure::usage(format_args!(
                    "--auto-colliders is for files; {} is a built-in scene",
                    source.scene
                )));
            }
            Ok(scene) => return Ok(scene),
            Err(e) if !path.exists() => {
                return Err(Failure::failed(format_args!("{}: {e}", source.scene)));
            }
            Err(_) => {}
        }
    }
    file(path, source.auto_colliders)
}

fn file(path: &Path, auto_colliders: Option<AutoColliders>) -> Result<Scene, Failure> {
    let shown = path.display();
    let metadata = match std::fs::metadata(path) {
        Err(e) if e.kind() == ErrorKind::NotFound => {
            return Err(Failure::failed(format_args!(
                "{shown}: no such file, allowed is a .gltf or .glb file or a built-in scene \
                 (`drystone scenes` lists them)"
            )));
        }
        Err(e) => return Err(Failure::failed(format_args!("{shown}: cannot be read: {e}"))),
        Ok(metadata) => metadata,
    };
    if metadata.is_dir() {
        return Err(Failure::failed(format_args!(
            "{shown}: is a directory, allowed is a .gltf or .glb file"
        )));
    }
    if !has_extension(path, &FILES) {
        return Err(Failure::failed(format_args!(
            "{shown}: its name tells no known format, allowed is a .gltf or .glb file"
        )));
    }
    let options = gltf::Options {
        auto_colliders: auto_colliders.map(|kind| match kind {
            AutoColliders::Hull => gltf::AutoColliders::Hull,
            AutoColliders::Mesh => gltf::AutoColliders::Mesh,
            AutoColliders::Box => gltf::AutoColliders::Box,
        }),
        ..gltf::Options::default()
    };
    gltf::load(path, &options).map_err(|e| named(path, &e.to_string()))
}

/// A failure that begins with the file's name, whether or not the reader's message already does.
fn named(path: &Path, message: &str) -> Failure {
    let shown = path.display().to_string();
    if message.starts_with(&shown) {
        Failure::failed(message)
    } else {
        Failure::failed(format_args!("{shown}: {message}"))
    }
}
