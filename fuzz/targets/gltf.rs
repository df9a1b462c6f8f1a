//! glTF files, text or binary, as scenes and as pictures.

#![no_main]

use std::path::Path;

use drystone_scene::gltf::{self, AutoColliders, Options};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // Physics if the file has any, otherwise boxes; the other path below reaches hulls and
    // decomposition.
    let auto = if bytes.len().is_multiple_of(2) { AutoColliders::Hull } else { AutoColliders::Box };
    let options = Options { auto_colliders: Some(auto), ..Options::default() };
    let Ok(mut loaded) = gltf::from_slice(bytes, "fuzz", Path::new("/dev/null"), &options) else {
        return;
    };
    loaded.read_visuals();
    let _ = loaded.scene.build();
    let _ = gltf::film(loaded);
});
