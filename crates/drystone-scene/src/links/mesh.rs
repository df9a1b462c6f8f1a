//! Hulls of mesh files beside a robot's file.

use std::io::Read;
use std::path::{Component, Path};
use std::sync::Arc;

use drystone::{Hull, Shape, Vec3};

use crate::gltf::open;
use crate::{obj, stl};

/// Larger mesh files are not read [bytes].
const MAX_BYTES: u64 = 200_000_000;

/// The hull of the corners of an `.obj` or `.stl` file, scaled; else why there is none.
pub(crate) fn hull_of_file(path: &Path, scale: Vec3) -> Result<Shape, String> {
    let known = ["obj", "stl"];
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let ending = ending.unwrap_or_default();
    if !known.contains(&ending.as_str()) {
        return Err(format!("a .{ending} file is not read, .obj and .stl are"));
    }
    if path.components().filter(|c| *c == Component::ParentDir).count() > 8 {
        return Err("its path is not one beside the file".to_owned());
    }
    let (file, size) = open(path).map_err(|e| e.problem().to_owned())?;
    if size > MAX_BYTES {
        return Err(format!("it has {size} bytes, up to {MAX_BYTES} are read"));
    }
    let mut bytes = Vec::new();
    file.take(size).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    let points = if ending == "stl" {
        stl::corners(&bytes)?
    } else {
        obj::points(&String::from_utf8_lossy(&bytes)).map_err(|e| e.to_string())?
    };
    let points: Vec<Vec3> = points.into_iter().map(|p| p.mul_each(scale)).collect();
    hull_of_points(&points)
}

/// The hull of points; else why there is none.
pub(crate) fn hull_of_points(points: &[Vec3]) -> Result<Shape, String> {
    Hull::from_points(points).map(|hull| Shape::Hull(Arc::new(hull))).map_err(|e| e.to_string())
}
