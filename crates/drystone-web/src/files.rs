//! The scenes that can be opened: the catalog, and the file that was dropped last.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use drystone_scene::gltf::{self, AutoColliders};
use drystone_scene::obj;
use drystone_view::sim::Opened;

/// A file that was dropped on the page.
struct File {
    name: String,
    /// Its bytes, or the reason it cannot be opened.
    bytes: Result<Vec<u8>, String>,
    /// Plays its animations.
    film: bool,
}

static LAST: Mutex<Option<File>> = Mutex::new(None);

/// Stores a file that was dropped, in place of the previous one.
pub(crate) fn keep(name: &str, bytes: Result<Vec<u8>, String>, film: bool) {
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    *last = Some(File { name: name.to_owned(), bytes, film });
}

/// Opens the file that was dropped last, or a scene of the catalog.
pub(crate) fn open(name: &str) -> Result<Opened, String> {
    let last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    let scene = match &*last {
        Some(file) if file.name == name => match &file.bytes {
            Ok(bytes) => read(name, bytes, file.film)?,
            Err(why) => return Err(format!("{name}: {why}")),
        },
        _ => drystone_scene::named(name).map_err(|e| e.to_string())?,
    };
    let running = scene.build().map_err(|e| format!("{name}: {e}"))?;
    Ok(Opened { name: name.to_owned(), running, hz: scene.hz, notes: scene.notes })
}

fn read(name: &str, bytes: &[u8], film: bool) -> Result<drystone_scene::Scene, String> {
    // Bodies from a file without physics get colliders, and gravity.
    let options = gltf::Options { auto_colliders: Some(AutoColliders::Hull), gravity: None };
    let is_obj = Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
    let scene = if is_obj {
        obj::from_slice(bytes, name, &options).and_then(|mut loaded| {
            if film {
                return Err(obj::no_film(name));
            }
            loaded.read_visuals();
            Ok(loaded.scene)
        })
    } else {
        gltf::from_slice(bytes, name, Path::new(""), &options).and_then(|mut loaded| {
            if film {
                return gltf::film(loaded);
            }
            loaded.read_visuals();
            Ok(loaded.scene)
        })
    };
    scene.map_err(|e| e.to_string())
}
