//! The shared part of all readers: text and names of files, values with their places, triangles,
//! and bodies for files without physics. Nothing here depends on the format of a scene.

pub(crate) mod auto;
pub(crate) mod json;
pub(crate) mod look;
pub(crate) mod mesh;
pub(crate) mod mesh_file;
pub(crate) mod names;
pub(crate) mod obj;
pub mod stl;
pub(crate) mod volume;
pub(crate) mod xml;

use std::path::Path;

use crate::error::SceneError;
use crate::file::{self, Kind};

/// A file of text.
pub(crate) const UTF8: &str = "a file of UTF-8 text";

/// All of a file of text; `allowed` is what it should have been if it is not UTF-8.
pub(crate) fn text(path: &Path, allowed: &str) -> Result<String, SceneError> {
    String::from_utf8(file::read(path, Kind::Text)?)
        .map_err(|_| SceneError::new(path, "", "it is not UTF-8 text", allowed))
}

/// The name of a file without folder and ending.
pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

/// The ending of a file's name, in small letters; empty if it has none.
pub(crate) fn ending(path: &Path) -> String {
    path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_ascii_lowercase())
}
