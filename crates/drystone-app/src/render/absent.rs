//! `--render` in a build without a renderer: its options are read, and refused.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use drystone::World;
use drystone_scene::Running;

use super::wanted::Wanted;
use crate::output::Failure;

/// Any camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraSpec;

impl FromStr for CameraSpec {
    type Err = String;

    fn from_str(_: &str) -> Result<Self, String> {
        Ok(Self)
    }
}

/// Any kind of picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RenderKind;

impl RenderKind {
    pub(crate) fn of(path: &Path) -> Option<Self> {
        path.extension().map(|_| Self)
    }
}

/// There is no driver.
pub(crate) const fn quiet_driver() {}

/// Never made.
pub(crate) enum Render {}

impl Render {
    pub(crate) fn create(
        path: &Path,
        _: CameraSpec,
        _: Wanted,
        _: &Running,
        _: f64,
        _: f32,
    ) -> Result<Self, Failure> {
        Err(Failure::failed(format_args!(
            "{}: this program was built without its feature `render`",
            path.display()
        )))
    }

    pub(crate) fn add(&mut self, _: f64, _: &World) -> Result<(), Failure> {
        match *self {}
    }

    pub(crate) fn finish(self, _: &World) -> Result<PathBuf, Failure> {
        match self {}
    }
}
