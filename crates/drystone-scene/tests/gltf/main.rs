//! glTF files: how they are read, refused and written.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail anywhere")]

mod baked;
mod bodies;
mod documents;
mod meshes;
mod motion;
mod refused;
