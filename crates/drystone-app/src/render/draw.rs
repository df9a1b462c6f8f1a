//! `--render`: the last picture of a run, or all of it as a film.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use drystone::World;
use drystone_render::{Canvas, Follow, Gatherer, Look, Picture, RenderError, Subject};
use drystone_scene::Running;
use drystone_scene::visual::Visuals;

use super::camera::CameraSpec;
use super::encode::{self, Encoder, Kind};
use super::wanted::Wanted;
use crate::output::Failure;

/// A picture or a film being made.
pub(crate) struct Render {
    path: PathBuf,
    camera: CameraSpec,
    canvas: Canvas,
    gatherer: Gatherer,
    /// The subject of the picture at the start, which a film always keeps in view.
    start: Subject,
    follow: Follow,
    /// Frames a second and the file, of a film.
    film: Option<(f64, Encoder)>,
    /// Frames of the film so far.
    frames: u64,
    /// Length of the run [s].
    seconds: f64,
    /// The visuals of bodies, and whether collision shapes are drawn in their place.
    look: (Arc<Visuals>, bool),
}

impl Render {
    /// Opens the device and the file. `running` is as the run begins, `seconds` how long it will
    /// be, `hz` its steps a second.
    pub(crate) fn create(
        path: &Path,
        camera: CameraSpec,
        wanted: Wanted,
        running: &Running,
        seconds: f64,
        hz: f32,
    ) -> Result<Self, Failure> {
        let kind = Kind::of(path).ok_or_else(|| Failure::usage("--render: no known kind"))?;
        let (width, height) = wanted.size.unwrap_or_else(|| kind.usual_size());
        let failed = |e: RenderError| failure(path, &e);
        let canvas = Canvas::new(width, height).map_err(failed)?;
        let start = Subject::of(&running.world);
        let (visuals, colliders) = (Arc::clone(&running.visuals), wanted.colliders);
        let aspect = aspect(&canvas);
        let follow = Follow::new(start.clone(), camera.angles(&start), aspect);
        let film = if kind == Kind::Still {
            crate::output::probe(path)?;
            None
        } else {
            // More frames than steps would show some twice.
            let fps = wanted.fps.unwrap_or_else(|| kind.usual_fps()).min(f64::from(hz)).max(0.1);
            Some((fps, Encoder::create(path, kind, (width, height), fps)?))
        };
        let (path, frames) = (path.to_owned(), 0);
        let (look, gatherer) = ((visuals, colliders), Gatherer::default());
        Ok(Self { path, camera, canvas, gatherer, start, follow, film, frames, seconds, look })
    }

    /// Adds the world at `time` [s] to the film, if it is time for another frame.
    pub(crate) fn add(&mut self, time: f64, world: &World) -> Result<(), Failure> {
        while let Some((fps, _)) = self.film {
            // Frames are far fewer than 2^52. A frame is due up to half a frame early: steps and
            // frames that should coincide do so but for rounding.
            #[expect(clippy::cast_precision_loss, reason = "as said")]
            let due = self.frames as f64 / fps;
            if time < due - 1.0e-6 {
                break;
            }
            let picture = self.frame(world, due, 1.0 / fps)?;
            if let Some((_, encoder)) = &mut self.film {
                encoder.add(picture)?;
            }
            self.frames += 1;
        }
        Ok(())
    }

    /// Writes the rest; `world` is as the run ended. Returns the path.
    pub(crate) fn finish(mut self, world: &World) -> Result<PathBuf, Failure> {
        if let Some((_, encoder)) = self.film {
            encoder.finish()?;
            return Ok(self.path);
        }
        let subject = Subject::of(world);
        let camera = self.camera.still(&subject, aspect(&self.canvas));
        let picture = self.draw(world, &subject, &camera)?;
        encode::write_png(&self.path, &picture)?;
        Ok(self.path)
    }

    /// The film's picture at `time` [s], `dt` [s] after the last.
    fn frame(&mut self, world: &World, time: f64, dt: f64) -> Result<Picture, Failure> {
        #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
        let (dt, turn) = (dt as f32, self.camera.turned(time, self.seconds) as f32);
        let camera = self.follow.next(world, dt, turn);
        let camera = self.camera.placed(camera);
        let subject = self.start.clone();
        self.draw(world, &subject, &camera)
    }

    fn draw(
        &mut self,
        world: &World,
        subject: &Subject,
        camera: &drystone_render::Camera,
    ) -> Result<Picture, Failure> {
        let (visuals, colliders) = (Some(&self.look.0), self.look.1);
        let look = Look { visuals, colliders, ..Look::default() };
        let drawing = self.gatherer.gather(world, subject, &look);
        self.canvas.draw(&drawing, camera).map_err(|e| failure(&self.path, &e))
    }
}

/// Starts the program again with a folder for the run time of the display's programs, if there is
/// none. Mesa's software renderer looks there for a display even to draw without one, and prints
/// two errors that are none.
pub(crate) fn quiet_driver() {
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::process::CommandExt;
        const FOLDER: &str = "XDG_RUNTIME_DIR";
        if std::env::var_os(FOLDER).is_none()
            && let Ok(program) = std::env::current_exe()
        {
            let mut again = std::process::Command::new(program);
            again.args(std::env::args_os().skip(1)).env(FOLDER, std::env::temp_dir());
            // It only comes back if that failed; then there are two lines too many.
            let _ = again.exec();
        }
    }
}

fn failure(path: &Path, e: &RenderError) -> Failure {
    Failure::failed(format_args!("{}: {e}", path.display()))
}

#[expect(clippy::cast_precision_loss, reason = "sizes are far below 2^24")]
fn aspect(canvas: &Canvas) -> f32 {
    let (width, height) = canvas.size();
    width as f32 / height as f32
}
