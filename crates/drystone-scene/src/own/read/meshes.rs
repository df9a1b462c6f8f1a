//! Mesh files that shapes name.

use drystone::{Shape, Vec3};

use super::reader::Reader;
use crate::error::SceneError;
use crate::own::place::Place;
use crate::read::mesh::Solid;

/// Corners and triangles of the meshes of all shapes together.
const MOST_CORNERS: usize = 100_000_000;

impl Reader<'_> {
    /// Shapes of a mesh file, which are made once and shared.
    pub(super) fn shapes_of_file(
        &mut self,
        place: &Place,
        what: Solid,
        file: &str,
        scale: Option<[f32; 3]>,
    ) -> Result<Vec<Shape>, SceneError> {
        let at = place.key("file");
        let path = self.path(&at, file)?;
        let scale = scale.map_or(Vec3::ONE, Vec3::from);
        let key = (path.clone(), what, scale.to_array().map(f32::to_bits));
        if let Some(shapes) = self.loading.shapes.get(&key) {
            return Ok(shapes.clone());
        }
        if !self.loading.meshes.contains_key(&path) {
            let read = self.loading.mesh_files.read(&path);
            let made = read.map_err(|e| self.fail(&at, e, ""))?;
            self.loading.meshes.insert(path.clone(), made);
        }
        let mut surface = self.loading.meshes.get(&path).cloned().unwrap_or_default();
        surface.points.iter_mut().for_each(|point| *point = point.mul_each(scale));
        self.loading.corners += surface.points.len() + surface.triangles.len();
        if self.loading.corners > MOST_CORNERS {
            let problem = format!("brings all meshes to more than {MOST_CORNERS} corners");
            return Err(self.fail(&at, problem, "fewer or simpler meshes"));
        }
        let made = surface.shapes(what, &at.to_string(), &mut self.scene.notes);
        let made = made.map_err(|e| self.fail(&at, e.problem, e.allowed))?;
        self.loading.shapes.insert(key, made.clone());
        Ok(made)
    }
}
