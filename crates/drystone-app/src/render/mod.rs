//! Pictures and films of a run.

#[cfg(not(feature = "render"))]
mod absent;
#[cfg(feature = "render")]
mod camera;
#[cfg(feature = "render")]
mod draw;
#[cfg(feature = "render")]
mod encode;
mod wanted;

#[cfg(not(feature = "render"))]
pub(crate) use self::absent::{CameraSpec, Render, RenderKind, quiet_driver};
#[cfg(feature = "render")]
pub(crate) use self::camera::CameraSpec;
#[cfg(feature = "render")]
pub(crate) use self::draw::{Render, quiet_driver};
#[cfg(feature = "render")]
pub(crate) use self::encode::Kind as RenderKind;
pub(crate) use self::wanted::Wanted;
