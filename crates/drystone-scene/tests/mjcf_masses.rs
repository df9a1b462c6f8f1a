//! Masses of MJCF files are MuJoCo's: `scripts/mujoco_masses.py` wrote the files and the numbers.

use std::fs;
use std::path::{Path, PathBuf};

use drystone::{MassDef, Vec3};
use drystone_scene::mjcf;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/mjcf-own")
}

#[test]
fn masses_centers_and_inertias_are_those_of_mujoco() {
    let table = fs::read_to_string(folder().join("masses.txt")).unwrap();
    let mut wrong = Vec::new();
    for line in table.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let numbers: Vec<f32> = words[2..].iter().map(|w| w.parse().unwrap()).collect();
        let [mass, x, y, z, xx, yy, zz, xy, xz, yz] = numbers[..] else { panic!("{line}") };
        let scene = mjcf::load(&folder().join(words[0])).unwrap();
        let body = scene.bodies.iter().find(|b| b.name == words[1]).unwrap();
        let MassDef::Exact { mass: own, center, inertia: i } = body.def.mass else {
            wrong.push(format!("{line}: it does not move"));
            continue;
        };
        // Sums of a few hundred numbers of 24 bits; the area of an ellipsoid goes through a power.
        let tolerance = 3.0e-5;
        let trace = xx + yy + zz;
        let size = (trace / mass).sqrt();
        let off_inertia = [i.xx - xx, i.yy - yy, i.zz - zz, i.xy - xy, i.xz - xz, i.yz - yz]
            .into_iter()
            .fold(0.0_f32, |m, d| m.max(d.abs()))
            / trace;
        let off_center = (center - Vec3::from([x, y, z])).length() / size.max(x.abs());
        let off = [(own / mass - 1.0).abs(), off_center, off_inertia];
        if !off.iter().all(|o| *o < tolerance) {
            wrong.push(format!("{line}: {own} kg, off by {off:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
