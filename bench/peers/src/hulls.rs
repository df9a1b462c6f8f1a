//! Translates hulls and meshes once if several bodies share them.

use std::sync::Arc;

use drystone::{Hull, Mesh};
use drystone_bench::EngineError;

/// Translated hulls and meshes, with their originals as keys.
#[derive(Debug)]
pub(crate) struct Shared<T> {
    hulls: Vec<(Arc<Hull>, T)>,
    meshes: Vec<(Arc<Mesh>, T)>,
}

impl<T> Default for Shared<T> {
    fn default() -> Self {
        Self { hulls: Vec::new(), meshes: Vec::new() }
    }
}

impl<T: Clone> Shared<T> {
    /// The translation of this hull; made now if it is new.
    pub(crate) fn hull(
        &mut self,
        hull: &Arc<Hull>,
        make: impl FnOnce() -> Option<T>,
    ) -> Result<T, EngineError> {
        find(&mut self.hulls, hull, "hull", make)
    }

    /// The translation of this mesh; made now if it is new.
    pub(crate) fn mesh(
        &mut self,
        mesh: &Arc<Mesh>,
        make: impl FnOnce() -> Option<T>,
    ) -> Result<T, EngineError> {
        find(&mut self.meshes, mesh, "mesh", make)
    }
}

fn find<S, T: Clone>(
    known: &mut Vec<(Arc<S>, T)>,
    shape: &Arc<S>,
    kind: &str,
    make: impl FnOnce() -> Option<T>,
) -> Result<T, EngineError> {
    if let Some((_, translated)) = known.iter().find(|(other, _)| Arc::ptr_eq(other, shape)) {
        return Ok(translated.clone());
    }
    let made = make().ok_or_else(|| EngineError(format!("it refuses a {kind}")))?;
    known.push((Arc::clone(shape), made.clone()));
    Ok(made)
}
