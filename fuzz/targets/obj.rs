//! Wavefront meshes, as hulls and as meshes.

#![no_main]

use drystone_scene::gltf::{AutoColliders, Options};
use drystone_scene::obj;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    for auto in [AutoColliders::Hull, AutoColliders::Mesh] {
        let options = Options { auto_colliders: Some(auto), ..Options::default() };
        if let Ok(loaded) = obj::from_slice(bytes, "fuzz", &options) {
            let _ = loaded.scene.build();
        }
    }
});
