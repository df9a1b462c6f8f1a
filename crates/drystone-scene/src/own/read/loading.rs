//! How a file is read, and everything that is read for one scene: files within files, meshes.

use std::collections::BTreeMap;
use std::path::PathBuf;

use drystone::Shape;

use crate::read::mesh::{Solid, Triangles};
use crate::read::mesh_file::MeshFiles;

/// How a file is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// Reads the glTF file that gives [`Scene::visuals`](crate::scene::Scene::visuals), too.
    pub visuals: bool,
}

impl Options {
    /// Reads what bodies look like, too.
    #[must_use]
    pub const fn with_visuals() -> Self {
        Self { visuals: true }
    }
}

/// Everything that is read for one scene.
pub(super) struct Loading {
    pub(super) options: Options,
    /// The files that are being read, each named by the one before it.
    pub(super) stack: Vec<PathBuf>,
    pub(super) files: usize,
    pub(super) things: usize,
    pub(super) mesh_files: MeshFiles,
    /// Mesh files as they are.
    pub(super) meshes: BTreeMap<PathBuf, Triangles>,
    /// By file, kind of solid, and bits of the scale.
    pub(super) shapes: BTreeMap<(PathBuf, Solid, [u32; 3]), Vec<Shape>>,
    /// Corners of meshes that were looked at so far.
    pub(super) corners: usize,
    /// Particles of ropes and cloths so far.
    pub(super) particles: usize,
}

impl Loading {
    pub(super) fn new(options: Options) -> Self {
        Self {
            options,
            stack: Vec::new(),
            files: 0,
            things: 0,
            mesh_files: MeshFiles::default(),
            meshes: BTreeMap::new(),
            shapes: BTreeMap::new(),
            corners: 0,
            particles: 0,
        }
    }
}
