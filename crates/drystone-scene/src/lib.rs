//! Scenes for drystone: the catalog of built-in scenes and the file formats.

pub mod bake;
mod build;
mod catalog;
mod error;
pub mod file;
pub mod gltf;
mod links;
mod mass;
pub mod mjcf;
pub mod obj;
pub mod own;
mod read;
pub mod rigid_ipc;
pub mod robot;
mod scene;
mod transform;
pub mod urdf;
pub mod visual;

pub use build::{BuildError, ResumeError, Running, SavedRun};
pub use catalog::{CatalogError, Entry, Parameter, Range, Values, catalog, named};
pub use error::SceneError;
pub use links::reduce;
pub use read::stl;
pub use scene::{
    Film, Load, Scene, SceneBody, SceneCoupling, SceneFrame, SceneHold, SceneJoint, SceneLink,
    SceneStrand, SceneTree, Script, ScriptAction, StrandDef, Wave,
};
