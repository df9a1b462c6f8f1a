//! Hulls of mesh files beside a robot's file.

use std::path::{Component, Path};
use std::sync::Arc;

use drystone::{Hull, Shape, Vec3};

use crate::file::{self, Kind};
use crate::{obj, stl};

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
    let bytes = file::read(path, Kind::Mesh)
        .map_err(|e| format!("{}, allowed is {}", e.problem(), e.allowed()))?;
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
