//! Things that stand in a file once, under a name.

use std::collections::BTreeMap;
use std::sync::Arc;

use drystone::Shape;

use super::said::refuse;
use super::shape::{self, geometry, material_key};
use crate::error::SceneError;
use crate::own::document::{Document, Material};
use crate::own::value::{Or, Ref};
use crate::scene::{Scene, SceneBody};

/// Names of the things that stand in the file once.
#[derive(Default)]
pub(super) struct Names {
    /// Geometry that several shapes share, by its address.
    pub(super) shapes: BTreeMap<usize, String>,
    /// Materials that several shapes have, by their bits.
    pub(super) materials: BTreeMap<[u32; 9], String>,
    /// Names of bodies, by their numbers.
    pub(super) bodies: Vec<String>,
}

/// The address of a hull or mesh, which shapes can share.
pub(super) fn address(shape: &Shape) -> Option<usize> {
    match shape {
        Shape::Hull(hull) => Some(Arc::as_ptr(hull).cast::<()>() as usize),
        Shape::Mesh(mesh) => Some(Arc::as_ptr(mesh).cast::<()>() as usize),
        _ => None,
    }
}

impl Names {
    /// A reference to a body.
    pub(super) fn body(&self, number: usize) -> Ref {
        self.bodies.get(number).map_or(Ref::Number(number), |name| Ref::Name(name.clone()))
    }

    /// Names what stands in a scene more than once; fills the tables of the file.
    pub(super) fn of(scene: &Scene, document: &mut Document) -> Result<Self, SceneError> {
        let mut names = Self::default();
        let mut taken = BTreeMap::new();
        for SceneBody { name, .. } in scene.bodies.iter().chain(scene.script.joining()) {
            if taken.insert(name.as_str(), ()).is_some() {
                let problem = format!("two bodies are called '{name}'");
                return Err(refuse("bodies", problem, "a name of its own for each body"));
            }
            names.bodies.push(name.clone());
        }
        let mut uses: BTreeMap<usize, (usize, &Shape)> = BTreeMap::new();
        let mut order = Vec::new();
        let mut surfaces: BTreeMap<[u32; 9], usize> = BTreeMap::new();
        let mut kinds = Vec::new();
        for body in scene.bodies.iter().chain(scene.script.joining()) {
            for shape in &body.def.shapes {
                if let Some(address) = address(&shape.shape) {
                    let entry = uses.entry(address).or_insert((0, &shape.shape));
                    entry.0 += 1;
                    if entry.0 == 1 {
                        order.push(address);
                    }
                }
                let key = material_key(&shape.material);
                let count = surfaces.entry(key).or_default();
                *count += 1;
                if *count == 1 {
                    kinds.push((key, shape.material));
                }
            }
        }
        for address in order {
            let shared = uses.get(&address).filter(|(count, _)| *count > 1);
            let Some((_, shape)) = shared else { continue };
            let name = format!("{} {}", shape.kind(), names.shapes.len() + 1);
            document.shapes.0.push((name.clone(), geometry(shape)?));
            names.shapes.insert(address, name);
        }
        let plain = material_key(&drystone::Material::default());
        for (key, material) in kinds {
            if key == plain || surfaces.get(&key).is_none_or(|count| *count < 2) {
                continue;
            }
            let name = format!("material {}", names.materials.len() + 1);
            document.materials.0.push((name.clone(), shape::material(&material)));
            names.materials.insert(key, name);
        }
        Ok(names)
    }

    /// A material by its name, or as it is; `None` for the default.
    pub(super) fn material(&self, material: &drystone::Material) -> Option<Or<Material>> {
        let key = material_key(material);
        if key == material_key(&drystone::Material::default()) {
            return None;
        }
        Some(match self.materials.get(&key) {
            Some(name) => Or::Name(name.clone()),
            None => Or::Here(shape::material(material)),
        })
    }
}
