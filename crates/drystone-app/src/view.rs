//! `drystone view`: a window on a scene.

use std::process::ExitCode;
use std::sync::Arc;
use std::thread::available_parallelism;

use drystone::{Inline, Team, WorldConfig};
use drystone_view::overlay::Overlays;
use drystone_view::{Options, show};

use crate::Outcome;
use crate::cli::{Overlay, View};
use crate::load::{build, load};
use crate::output::Failure;
use crate::render::quiet_driver;
use crate::simulate::{Settings, configure};

/// Opens a window on a scene; returns when it is closed.
pub(crate) fn view(args: &View) -> Outcome {
    quiet_driver();
    let settings =
        Settings { method: args.method.as_deref(), substeps: args.substeps, set: &args.set };
    let mut config = WorldConfig::default();
    configure(&mut config, &settings)?;
    let says_gravity = args.set.iter().any(|(key, _)| key == "gravity");
    let mut loaded = load(&args.source, says_gravity.then_some(config.gravity))?;
    configure(&mut loaded.scene_mut().config, &settings)?;
    let scene = loaded.scene();
    let hz = args.hz.unwrap_or(scene.hz);
    let mut running = build(scene, &args.source.scene)?;
    // One core is left to the window.
    let free = || available_parallelism().map_or(1, |n| n.get().saturating_sub(1).clamp(1, 256));
    let threads = args.threads.map_or_else(free, usize::from);
    if threads > 1 {
        running.world.set_executor(Arc::new(Team::new(threads)));
    } else {
        running.world.set_executor(Arc::new(Inline));
    }
    let on = |overlay| args.overlays.contains(&overlay);
    let overlays = Overlays {
        contacts: on(Overlay::Contacts),
        joints: on(Overlay::Joints),
        bounds: on(Overlay::Bounds),
        sleeping: on(Overlay::Asleep),
        islands: on(Overlay::Islands),
    };
    let name = scene.name.clone();
    show(Options { name, running, hz, playing: !args.paused, overlays })
        .map_err(Failure::failed)?;
    Ok(ExitCode::SUCCESS)
}
