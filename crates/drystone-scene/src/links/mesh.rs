//! Hulls of mesh files beside a robot's file.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use drystone::{Hull, Shape, Vec3};

use crate::file::{self, Kind};
use crate::{obj, stl};

/// More of mesh files is not read for one scene, however often it names them [bytes].
const MOST_BYTES: u64 = 2_000_000_000;

/// The hull of a mesh, or why there is none.
type Made = Result<Shape, String>;

/// Hulls of the mesh files of a scene, each made once.
#[derive(Debug, Default)]
pub(crate) struct Hulls {
    /// By file and bits of the scale.
    made: BTreeMap<(PathBuf, [u32; 3]), Made>,
    read: u64,
}

impl Hulls {
    /// The hull of the corners of an `.obj` or `.stl` file, scaled; else why there is none.
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
        let known = ["obj", "stl"];
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let ending = ending.unwrap_or_default();
        if !known.contains(&ending.as_str()) {
            return Err(format!("a .{ending} file is not read, .obj and .stl are"));
        }
        if path.components().filter(|c| *c == Component::ParentDir).count() > 8 {
            return Err("its path is not one beside the file".to_owned());
        }
        if self.read > MOST_BYTES {
            return Err(format!("meshes of {MOST_BYTES} bytes were read before it, no more are"));
        }
        let bytes = file::read(path, Kind::Mesh)
            .map_err(|e| format!("{}, expected {}", e.problem(), e.allowed()))?;
        self.read += bytes.len() as u64;
        let points = if ending == "stl" {
            stl::corners(&bytes)?
        } else {
            obj::points(&String::from_utf8_lossy(&bytes)).map_err(|e| e.to_string())?
        };
        let points: Vec<Vec3> = points.into_iter().map(|p| p.mul_each(scale)).collect();
        hull_of_points(&points)
    }
}

/// The hull of points; else why there is none.
pub(crate) fn hull_of_points(points: &[Vec3]) -> Result<Shape, String> {
    Hull::from_points(points).map(|hull| Shape::Hull(Arc::new(hull))).map_err(|e| e.to_string())
}
