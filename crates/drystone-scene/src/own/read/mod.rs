//! From a file to a scene.

mod body;
mod joint;
mod loading;
mod meshes;
mod part;
mod reader;
mod relations;
mod shape;
mod strand;
mod surface;
mod turn;
mod visuals;
mod whole;
mod world;

use std::path::Path;

use self::loading::Loading;
use self::whole::scene_of;
use crate::error::SceneError;
use crate::scene::Scene;

pub use self::loading::Options;

pub(super) fn load(path: &Path, options: &Options) -> Result<Scene, SceneError> {
    Loading::new(*options).load(path)
}

pub(super) fn from_text(
    text: &str,
    name: &str,
    folder: &Path,
    options: &Options,
) -> Result<Scene, SceneError> {
    scene_of(text, name, folder, &mut Loading::new(*options))
}
