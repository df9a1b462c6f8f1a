//! Robots in URDF files.

#![no_main]

use std::path::Path;

use drystone_scene::urdf::{self, Base, Options};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    for base in [Base::Auto, Base::Floating] {
        let options = Options { base, ground: Some(0.0) };
        if let Ok(scene) = urdf::from_text(text, Path::new("/dev/null"), &options) {
            let _ = scene.build();
        }
    }
});
