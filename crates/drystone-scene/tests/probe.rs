//! A probe.
use std::path::Path;
use drystone_scene::{mjcf, urdf};
#[test]
fn probe() {
    let file = std::env::var("FILE").unwrap();
    let path = Path::new(&file);
    let mut scene = if file.ends_with("urdf") { urdf::load(path, &urdf::Options::default()).unwrap() } else { mjcf::load(path).unwrap() };
    scene.reduced = true;
    let seconds: f32 = std::env::var("SECONDS").map_or(2.0, |s| s.parse().unwrap());
    let mut run = scene.build().unwrap();
    for (i, t) in scene.trees.iter().enumerate() {
        eprintln!("tree {i}: {} links, loops {}, couplings {}", t.def.links.len(), t.def.loops.len(), t.def.couplings.len());
    }
    eprintln!("joints {} on {}", scene.joints.len(), run.world.joints().filter(|j| j.is_enabled()).count());
    let energy = |run: &drystone_scene::Running| -> f64 { run.world.articulations().map(|of| of.model().kinetic_energy() + of.model().potential_energy()).sum() };
    let mut last = energy(&run);
    let every: usize = std::env::var("EVERY").map_or(30, |s| s.parse().unwrap());
    for step in 0..(seconds * scene.hz) as usize {
        run.step(scene.hz.recip()).unwrap();
        let now = energy(&run);
        if step % every == 0 || now - last > 0.05 {
            let of = run.world.articulations().next().unwrap();
            let (mut at, mut most) = (0, 0.0_f64);
            for (i, v) in of.v().iter().enumerate() { if v.abs() > most { most = v.abs(); at = i; } }
            let deepest = run.world.contacts().map(|c| c.points().map(|p| p.separation).fold(0.0, f32::min)).fold(0.0, f32::min);
            eprintln!("step {step}: E {now:.5} ({:+.5}) most v[{at}] {most:.4} contacts {} deepest {deepest:.5} asleep {}", now - last, run.world.contacts().count(), of.is_asleep());
        }
        last = now;
    }
    let of = run.world.articulations().next().unwrap();
    eprintln!("q {:.3?}\nv {:.3?}", of.q(), of.v());
}
