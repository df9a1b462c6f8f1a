//! Versions of crates that do not report theirs, read from the lock file by the build script.

#[cfg(feature = "rapier")]
pub(crate) const RAPIER: &str = env!("RAPIER3D_VERSION");
#[cfg(feature = "box3d")]
pub(crate) const BOX3D_SYS: &str = env!("BOX3D_SYS_VERSION");
