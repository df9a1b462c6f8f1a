//! The own format: a scene as JSON that people can write, with a version and a schema
//! (`docs/format.md`).
//!
//! Names and defaults of fields are those of the engine's definitions. A scene that is written and
//! read again is the same, bit by bit. Parts of a scene may be other files, of any format that is
//! read.
//!
//! ```
//! use std::path::Path;
//!
//! use drystone_scene::own;
//!
//! let text = r#"{
//!   "drystone": 1,
//!   "bodies": [
//!     {"name": "ground", "kind": "static", "shapes": [{"half_space": {}}]},
//!     {"name": "ball", "position": [0, 4, 0], "shapes": [{"sphere": {"radius": 0.5}}]}
//!   ]
//! }"#;
//! let scene = own::from_text(text, "ball", Path::new(""))?;
//! assert_eq!(scene.bodies[1].name, "ball");
//! assert_eq!(own::from_text(&own::to_text(&scene)?, "ball", Path::new(""))?.bodies.len(), 2);
//! # Ok::<(), drystone_scene::SceneError>(())
//! ```

mod document;
mod kind;
mod locate;
mod place;
mod print;
mod read;
mod saved_hull;
mod text;
mod value;
mod write;

use std::io::Write as _;
use std::path::Path;

use self::document::Document;
use crate::bake::Unsaid;
use crate::error::SceneError;
use crate::file::{Ending, Kind, WholeFile};
use crate::scene::Scene;

pub use self::kind::{JsonKind, kind_of};
pub use self::locate::refused;
pub use self::read::Options;
pub use self::text::VERSION;

/// Reads a file of this format.
///
/// # Errors
/// A line that names the file, the line and field in it, what is wrong and what is allowed.
pub fn load(path: &Path, options: &Options) -> Result<Scene, SceneError> {
    read::load(path, options)
}

/// Reads a scene called `name`, if it says no other name, from a text whose paths start from
/// `folder`.
///
/// # Errors
/// A line that names the line and field in the text, what is wrong and what is allowed.
pub fn from_text(text: &str, name: &str, folder: &Path) -> Result<Scene, SceneError> {
    read::from_text(text, name, folder, &Options::default())
}

/// A scene as a text of this format. Reading it gives the same scene, bit by bit, but for
/// [`Scene::notes`] and [`Scene::visuals`], which a text does not hold.
///
/// # Errors
/// Scenes that no file can hold: a film, two bodies of one name, names that something else has.
pub fn to_text(scene: &Scene) -> Result<String, SceneError> {
    text_with(scene, None)
}

fn text_with(scene: &Scene, visuals: Option<&str>) -> Result<String, SceneError> {
    let mut document = write::document(scene)?;
    document.visuals = visuals.map(str::to_owned);
    print::pretty(&document).map_err(|e| SceneError::new(Path::new(""), "", e, ""))
}

/// Writes a scene as a file of this format, which has its name when it is whole. `visuals` is the
/// path, from the file's folder, of the glTF file that it was read from, which says what its bodies
/// look like.
///
/// # Errors
/// The errors of [`to_text`]; a file that cannot be written, or would be larger than what is read.
pub fn save(path: &Path, scene: &Scene, visuals: Option<&str>) -> Result<Ending, SceneError> {
    let text = text_with(scene, visuals).map_err(|e| e.in_file(path))?;
    let most = Kind::Text.most();
    if text.len() as u64 > most {
        let problem = format!("it would have {} bytes", text.len());
        return Err(SceneError::new(path, "", problem, "up to 200 MB, which is what is read"));
    }
    let written = WholeFile::create(path).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.finish()
    });
    written.map_err(|e| SceneError::new(path, "", format!("cannot be written: {e}"), ""))
}

/// Lists the things that a file of this format does not hold of a glTF file, unless it names that
/// file. The glTF file has `animations`, and is read as `scene` with [`Scene::visuals`].
#[must_use]
pub fn unsaid(scene: &Scene, animations: usize) -> Vec<Unsaid> {
    let visuals = &scene.visuals;
    let placed = visuals.worn.values().map(Vec::len).sum::<usize>() + visuals.scenery.len();
    let all = [
        ("a mesh to look at", placed),
        ("a material to look at", if placed > 0 { visuals.materials.len() } else { 0 }),
        ("an animation", animations),
    ];
    let all = all.map(|(what, count)| Unsaid { what: what.to_owned(), count });
    all.into_iter().filter(|unsaid| unsaid.count > 0).collect()
}

/// The JSON schema of the format, as `docs/scene.schema.json` has it.
#[must_use]
pub fn schema() -> String {
    let schema = schemars::schema_for!(Document);
    let mut text = serde_json::to_string_pretty(&schema).expect("a schema is JSON");
    text.push('\n');
    text
}
