//! Damaged scene files in every format that the scene crate reads. A scene that loads is built and
//! stepped.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use drystone_scene::own::{self, JsonKind};
use drystone_scene::{Running, Scene, SceneError, gltf, mjcf, obj, rigid_ipc, urdf};

use crate::damage;
use crate::finding::{Findings, Kind};
use crate::oracle;
use crate::rng::Rng;
use crate::run::guarded;
use crate::seeds;
use crate::unit::{Places, Unit};

/// Number of steps of a scene that loads.
const STEPS: u32 = 30;

/// Time after which a scene is abandoned.
const LONGEST: Duration = Duration::from_secs(4);

/// The file to damage, and the file to load then: the same, or one that names it.
#[derive(Clone, Debug)]
struct Seed {
    damaged: PathBuf,
    loaded: PathBuf,
}

/// Damages a file and loads it.
#[must_use]
pub fn attack(seed: u64, places: &Places) -> Unit {
    let mut unit = Unit::default();
    let mut rng = Rng::new(seed ^ 0x0f11_e5ee);
    let Some(all) = seeds_in(places) else { return unit };
    let Seed { damaged, loaded } = &all[rng.below(all.len())];
    let Ok(original) = std::fs::read(damaged) else { return unit };
    let mut bytes = original.clone();
    let ending = damaged.extension().and_then(|e| e.to_str()).unwrap_or("");
    change(&mut bytes, ending, &mut rng);
    let is_own = damaged == loaded;
    // A file that another file names keeps its name; all others get a new name.
    let place =
        if is_own { damaged.with_file_name(format!("damaged.{ending}")) } else { damaged.clone() };
    if std::fs::write(&place, &bytes).is_err() {
        return unit;
    }
    unit.tried = 1;
    let load = if is_own { &place } else { loaded };
    let mut findings = Findings::default();
    let reading = rng.below(6);
    match guarded(|| scene_steps(load, reading, &mut findings)) {
        Ok(Some(steps)) => {
            unit.steps = u64::from(steps);
            unit.is_cut = steps < STEPS;
        }
        Ok(None) => unit.refused = 1,
        Err(panic) => findings.add(Kind::Panic, panic.place, panic.message, 0),
    }
    let name = damaged.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    unit.inputs.push((format!("damaged-{name}"), bytes));
    for f in findings.all {
        let detail = format!("{name}: {}", f.detail);
        unit.findings.add(f.kind, format!("a damaged {ending}: {}", f.what), detail, f.step);
    }
    let restored =
        if is_own { std::fs::remove_file(&place) } else { std::fs::write(damaged, original) };
    if restored.is_err() {
        unit.tried = 0;
    }
    unit
}

/// Files to damage, copied into the worker's folder once.
fn seeds_in(places: &Places) -> Option<&'static [Seed]> {
    static SEEDS: OnceLock<Option<Vec<Seed>>> = OnceLock::new();
    SEEDS.get_or_init(|| collect(places).ok().filter(|s| !s.is_empty())).as_deref()
}

fn collect(places: &Places) -> io::Result<Vec<Seed>> {
    let data = places.scratch.join("data");
    // Removes files of an earlier worker. They would be in the list too, and a seed would select
    // another file.
    let _ = std::fs::remove_dir_all(&data);
    copy(&places.root.join("crates/drystone-scene/tests/data"), &data)?;
    let robot = places.root.join("crates/drystone-validate/data/anymal.urdf");
    if robot.is_file() {
        std::fs::copy(robot, data.join("anymal.urdf"))?;
    }
    let own = data.join("own");
    std::fs::create_dir_all(&own)?;
    let mut all = Vec::new();
    for (damaged, loaded) in seeds::write(&own)? {
        all.push(Seed { damaged: own.join(damaged), loaded: own.join(loaded) });
    }
    let mut files = Vec::new();
    list(&data, &mut files)?;
    for file in files {
        let ending = file.extension().and_then(|e| e.to_str()).unwrap_or("");
        if !["gltf", "glb", "urdf", "xml", "json", "obj"].contains(&ending) {
            continue;
        }
        // Adds a binary file with the same JSON, a header and lengths.
        if ending == "gltf" {
            let glb = file.with_extension("glb");
            std::fs::write(&glb, seeds::binary(&std::fs::read(&file)?))?;
            all.push(Seed { damaged: glb.clone(), loaded: glb });
        }
        all.push(Seed { damaged: file.clone(), loaded: file });
    }
    for path in examples(&places.root, &data)? {
        all.push(Seed { damaged: path.clone(), loaded: path });
    }
    let meshes = data.join("rigid-ipc/meshes");
    let fixtures = data.join("rigid-ipc/fixtures");
    for (mesh, fixture) in [
        ("cube.obj", "unit-tests/single-cube.json"),
        ("torus.obj", "chain/3-links.json"),
        ("arch/num_stones=25/stone-01.obj", "friction/arch-25-stones.json"),
    ] {
        all.push(Seed { damaged: meshes.join(mesh), loaded: fixtures.join(fixture) });
    }
    all.retain(|seed| seed.damaged.is_file() && seed.loaded.is_file());
    // The order of a folder's entries depends on the system.
    all.sort_by(|a, b| (&a.damaged, &a.loaded).cmp(&(&b.damaged, &b.loaded)));
    Ok(all)
}

/// Handwritten scenes in drystone's format, and generated files of catalog scenes, some of each
/// kind.
fn examples(root: &Path, data: &Path) -> io::Result<Vec<PathBuf>> {
    let folder = data.join("scenes");
    std::fs::create_dir_all(&folder)?;
    let mut files = Vec::new();
    let scenes = root.join("examples/scenes");
    if scenes.is_dir() {
        copy(&scenes, &folder)?;
        list(&folder, &mut files)?;
        files.retain(|path| path.extension().is_some_and(|e| e == "json"));
    }
    for name in WRITTEN {
        let Ok(scene) = drystone_scene::named(name) else { continue };
        let path = folder.join(format!("{}.json", scene.name));
        if own::save(&path, &scene, None).is_ok() {
            files.push(path);
        }
    }
    Ok(files)
}

/// Small scenes of the catalog, one for each feature of drystone's format.
const WRITTEN: [&str; 10] = [
    "hello",
    "rope:links=10",
    "cloth:n=5,tear=50",
    "dust:n=20",
    "wrecking_ball:bond=1",
    "fracture",
    "gears:n=3",
    "pulley",
    "ragdolls:n=1",
    "convex_vs_mesh",
];

fn copy(from: &Path, to: &Path) -> io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &target)?;
        } else {
            std::fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}

fn list(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder)?.flatten().map(|entry| entry.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            list(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}

/// Damages a file with this extension, sometimes so that its inner data stays reachable.
fn change(bytes: &mut Vec<u8>, ending: &str, rng: &mut Rng) {
    match ending {
        "gltf" if rng.chance(0.4) => payload(bytes, rng),
        "glb" if rng.chance(0.7) => {
            let mut json = seeds::text_of(bytes).to_vec();
            if rng.chance(0.4) {
                payload(&mut json, rng);
            } else {
                damage::text(&mut json, rng);
            }
            *bytes = seeds::binary(&json);
        }
        "png" | "glb" | "stl" | "jpg" => {
            damage::bytes(bytes, rng);
            if ending == "png" && rng.chance(0.8) {
                seeds::mend_png(bytes);
            }
        }
        _ => damage::text(bytes, rng),
    }
}

/// Damages the content of a data URI in a file.
fn payload(bytes: &mut Vec<u8>, rng: &mut Rng) {
    const MARK: &str = ";base64,";
    let Ok(text) = String::from_utf8(bytes.clone()) else { return };
    let places: Vec<usize> = text.match_indices(MARK).map(|(at, _)| at + MARK.len()).collect();
    if places.is_empty() {
        damage::text(bytes, rng);
        return;
    }
    let from = rng.pick(&places);
    let end = text[from..].find('"').map_or(text.len(), |end| from + end);
    let Ok(mut data) = STANDARD.decode(&text[from..end]) else { return };
    damage::bytes(&mut data, rng);
    if data.starts_with(b"\x89PNG") && rng.chance(0.8) {
        seeds::mend_png(&mut data);
    }
    let coded = STANDARD.encode(data);
    *bytes = [&text[..from], &coded, &text[end..]].concat().into_bytes();
}

/// Loads a file like the command, builds it and steps it; `None` if it was refused.
fn scene_steps(path: &Path, reading: usize, findings: &mut Findings) -> Option<u32> {
    let scene = load(path, reading).ok()?;
    let start = Instant::now();
    let mut running = scene.build().ok()?;
    goes_round(&scene, &running, findings);
    for step in 1..=STEPS {
        if running.step(1.0 / 60.0).is_err() {
            return Some(step);
        }
        oracle::quick(&running.world, findings, step);
        if step == STEPS {
            oracle::full(&running.world, findings, step);
            oracle::own_snapshot(&running.world, findings, step);
        }
        if start.elapsed() > LONGEST {
            return Some(step);
        }
    }
    Some(STEPS)
}

/// Checks that a scene written in drystone's format reads back to the same bits, whatever its
/// origin.
fn goes_round(scene: &Scene, running: &Running, findings: &mut Findings) {
    // A damaged file of another format may have duplicate names. Tests cover larger scenes, which
    // are slow.
    if scene.bodies.len() > 200 {
        return;
    }
    let Ok(text) = own::to_text(scene) else { return };
    let again = own::from_text(&text, &scene.name, Path::new(""));
    let built =
        again.map_err(|e| e.to_string()).and_then(|again| again.build().map_err(|e| e.to_string()));
    match built {
        Err(e) => findings.add(Kind::HashDiffers, "what was written is not read", e, 0),
        Ok(built) if built.world.snapshot() != running.world.snapshot() => {
            let what = "what was written reads back to another world";
            findings.add(Kind::HashDiffers, what, scene.name.clone(), 0);
        }
        Ok(_) => {}
    }
}

fn load(path: &Path, reading: usize) -> Result<Scene, SceneError> {
    match path.extension().and_then(|e| e.to_str()).unwrap_or("") {
        "urdf" => {
            let base = [urdf::Base::Auto, urdf::Base::Fixed, urdf::Base::Floating][reading % 3];
            let ground = if reading < 3 { Some(0.0) } else { None };
            urdf::load(path, &urdf::Options { base, ground })
        }
        "xml" => mjcf::load(path),
        "json" => match own::kind_of(path)? {
            JsonKind::Own => own::load(path, &own::Options::with_visuals()),
            _ => rigid_ipc::load(path),
        },
        ending => {
            let kinds =
                [gltf::AutoColliders::Hull, gltf::AutoColliders::Mesh, gltf::AutoColliders::Box];
            let auto_colliders = kinds.into_iter().nth(reading);
            let options = gltf::Options { auto_colliders, gravity: None };
            if ending == "obj" {
                let mut loaded = obj::load(path, &options)?;
                loaded.read_visuals();
                return Ok(loaded.scene);
            }
            let mut loaded = gltf::load(path, &options)?;
            loaded.read_visuals();
            Ok(loaded.scene)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{change, load, payload};
    use crate::rng::Rng;
    use crate::seeds;

    #[test]
    fn all_files_of_our_own_load_as_they_are_written() {
        let folder =
            std::env::temp_dir().join(format!("drystone-attack-test-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        for (_, loaded) in seeds::write(&folder).unwrap() {
            let scene = load(&folder.join(&loaded), 5);
            assert!(scene.is_ok(), "{loaded}: {:?}", scene.err().map(|e| e.to_string()));
            assert!(scene.unwrap().build().is_ok(), "{loaded}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn damage_reaches_what_a_data_uri_holds() {
        let file = br#"{"buffers": [{"uri": "data:x;base64,AAECAwQFBgc="}]}"#.to_vec();
        let changed = (0..20).filter(|i| {
            let mut bytes = file.clone();
            payload(&mut bytes, &mut Rng::new(*i));
            change(&mut bytes, "gltf", &mut Rng::new(*i));
            bytes != file
        });
        assert!(changed.count() > 15);
    }
}
