//! Scenes for drystone: the catalog of built-in scenes and the file formats.

pub mod bake;
mod build;
mod catalog;
mod error;
pub mod gltf;
pub mod obj;
mod scene;

pub use build::{BuildError, Running};
pub use catalog::{CatalogError, Entry, Parameter, Range, Values, catalog, named};
pub use error::SceneError;
pub use scene::{
    Scene, SceneBody, SceneHold, SceneJoint, SceneStrand, Script, ScriptAction, StrandDef,
};
