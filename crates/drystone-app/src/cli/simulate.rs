//! Commands that run a scene: `simulate`, `replay`.

use std::path::PathBuf;

use clap::Args;

use super::parse::{bake_path, fps, render_path, size};
use super::source::{Length, Reading, Settings, Workers};
use crate::render::{CameraSpec, Wanted};

const SIMULATE_EXAMPLES: &str = "\
Examples:
  drystone simulate pyramid --bake pyramid.glb
  drystone simulate stack:n=20,top_mass_ratio=100 --seconds 30
  drystone simulate scene.glb --hz 120 --trace motion.csv --events events.jsonl
  drystone simulate mesh.glb --auto-colliders hull --bake out.glb
  drystone simulate wall:ball=1 --render wall.png
  drystone simulate wall:ball=1 --seconds 2 --snapshot wall.run
  drystone simulate --resume wall.run --seconds 3 --trace later.csv
  drystone simulate washer --render washer.mp4 --camera turntable --size 1920x1080

Exit status:
  0  done
  1  the scene cannot be read or is invalid, or an output cannot be written
  2  wrong usage
  3  done, but a fault was reported (a body left the finite numbers and was set aside)

Files have their names when they are whole; until then they are .NAME.partial beside. Ctrl-C ends the run early
with whole files. Pipes and /dev/stdout are written step by step. The last line of events has the type end;
a trace has no such line.

The result depends on the scene and on --hz, --substeps, --method and --set alone: never on threads,
instruction set, machine, or on which outputs were asked for.";

/// `drystone simulate`.
#[derive(Args, Debug)]
#[command(after_help = SIMULATE_EXAMPLES)]
pub(crate) struct Simulate {
    /// A built-in scene (`drystone scenes`) with parameters such as pyramid:base=40, or a .gltf,
    /// .glb, .obj, .urdf, .xml (MJCF) or .json (drystone, Rigid-IPC) file; with --resume it may be
    /// left out
    #[arg(required_unless_present = "resume")]
    pub(crate) scene: Option<String>,

    /// How it is read.
    #[command(flatten)]
    pub(crate) reading: Reading,

    /// How long.
    #[command(flatten)]
    pub(crate) length: Length,

    /// Settings of the world.
    #[command(flatten)]
    pub(crate) settings: Settings,

    /// Workers that step it.
    #[command(flatten)]
    pub(crate) workers: Workers,

    /// Write the trajectory, one line a body and step
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) trace: Option<PathBuf>,

    /// Write only every K-th step to the trace
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) every: u64,

    /// Write what happened, one JSON object a line; the last one, of type end, says that none is
    /// missing
    #[arg(long, value_name = "FILE.jsonl")]
    pub(crate) events: Option<PathBuf>,

    /// Write the scene with its motion as glTF animations (.glb or .gltf)
    #[arg(long, value_name = "FILE.glb", value_parser = bake_path)]
    pub(crate) bake: Option<PathBuf>,

    /// Pictures and films.
    #[command(flatten)]
    pub(crate) rendering: Rendering,

    /// Write measurements: times, contacts, energy, penetration, hashes, an audit of the end
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,

    /// Write the whole world as it is at the end, for --resume
    #[arg(long, value_name = "FILE")]
    pub(crate) snapshot: Option<PathBuf>,

    /// Go on from a snapshot, for the further --seconds or --steps: every bit is as if the run had
    /// not been interrupted. SCENE may be left out; it must be the one that the snapshot came from.
    /// The world keeps its settings, except those that --hz, --substeps, --method and --set change
    #[arg(long, value_name = "FILE")]
    pub(crate) resume: Option<PathBuf>,

    /// Write a log of the run that `drystone replay` runs again and compares, step by step
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,

    /// Report how exact the world is at the end: energy and where it came from and went, momentum,
    /// overlaps, friction, residuals of contacts, awake bodies and why. Steps take longer, because
    /// this keeps a ledger
    #[arg(long)]
    pub(crate) audit: bool,
}

const REPLAY_EXAMPLES: &str = "\
Examples:
  drystone simulate wrecking_ball --record run.log
  drystone replay run.log
  drystone replay run.log --threads 1 --simd scalar

Exit status:
  0  every step came to the same bits
  1  one did not: its number, the stage and the body are told; or the log cannot be read
  2  wrong usage";

/// `drystone replay`.
#[derive(Args, Debug)]
#[command(after_help = REPLAY_EXAMPLES)]
pub(crate) struct Replay {
    /// A recording that `simulate --record` wrote, or a journal of calls that a program wrote
    /// (`drystone::journal::Journal`)
    pub(crate) log: PathBuf,

    /// Workers that step it.
    #[command(flatten)]
    pub(crate) workers: Workers,
}

/// `--render` and its options.
#[derive(Args, Debug)]
pub(crate) struct Rendering {
    /// Draw the end of the run as a .png, or the run as a film: .mp4, .webm, .mkv or .mov (by
    /// ffmpeg), .gif, or numbered pictures such as frame-%04d.png
    #[arg(long, value_name = "FILE", value_parser = render_path)]
    pub(crate) render: Option<PathBuf>,

    /// Size of the picture [default: 1280x720, of a GIF 640x360]
    #[arg(long, value_name = "WxH", value_parser = size, requires = "render")]
    pub(crate) size: Option<(u32, u32)>,

    /// Where it is taken from: front, back, left, right, top, turntable, or yaw=DEGREES,
    /// pitch=DEGREES, zoom=FACTOR, turn=DEGREES_A_SECOND, eye=X:Y:Z, at=X:Y:Z, fov=DEGREES; several
    /// separated by commas [default: where all that moves is in the picture]
    #[arg(
        long,
        value_name = "SPEC",
        requires = "render",
        default_value = "auto",
        hide_default_value = true
    )]
    pub(crate) camera: CameraSpec,

    /// Draw collision shapes, also of bodies that a glTF file gives another look
    #[arg(long, requires = "render")]
    pub(crate) colliders: bool,

    /// Frames a second of a film, at most one a step [default: 30, of a GIF 25]
    #[arg(long, value_name = "F", value_parser = fps, requires = "render")]
    pub(crate) fps: Option<f64>,
}

impl Rendering {
    /// The look of the pictures.
    pub(crate) fn wanted(&self) -> Wanted {
        Wanted { size: self.size, colliders: self.colliders, fps: self.fps }
    }
}
