//! Scenes for drystone: the catalog of built-in scenes and the file formats.

mod catalog;
mod scene;

pub use catalog::{CatalogError, Entry, Parameter, Range, Values, catalog, named};
pub use scene::{Scene, SceneBody, SceneJoint, Script};
