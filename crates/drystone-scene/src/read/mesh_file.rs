//! Mesh files that a scene names.

use std::path::Path;

use super::ending;
use super::mesh::Triangles;
use super::{obj, stl};
use crate::error::SceneError;
use crate::file::{self, Kind};

/// More of mesh files is not read for one scene, however often it names them [bytes].
const MOST_BYTES: u64 = 2_000_000_000;

/// A format of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Obj,
    Stl,
}

impl Format {
    /// The format of a file by its name; otherwise why it is not read.
    pub(crate) fn of(path: &Path) -> Result<Self, SceneError> {
        match ending(path).as_str() {
            "obj" => Ok(Self::Obj),
            "stl" => Ok(Self::Stl),
            other => Err(problem(format!("a .{other} file is not read, .obj and .stl are"))),
        }
    }
}

/// How much of mesh files was read for one scene.
#[derive(Debug, Default)]
pub(crate) struct MeshFiles {
    bytes: u64,
}

impl MeshFiles {
    /// The triangles of a file, in its units. Only errors of the file itself name it.
    pub(crate) fn read(&mut self, path: &Path) -> Result<Triangles, SceneError> {
        let format = Format::of(path)?;
        if self.bytes > MOST_BYTES {
            let text = format!("meshes of {MOST_BYTES} bytes were read before it, no more are");
            return Err(problem(text));
        }
        let bytes = file::read(path, Kind::Mesh)?;
        self.bytes += bytes.len() as u64;
        match format {
            Format::Obj => obj::surface(&String::from_utf8_lossy(&bytes)),
            Format::Stl => {
                let points = stl::corners(&bytes).map_err(problem)?;
                let count =
                    u32::try_from(points.len() / 3).map_err(|_| problem("it is too large"))?;
                let triangles = (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
                Ok(Triangles { points, triangles })
            }
        }
    }
}

fn problem(text: impl core::fmt::Display) -> SceneError {
    SceneError::new(Path::new(""), "", text, "")
}
