//! MuJoCo files.

#![no_main]

use std::path::Path;

use drystone_scene::mjcf;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(scene) = mjcf::from_text(text, Path::new("/dev/null")) {
        let _ = scene.build();
    }
});
