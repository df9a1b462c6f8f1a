//! Rigid-IPC scenes.

#![no_main]

use std::path::Path;

use drystone_scene::rigid_ipc;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(scene) = rigid_ipc::from_text(text, "fuzz", Path::new("/dev/null")) {
        let _ = scene.build();
    }
});
