//! STL (stereolithography) meshes, text and binary.

#![no_main]

use drystone_scene::stl;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(corners) = stl::corners(bytes) {
        assert!(corners.iter().all(|c| c.is_finite()) && corners.len().is_multiple_of(3));
    }
});
