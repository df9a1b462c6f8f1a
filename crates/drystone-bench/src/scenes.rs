//! The scenes, their number of steps, and the first timed step.

use std::path::Path;

use drystone_scene::{CatalogError, Scene, gltf, mjcf, named, urdf};

/// Scenes of Box3D's benchmark: the first step is not timed.
const BOX3D: [&str; 11] = [
    "large_pyramid",
    "many_pyramids",
    "convex_pile",
    "joint_grid",
    "junkyard",
    "washer",
    "rain",
    "trees100",
    "trees50",
    "trees25",
    "large_world",
];

/// Scenes of Jolt's performance test: all steps are timed. Our ragdolls are limp and fall on flat
/// ground. In Jolt's test, motors hold their pose, and they fall on a part of a game's level.
const JOLT: [&str; 5] =
    ["jolt_pyramid", "convex_vs_mesh", "large_mesh", "high_speed", "ragdolls:n=160"];

/// Scenes that measure quality rather than speed.
const QUALITY: [&str; 10] = [
    "stack:n=10",
    "stack:n=30",
    "stack:n=10,top_mass_ratio=100",
    "card_house:thickness=0.01",
    "card_house:thickness=0.02",
    "plank_tower",
    "cradle:pulled=1,gap=0",
    "cradle:pulled=1,gap=0.02",
    "wall",
    "arch",
];

/// The reason a scene cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// The scene is not in the catalog.
    #[error("{spec}: {error}")]
    Catalog {
        /// The scene as the user wrote it.
        spec: String,
        /// The catalog's error.
        error: CatalogError,
    },
    /// A file cannot be read; the error has its name.
    #[error("{0}")]
    File(drystone_scene::SceneError),
    /// The list has nothing between two commas.
    #[error("a scene has no name, expected a list such as stack:n=30,top_mass_ratio=100,washer")]
    Empty,
}

/// Parses a list `S,S,…` into scenes, each with its name as written. Commas also separate
/// parameters: `stack:n=30,top_mass_ratio=100,washer` has two scenes. The names `box3d`, `jolt`,
/// `quality` and `all` are groups of scenes. A name that ends in `.gltf`, `.glb`, `.urdf` or `.xml`
/// is a file.
///
/// # Errors
/// Fails if the catalog does not have a scene, or not with these parameters, or if a file cannot be
/// read.
pub fn expand(list: &str) -> Result<Vec<(String, Scene)>, SceneError> {
    let mut specs: Vec<String> = Vec::new();
    for part in list.split(',').map(str::trim) {
        match specs.last_mut() {
            // A parameter of the previous scene.
            Some(last) if part.contains('=') && !part.contains(':') && last.contains(':') => {
                last.push(',');
                last.push_str(part);
            }
            _ => specs.extend(group(part).into_iter().map(str::to_owned)),
        }
    }
    let scene = |spec: String| match named(&spec) {
        _ if spec.is_empty() => Err(SceneError::Empty),
        Err(_) if is_file(&spec) => match file(Path::new(&spec)) {
            Ok(scene) => Ok((spec, scene)),
            Err(error) => Err(SceneError::File(error)),
        },
        Ok(scene) => Ok((spec, scene)),
        Err(error) => Err(SceneError::Catalog { spec, error }),
    };
    specs.into_iter().map(scene).collect()
}

const FILES: [&str; 4] = ["gltf", "glb", "urdf", "xml"];

fn ending(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

fn is_file(spec: &str) -> bool {
    FILES.contains(&ending(Path::new(spec)).as_str())
}

fn file(path: &Path) -> Result<Scene, drystone_scene::SceneError> {
    match ending(path).as_str() {
        "urdf" => urdf::load(path, &urdf::Options::default()),
        "xml" => mjcf::load(path),
        _ => gltf::load(path, &gltf::Options::default()).map(|loaded| loaded.scene),
    }
}

fn group(name: &str) -> Vec<&str> {
    match name {
        "box3d" => BOX3D.to_vec(),
        "jolt" => JOLT.to_vec(),
        "quality" => QUALITY.to_vec(),
        "all" => [&BOX3D[..], &JOLT, &QUALITY].concat(),
        one => vec![one],
    }
}

/// Default number of measured steps of a scene.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number")]
pub fn default_steps(scene: &Scene) -> u64 {
    ((scene.seconds * scene.hz).round() as u64).max(2)
}

/// Whether the first step, which builds contacts and trees, is timed too.
#[must_use]
pub fn times_first_step(spec: &str) -> bool {
    let name = |spec: &str| spec.split(':').next().unwrap_or_default().trim().to_owned();
    JOLT.iter().any(|scene| name(scene) == name(spec))
}

#[cfg(test)]
mod tests {
    use super::{BOX3D, JOLT, default_steps, expand, times_first_step};

    fn names(list: &str) -> Vec<String> {
        expand(list).unwrap().into_iter().map(|(spec, _)| spec).collect()
    }

    #[test]
    fn a_list_is_taken_apart_at_the_commas_that_separate_scenes() {
        assert_eq!(
            names("stack:n=30,top_mass_ratio=100,pyramid, wall:ball=1"),
            ["stack:n=30,top_mass_ratio=100", "pyramid", "wall:ball=1"]
        );
        assert_eq!(names("jolt,hello"), [&JOLT[..], &["hello"]].concat());
        assert!(names("all").len() > 20);
    }

    #[test]
    fn bad_lists_are_refused_with_a_reason() {
        for (list, reason) in [
            ("", "no name"),
            ("hello,", "no name"),
            ("hello,n=3", "n=3"),
            ("pyramids", "pyramid"),
            ("stack:n=0", "n"),
            ("stack:n=3,m=4", "m"),
        ] {
            let message = expand(list).unwrap_err().to_string();
            assert!(message.contains(reason), "{list}: {message}");
        }
    }

    #[test]
    fn steps_and_the_first_one_are_those_of_the_programs_the_scenes_come_from() {
        let steps = |name: &str| default_steps(&expand(name).unwrap()[0].1);
        assert_eq!(steps("large_pyramid"), 200);
        assert_eq!((steps("many_pyramids"), steps("joint_grid")), (100, 100));
        assert_eq!((steps("convex_pile"), steps("junkyard"), steps("trees50")), (500, 500, 500));
        assert_eq!((steps("washer"), steps("jolt_pyramid"), steps("stack")), (1000, 500, 1200));
        assert!(!BOX3D.iter().any(|name| times_first_step(name)));
        assert!(
            JOLT.iter().all(|name| times_first_step(name)) && times_first_step("high_speed:n=9")
        );
    }
}
