//! Reads the scene that the user named: a built-in one, or a file.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use drystone::Vec3;
use drystone_scene::gltf::{self, LoadedGltf};
use drystone_scene::obj::{self, LoadedObj};
use drystone_scene::own::{self, JsonKind};
use drystone_scene::{BuildError, Running, Scene, SceneError, mjcf, rigid_ipc, urdf};

use crate::cli::{AutoColliders, Base, Settings, Source};
use crate::output::{Failure, has_extension};
use crate::report::page::count;

/// Endings that mean a file even where there is none.
const FILES: [&str; 6] = ["gltf", "glb", "obj", "urdf", "xml", "json"];

/// Scenes that a user can give, beside the built-in ones.
const ALLOWED: &str = "a .gltf, .glb, .obj, .urdf, .xml (MJCF) or .json (drystone, Rigid-IPC) file";

/// A scene, and the file it came from.
#[derive(Debug)]
pub(crate) enum Loaded {
    /// From the catalog.
    BuiltIn(Box<Scene>),
    /// From a file with nothing more to bake than the scene.
    Read(Box<Scene>),
    /// From a file of the own format, which may name a file with its visuals.
    Own(Box<Scene>, PathBuf),
    /// From a glTF file, which is kept for baking.
    Gltf(Box<LoadedGltf>),
    /// From an `.obj` file, whose objects are kept for baking.
    Obj(Box<LoadedObj>),
}

impl Loaded {
    /// The scene.
    pub(crate) fn scene(&self) -> &Scene {
        match self {
            Self::BuiltIn(scene) | Self::Read(scene) | Self::Own(scene, _) => scene,
            Self::Gltf(loaded) => &loaded.scene,
            Self::Obj(loaded) => &loaded.scene,
        }
    }

    /// Reads the visuals of a file, for pictures.
    pub(crate) fn read_visuals(&mut self) {
        match self {
            Self::Gltf(loaded) => loaded.read_visuals(),
            Self::Obj(loaded) => loaded.read_visuals(),
            Self::Own(scene, path) => {
                match own::load(path, &own::Options::with_visuals()) {
                    Ok(seen) => scene.visuals = seen.visuals,
                    // No error in visuals can stop a scene from being simulated.
                    Err(e) => scene.notes.push(format!("visuals: left out: {e}")),
                }
            }
            Self::BuiltIn(_) | Self::Read(_) => {}
        }
    }

    /// The scene, to change it.
    pub(crate) fn scene_mut(&mut self) -> &mut Scene {
        match self {
            Self::BuiltIn(scene) | Self::Read(scene) | Self::Own(scene, _) => scene,
            Self::Gltf(loaded) => &mut loaded.scene,
            Self::Obj(loaded) => &mut loaded.scene,
        }
    }
}

/// Reads or makes the scene. `gravity` [m/s²] is that of the command line, if any: the lowest body
/// of a file without physics is found along it.
///
/// Built-in names win over files of the same name, so that a folder `tower` hides nothing; write
/// `./tower` for the file.
pub(crate) fn load(source: &Source, gravity: Option<Vec3>) -> Result<Loaded, Failure> {
    let path = Path::new(&source.scene);
    let looks_like_a_file = has_extension(path, &FILES) || path.components().count() > 1;
    if !looks_like_a_file {
        match drystone_scene::named(&source.scene) {
            Ok(_) if source.reading.auto_colliders.is_some() => {
                return Err(Failure::usage(format_args!(
                    "--auto-colliders is for files; {} is a built-in scene",
                    source.scene
                )));
            }
            Ok(_) if source.reading.base.is_some() || source.reading.ground.is_some() => {
                return Err(not_a_robot());
            }
            Ok(_) if source.reading.reduced => return Err(no_trees(&source.scene)),
            Ok(scene) => return Ok(Loaded::BuiltIn(Box::new(scene))),
            Err(e) if !path.exists() => {
                return Err(Failure::failed(format_args!("{}: {e}", source.scene)));
            }
            Err(_) => {}
        }
    }
    let mut loaded = file(path, source, gravity)?;
    if source.reading.reduced && !drystone_scene::reduce(loaded.scene_mut()) {
        return Err(no_trees(&source.scene));
    }
    if source.reading.strict
        && let Some(first) = loaded.scene().left_out.first()
    {
        let kinds = count(loaded.scene().left_out.len(), "kind");
        let shown = path.display();
        return Err(Failure::failed(format_args!(
            "{shown}: {kinds} of physics not read, and --strict allows none; the first: {first}"
        )));
    }
    Ok(loaded)
}

/// Reads or makes the scene, with the settings of the command line for its world.
pub(crate) fn load_with(source: &Source, settings: &Settings) -> Result<Loaded, Failure> {
    let mut loaded = load(source, settings.gravity()?)?;
    settings.apply(&mut loaded.scene_mut().config)?;
    Ok(loaded)
}

fn file(path: &Path, source: &Source, gravity: Option<Vec3>) -> Result<Loaded, Failure> {
    let auto_colliders = source.reading.auto_colliders;
    let shown = path.display();
    let metadata = match std::fs::metadata(path) {
        Err(e) if e.kind() == ErrorKind::NotFound => {
            return Err(Failure::failed(format_args!(
                "{shown}: no such file, expected {ALLOWED} or a built-in scene \
                 (`drystone scenes` lists them)"
            )));
        }
        Err(e) => return Err(Failure::failed(format_args!("{shown}: cannot be read: {e}"))),
        Ok(metadata) => metadata,
    };
    if metadata.is_dir() {
        return Err(Failure::failed(format_args!("{shown}: is a directory, expected {ALLOWED}")));
    }
    if has_extension(path, &["xacro"]) {
        return Err(Failure::failed(format_args!(
            "{shown}: a xacro file has to be expanded first: `xacro {shown} > robot.urdf` \
             (`pip install xacro`)"
        )));
    }
    if !has_extension(path, &FILES) {
        return Err(Failure::failed(format_args!(
            "{shown}: its name has no known ending, expected {ALLOWED}"
        )));
    }
    let is_robot = has_extension(path, &["urdf"]);
    if is_robot || has_extension(path, &["xml", "json"]) {
        if auto_colliders.is_some() {
            return Err(Failure::usage("--auto-colliders is for files without physics"));
        }
        let read = if is_robot {
            robot(path, source).map(|scene| Loaded::Read(Box::new(scene)))
        } else {
            described(path, source)?
        };
        let mut loaded = read.map_err(Failure::failed)?;
        let config = &mut loaded.scene_mut().config;
        config.gravity = gravity.unwrap_or(config.gravity);
        return Ok(loaded);
    }
    if source.reading.base.is_some() || source.reading.ground.is_some() {
        return Err(not_a_robot());
    }
    let options = gltf::Options {
        auto_colliders: auto_colliders.map(|kind| match kind {
            AutoColliders::Hull => gltf::AutoColliders::Hull,
            AutoColliders::Mesh => gltf::AutoColliders::Mesh,
            AutoColliders::Box => gltf::AutoColliders::Box,
        }),
        gravity,
    };
    let loaded = if has_extension(path, &["obj"]) {
        obj::load(path, &options).map(|file| Loaded::Obj(Box::new(file)))
    } else {
        gltf::load(path, &options).map(|file| Loaded::Gltf(Box::new(file)))
    };
    loaded.map_err(Failure::failed)
}

fn no_trees(scene: &str) -> Failure {
    Failure::usage(format_args!(
        "--reduced is for .urdf and MJCF files with joints; {scene} has no such tree"
    ))
}

fn not_a_robot() -> Failure {
    Failure::usage("--base and --ground are for .urdf files")
}

fn robot(path: &Path, source: &Source) -> Result<Scene, SceneError> {
    let base = match source.reading.base {
        None | Some(Base::Auto) => urdf::Base::Auto,
        Some(Base::Fixed) => urdf::Base::Fixed,
        Some(Base::Floating) => urdf::Base::Floating,
    };
    urdf::load(path, &urdf::Options { base, ground: source.reading.ground })
}

/// A scene of the own format, MuJoCo or Rigid-IPC, which says itself what its bodies stand on.
fn described(path: &Path, source: &Source) -> Result<Result<Loaded, SceneError>, Failure> {
    if source.reading.base.is_some() || source.reading.ground.is_some() {
        return Err(not_a_robot());
    }
    let read = |scene: Scene| Loaded::Read(Box::new(scene));
    if !has_extension(path, &["json"]) {
        return Ok(mjcf::load(path).map(read));
    }
    Ok(match own::kind_of(path) {
        Ok(JsonKind::Own) => own::load(path, &own::Options::default())
            .map(|scene| Loaded::Own(Box::new(scene), path.to_owned())),
        Ok(_) => rigid_ipc::load(path).map(read),
        Err(e) => Err(e),
    })
}

/// The scene as a world; `source` is the name that the user gave.
pub(crate) fn build(scene: &Scene, source: &str) -> Result<Running, Failure> {
    scene.build().map_err(|e| refused(source, &e))
}

/// The engine refuses something of the scene that the user called `source`.
pub(crate) fn refused(source: &str, e: &BuildError) -> Failure {
    let path = Path::new(source);
    if has_extension(path, &["json"]) && matches!(own::kind_of(path), Ok(JsonKind::Own)) {
        return Failure::failed(own::refused(path, e));
    }
    Failure::failed(format_args!("{source}: {e}"))
}
