//! Hulls of mesh files beside a robot's file.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use drystone::{Shape, Vec3};

use crate::read::mesh::{Triangles, hull_of_points};
use crate::read::mesh_file::{Format, MeshFiles};

/// The hull of a mesh, or why there is none.
type Made = Result<Shape, String>;

/// Hulls of the mesh files of a scene, each made once.
#[derive(Debug, Default)]
pub(crate) struct Hulls {
    /// By file and bits of the scale.
    made: BTreeMap<(PathBuf, [u32; 3]), Made>,
    files: MeshFiles,
}

impl Hulls {
    /// The hull of the corners of an `.obj` or `.stl` file, scaled; otherwise why there is none.
    pub(crate) fn of_file(&mut self, path: &Path, scale: Vec3) -> Made {
        let key = (path.to_owned(), scale.to_array().map(f32::to_bits));
        if let Some(made) = self.made.get(&key) {
            return made.clone();
        }
        let made = self.read(path, scale);
        self.made.insert(key, made.clone());
        made
    }

    fn read(&mut self, path: &Path, scale: Vec3) -> Made {
        let mut surface = self.surface(path)?;
        surface.points.iter_mut().for_each(|p| *p = p.mul_each(scale));
        hull_of_points(&surface.points)
    }

    /// The triangles of an `.obj` or `.stl` file, in its units; otherwise why there are none.
    pub(crate) fn surface(&mut self, path: &Path) -> Result<Triangles, String> {
        Format::of(path).map_err(|e| e.to_string())?;
        if path.components().filter(|c| *c == Component::ParentDir).count() > 8 {
            return Err("its path is not one beside the file".to_owned());
        }
        // The scene's note names the file.
        self.files.read(path).map_err(|e| e.in_file(Path::new("")).to_string())
    }
}
