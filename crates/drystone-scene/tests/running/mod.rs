//! A scene that runs without faults.

use drystone_scene::{Running, Scene};

/// The scene after some seconds; `each` sees it after every step.
pub(crate) fn run(scene: &Scene, seconds: f32, mut each: impl FnMut(&Running)) -> Running {
    let mut running = scene.build().unwrap();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number")]
    let steps = (seconds * scene.hz).round() as u32;
    for _ in 0..steps {
        running.step(scene.hz.recip()).unwrap();
        assert!(running.world.events().faults.is_empty());
        each(&running);
    }
    running
}
