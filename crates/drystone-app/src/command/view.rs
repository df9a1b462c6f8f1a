//! `drystone view`: a window on a scene.

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use drystone::threads::Executor;
use drystone_scene::{gltf, obj};
use drystone_view::overlay::{Overlays, Tint};
use drystone_view::sim::Opened;
use drystone_view::{Options, show};

use crate::cli::{AutoColliders, Overlay, Reading, Source, View};
use crate::load::{Loaded, build, load_with};
use crate::output::{Failure, Outcome, has_extension};
use crate::render::quiet_driver;
use crate::settings::{cores_but, executor};

/// Largest file that the window opens [bytes]: a larger one would fill the memory.
const MOST_BYTES: u64 = 1 << 29;

/// Opens a window on a scene; returns when it is closed.
pub(crate) fn view(args: &View) -> Outcome {
    quiet_driver();
    // One core is left to the window.
    let executor = executor(args.threads.map_or_else(|| cores_but(1), usize::from));
    let opened = open(args, &args.source, &executor)?;
    let on = |overlay| args.overlays.contains(&overlay);
    let overlays = Overlays {
        contacts: on(Overlay::Contacts),
        friction: on(Overlay::Friction),
        colors: on(Overlay::Colors),
        joints: on(Overlay::Joints),
        limits: on(Overlay::Limits),
        bounds: on(Overlay::Bounds),
        colliders: on(Overlay::Colliders),
        centers: on(Overlay::Centers),
        velocities: on(Overlay::Velocities),
        sleeping: on(Overlay::Asleep),
        tint: match (on(Overlay::Islands), on(Overlay::Levels)) {
            (true, _) => Tint::Island,
            (_, true) => Tint::Level,
            _ => Tint::Own,
        },
    };
    let again = args.clone();
    let open = Box::new(move |scene: &str| {
        let is = |endings: &[&str]| has_extension(Path::new(scene), endings);
        // A file that is dropped and has no physics falls, as it does in a browser.
        let hulls = AutoColliders::Hull;
        let auto_colliders = is(&["gltf", "glb", "obj"])
            .then(|| again.source.reading.auto_colliders.unwrap_or(hulls));
        let robot = is(&["urdf"]);
        let (base, ground) = if robot {
            (again.source.reading.base, again.source.reading.ground)
        } else {
            (None, None)
        };
        let reading = Reading { auto_colliders, base, ground, strict: false, reduced: false };
        let source = Source { scene: scene.to_owned(), reading };
        open(&again, &source, &executor).map_err(|e| e.to_string())
    });
    let options = Options { opened, open, playing: !args.paused, overlays, panel: None };
    show(options).map_err(Failure::failed)?;
    Ok(ExitCode::SUCCESS)
}

/// Opens a scene, with the settings that the command line has for all scenes.
fn open(args: &View, source: &Source, executor: &Arc<dyn Executor>) -> Result<Opened, Failure> {
    let size = std::fs::metadata(Path::new(&source.scene)).map_or(0, |m| m.len());
    if size > MOST_BYTES {
        return Err(Failure::failed(format_args!(
            "{}: has {} MB, the maximum is {} MB",
            source.scene,
            size >> 20,
            MOST_BYTES >> 20
        )));
    }
    let mut loaded = load_with(source, &args.settings)?;
    if !args.film {
        loaded.read_visuals();
    } else {
        loaded = match loaded {
            Loaded::Gltf(file) => {
                Loaded::BuiltIn(Box::new(gltf::film(*file).map_err(Failure::failed)?))
            }
            Loaded::Obj(file) => {
                return Err(Failure::failed(obj::no_film(&file.scene.name)));
            }
            Loaded::BuiltIn(_) | Loaded::Read(_) | Loaded::Own(..) => {
                return Err(Failure::usage(format_args!(
                    "--film is for glTF files; {} is none",
                    source.scene
                )));
            }
        };
    }
    let scene = loaded.scene();
    let hz = args.settings.hz.unwrap_or(scene.hz);
    let mut running = build(scene, &source.scene)?;
    running.world.set_executor(Arc::clone(executor));
    let name = match &loaded {
        // With its parameters.
        Loaded::BuiltIn(_) => source.scene.trim().to_owned(),
        Loaded::Read(_) | Loaded::Own(..) | Loaded::Gltf(_) | Loaded::Obj(_) => scene.name.clone(),
    };
    let notes = scene.notes.clone();
    Ok(Opened { name, running, hz, notes })
}
