//! A scene of the catalog and how it is made.

use super::parameters::{CatalogError, Parameter, Values};
use crate::scene::Scene;

/// A scene of the catalog.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Its name.
    pub name: &'static str,
    /// A summary of it, in a line.
    pub summary: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    builder: fn(Scene, &Values) -> Result<Scene, CatalogError>,
}

impl Entry {
    pub(super) const fn new(
        name: &'static str,
        summary: &'static str,
        builder: fn(Scene, &Values) -> Result<Scene, CatalogError>,
    ) -> Self {
        Self { name, summary, parameters: &[], builder }
    }

    pub(super) const fn with(self, parameters: &'static [Parameter]) -> Self {
        Self { parameters, ..self }
    }

    /// The scene, with parameters from `key=value,key=value`; all defaults for `None`.
    ///
    /// # Errors
    /// A key that the scene does not have, or a value that is not allowed.
    pub fn scene(&self, parameters: Option<&str>) -> Result<Scene, CatalogError> {
        let values = Values::read(self.name, self.parameters, parameters)?;
        (self.builder)(Scene::new(self.name, self.summary), &values)
    }
}
