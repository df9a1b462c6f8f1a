//! Scenes for drystone: the catalog of built-in scenes and the file formats.

mod build;
mod catalog;
mod scene;

pub use build::{Running, SceneError};
pub use catalog::{CatalogError, Entry, Parameter, Range, Values, catalog, named};
pub use scene::{Scene, SceneBody, SceneJoint, Script};
