//! Scenes in drystone's format. A scene that loads is written and read again.

#![no_main]

use std::path::Path;

use drystone_scene::own;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(scene) = own::from_text(text, "fuzz", Path::new("/dev/null")) {
        let again = own::to_text(&scene).expect("what was read has names of its own");
        let read = own::from_text(&again, "fuzz", Path::new("/dev/null"));
        assert!(read.is_ok(), "what is written is read");
        let _ = scene.build();
    }
});
