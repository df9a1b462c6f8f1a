//! `drystone convert`: a scene as a file of another format.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use drystone_scene::bake::{self, Unsaid};
use drystone_scene::own;

use crate::cli::{Convert, Source};
use crate::load::{Loaded, build, load_with};
use crate::output::{self, Failure, Outcome, has_extension, one_line};
use crate::report::measure::lines_of;
use crate::report::page::count;

/// Writes a scene as a file.
pub(crate) fn convert(args: &Convert) -> Outcome {
    let (Some(scene), Some(out)) = (&args.scene, &args.out) else {
        output::print(&own::schema())?;
        return Ok(ExitCode::SUCCESS);
    };
    let source = Source { scene: scene.clone(), reading: args.reading };
    let mut loaded = load_with(&source, &args.settings)?;
    if let Some(hz) = args.settings.hz {
        loaded.scene_mut().hz = hz;
    }
    // A scene that cannot be simulated is not written either.
    build(loaded.scene(), scene)?;
    let is_own = has_extension(out, &["json"]);
    if is_own {
        loaded.read_visuals();
    }
    let settings = &args.settings;
    let is_told = settings.hz.is_some()
        || settings.substeps.is_some()
        || settings.method.is_some()
        || !settings.set.is_empty()
        || args.reading.auto_colliders.is_some();
    let visuals = if is_own { visuals(&loaded, Path::new(scene), out) } else { None };
    // The document of a glTF file goes over as it is, and so do the meshes of an .obj file.
    let is_whole = !is_own && !is_told && matches!(loaded, Loaded::Gltf(_) | Loaded::Obj(_));
    let mut unsaid = match &loaded {
        Loaded::Gltf(file) if !is_whole && visuals.is_none() => {
            own::unsaid(&file.scene, file.animations())
        }
        Loaded::Obj(file) if !is_whole && visuals.is_none() => own::unsaid(&file.scene, 0),
        _ => Vec::new(),
    };
    if !is_own && !is_whole {
        unsaid.extend(bake::unsaid(loaded.scene()));
    }
    for Unsaid { what, count: often } in &unsaid {
        let often = count(*often, "time");
        let line = one_line(&format!("{}: left out: {what}, {often}", out.display()));
        // There is nowhere to report a failure of stderr.
        let _ = writeln!(io::stderr().lock(), "{line}");
    }
    if args.reading.strict && !unsaid.is_empty() {
        let kinds = count(unsaid.len(), "kind");
        return Err(Failure::failed(format_args!(
            "{}: {kinds} of things cannot be said in it, and --strict allows none",
            out.display()
        )));
    }
    let written = match &loaded {
        _ if is_own => own::save(out, loaded.scene(), visuals.as_deref()),
        Loaded::Gltf(file) if is_whole => {
            bake::write(out, file, &bake::Motion::still(loaded.scene()))
        }
        Loaded::Obj(file) if is_whole => {
            bake::write_objects(out, file, &bake::Motion::still(loaded.scene()))
        }
        _ => bake::save_scene(out, loaded.scene()),
    };
    output::warn_of(written.map_err(Failure::failed)?, out);
    let scene = loaded.scene();
    let mut text = one_line(&format!(
        "{}: {}, {}",
        out.display(),
        count(scene.bodies.len(), "body"),
        count(scene.joints.len(), "joint"),
    ));
    text.push('\n');
    for note in lines_of(&scene.notes) {
        text.push_str(&format!("note: {note}\n"));
    }
    output::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Path, from the folder of the file to be written, of the file that says what its bodies look
/// like; `None` if that is not beside or below it.
fn visuals(loaded: &Loaded, file: &Path, out: &Path) -> Option<String> {
    let path = match loaded {
        Loaded::Gltf(_) | Loaded::Obj(_) if !loaded.scene().visuals.is_empty() => {
            file.canonicalize().ok()?
        }
        _ => return None,
    };
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
    let beside: PathBuf = path.strip_prefix(folder).ok()?.to_owned();
    let words: Option<Vec<&str>> = beside.components().map(|c| c.as_os_str().to_str()).collect();
    Some(words?.join("/"))
}
