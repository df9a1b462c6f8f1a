//! Scenes for drystone: the catalog of built-in scenes and the file formats.

pub mod bake;
mod error;
pub mod gltf;
pub mod obj;
mod scene;

pub use error::SceneError;
pub use scene::{Scene, SceneBody, SceneJoint, Script};
