//! Runs from snapshots of the command, and steps from its logs.

#![no_main]

mod seeds;

use drystone_scene::SavedRun;
use libfuzzer_sys::fuzz_target;

fn write_seeds() {
    let Some(folder) = seeds::folder() else { return };
    let scene = drystone_scene::named("hello").expect("a scene of the catalog");
    let saved = scene.save(&seeds::running("hello")).expect("the scene can be built");
    let bytes = postcard::to_stdvec(&saved).expect("lists and numbers can be written");
    seeds::write(&folder, "hello", &bytes);
}

fuzz_target!(init: write_seeds(), |bytes: &[u8]| {
    let Ok(run) = postcard::from_bytes::<SavedRun>(bytes) else { return };
    let scene = drystone_scene::named("hello").expect("a scene of the catalog");
    let Ok(mut running) = scene.resume(&run) else { return };
    for _ in 0..20 {
        if running.before_step(1.0 / 60.0).is_err() {
            return;
        }
        running.world.step(1.0 / 60.0);
        running.after_step();
    }
});
