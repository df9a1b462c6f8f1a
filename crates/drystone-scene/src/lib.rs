//! Scenes for drystone: the catalog of built-in scenes and the file formats.

mod scene;

pub use scene::{Scene, SceneBody, SceneJoint, Script};
