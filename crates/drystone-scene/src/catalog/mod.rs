//! The catalog: built-in scenes by name, with parameters.

mod box3d;
mod breaking;
mod entry;
mod first;
mod heaps;
mod jolt;
mod linked;
mod list;
mod machines;
mod masonry;
mod parameters;
mod parts;
mod person;
mod rain;
mod steady;
mod survey;
mod threads;

use self::list::CATALOG;
use crate::scene::Scene;

pub use entry::Entry;
pub use parameters::{CatalogError, Parameter, Range, Values};

/// Every built-in scene, in the order in which they are listed.
#[must_use]
pub fn catalog() -> &'static [Entry] {
    &CATALOG
}

/// The built-in scene of a text `name` or `name:key=value,key=value`.
///
/// # Errors
/// No scene of that name, a key that the scene does not have, or a value that is not allowed; the
/// error lists those that are.
pub fn named(spec: &str) -> Result<Scene, CatalogError> {
    let (name, parameters) = match spec.split_once(':') {
        Some((name, parameters)) => (name.trim(), Some(parameters)),
        None => (spec.trim(), None),
    };
    let entry = CATALOG.iter().find(|e| e.name == name).ok_or_else(|| {
        let nearest = parameters::nearest(name, CATALOG.iter().map(|e| e.name));
        CatalogError::UnknownScene { name: name.to_owned(), nearest }
    })?;
    entry.scene(parameters)
}
