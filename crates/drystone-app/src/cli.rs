//! The command line.

mod measure;

use std::fmt::Display;
use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use drystone::method::Method;
use drystone::threads::SimdLevel;
use serde::{Deserialize, Serialize};

use crate::render::{CameraSpec, RenderKind};

pub(crate) use self::measure::{Bench, Compare, Validate};

const EXAMPLES: &str = "\
Examples:
  drystone simulate pyramid --bake pyramid.glb
  drystone simulate pyramid:base=40 --seconds 20 --threads 4
  drystone simulate scene.gltf --trace motion.csv --every 6 --report report.json
  drystone simulate scene.gltf --set gravity=0,-1.62,0 --set sleep.enabled=false
  drystone simulate wall:ball=1 --render wall.mp4
  drystone view wall:ball=1
  drystone info scene.gltf
  drystone bench --scene large_pyramid,washer --threads 1,2
  drystone compare stack --with soft-step --with sequential-impulses:method.sweeps=20
  drystone validate --short
  drystone convert robot.urdf robot.json
  drystone scenes";

/// A 3D rigid-body physics engine: simulates a scene and writes what happened.
#[derive(Debug, Parser)]
#[command(name = "drystone", version, about, after_help = EXAMPLES)]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What the program can do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Simulate a scene and report what happened
    Simulate(Box<Simulate>),
    /// Open a window on a scene: watch it, stop it, turn time back, pull and shoot at it
    View(View),
    /// Run again what was recorded, and tell where it comes to something else
    Replay(Replay),
    /// Measure how long a step takes: the mean of each run, its median over runs
    Bench(Bench),
    /// Run one scene by several methods and settings, side by side
    Compare(Compare),
    /// List the built-in scenes: name, bodies, what each shows, its parameters
    Scenes,
    /// List the stepping methods
    Methods,
    /// Tell what was understood of a scene, and what was ignored and why
    Info(Info),
    /// Write a scene as a file: of the own format, or glTF with physics
    Convert(Convert),
    /// Run the tests with a known result and print how far off each is
    Validate(Validate),
}

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

/// Which scene.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Source {
    /// A built-in scene (`drystone scenes`) with parameters such as pyramid:base=40, or a .gltf,
    /// .glb, .obj, .urdf, .xml (MJCF) or .json (drystone, Rigid-IPC) file
    pub(crate) scene: String,

    /// How it is read.
    #[command(flatten)]
    pub(crate) reading: Reading,
}

/// How a file is read.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Reading {
    /// For files without physics: every mesh becomes a dynamic body with this collider, the lowest
    /// a static one
    #[arg(long, value_name = "KIND")]
    pub(crate) auto_colliders: Option<AutoColliders>,

    /// For .urdf files: whether the world holds the first link [default: auto, which holds the base of an arm
    /// and lets what stands on several legs or wheels go]
    #[arg(long, value_name = "KIND")]
    pub(crate) base: Option<Base>,

    /// For .urdf files: adds a ground at this height [m]
    #[arg(long, value_name = "Z", num_args = 0..=1, default_missing_value = "0", allow_negative_numbers = true, value_parser = height)]
    pub(crate) ground: Option<f32>,
}

/// What a robot's first link hangs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
pub(crate) enum Base {
    /// As its joints look
    Auto,
    /// The world
    Fixed,
    /// Nothing
    Floating,
}

fn height(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|z| z.abs() <= 1.0e6);
    number.ok_or_else(|| "expected a height within ±1e6 m".to_owned())
}

/// What a mesh without physics collides as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
pub(crate) enum AutoColliders {
    /// Its convex hull
    Hull,
    /// Itself
    Mesh,
    /// The box around it
    Box,
}

/// How long to simulate.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Length {
    /// How long to simulate [default: the scene's own length, else 10]
    #[arg(long, value_name = "S", value_parser = seconds, conflicts_with = "steps")]
    pub(crate) seconds: Option<f64>,

    /// How long to simulate, in steps
    #[arg(long, value_name = "N")]
    pub(crate) steps: Option<u64>,
}

/// What is said of the world, over what the scene says.
#[derive(Args, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Settings {
    /// Steps per second [default: the scene's own, else 60]
    #[arg(long, value_name = "F", value_parser = hz)]
    pub(crate) hz: Option<f32>,

    /// Solver substeps per step [default: the method's own]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub(crate) substeps: Option<u32>,

    /// Stepping method (`drystone methods` tells about them) [default: the scene's own, else
    /// soft-step]
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(Method::NAMES))]
    pub(crate) method: Option<String>,

    /// A field of the world's configuration, such as gravity=0,-1.62,0 or contact.hertz=60;
    /// repeatable
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment)]
    pub(crate) set: Vec<(String, String)>,
}

/// Who steps a world.
#[derive(Args, Debug)]
pub(crate) struct Workers {
    /// Worker threads, the caller included [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: Option<u16>,

    /// Instruction set to use [default: the machine's best]; the result does not depend on it
    #[arg(long, value_name = "LEVEL", value_parser = simd_levels())]
    pub(crate) simd: Option<String>,
}

/// `drystone info`.
#[derive(Args, Debug)]
pub(crate) struct Info {
    /// Which scene.
    #[command(flatten)]
    pub(crate) source: Source,
}

const CONVERT_EXAMPLES: &str = "\
Examples:
  drystone convert pyramid:base=5 pyramid.json
  drystone convert robot.urdf robot.glb
  drystone convert scene.json scene.glb --strict
  drystone convert --schema > scene.schema.json

The own format (.json) says all that a scene can say, and reads back to the same bits. Glue, scripts, ropes and other
things that glTF cannot say are named on stderr, one line a kind, and left out.

Exit status:
  0  done
  1  the scene cannot be read or is invalid, OUT cannot be written, or --strict and something cannot be said
  2  wrong usage";

/// `drystone convert`.
#[derive(Args, Debug)]
#[command(after_help = CONVERT_EXAMPLES)]
pub(crate) struct Convert {
    /// A built-in scene with parameters such as pyramid:base=40, or a .gltf, .glb, .obj, .urdf, .xml (MJCF)
    /// or .json (drystone, Rigid-IPC) file
    #[arg(value_name = "IN", required_unless_present = "schema")]
    pub(crate) scene: Option<String>,

    /// The file to write: .json (the own format), .gltf or .glb
    #[arg(value_name = "OUT", required_unless_present = "schema", value_parser = convert_path)]
    pub(crate) out: Option<PathBuf>,

    /// Reading of IN.
    #[command(flatten)]
    pub(crate) reading: Reading,

    /// Settings of its world.
    #[command(flatten)]
    pub(crate) settings: Settings,

    /// Write nothing if OUT cannot say all of IN
    #[arg(long)]
    pub(crate) strict: bool,

    /// Print the JSON schema of the own format
    #[arg(long, conflicts_with_all = ["scene", "out"])]
    pub(crate) schema: bool,
}

const VIEW_EXAMPLES: &str = "\
Examples:
  drystone view pyramid
  drystone view wall:ball=1 --paused --overlays contacts,asleep

Mouse: drag a body to pull it, drag beside it or with the right button to turn the view, shift or the
middle button to move it, the wheel to come nearer; a double click shoots a ball.
Keys: space pauses, arrows step back and on, R restarts, F shows all, S shoots.

Exit status:
  0  the window was closed
  1  the scene cannot be read, or there is no display to open a window on
  2  wrong usage";

/// `drystone view`.
#[derive(Args, Clone, Debug)]
#[command(after_help = VIEW_EXAMPLES)]
pub(crate) struct View {
    /// Which scene.
    #[command(flatten)]
    pub(crate) source: Source,

    /// What the world is like.
    #[command(flatten)]
    pub(crate) settings: Settings,

    /// Worker threads, the caller included [default: all cores but the one that draws]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: Option<u16>,

    /// Stand still at first
    #[arg(long)]
    pub(crate) paused: bool,

    /// Play the animations of a file, such as one that was baked, instead of simulating it
    #[arg(long)]
    pub(crate) film: bool,

    /// What is drawn over bodies at first
    #[arg(long, value_name = "NAME[,NAME...]", value_delimiter = ',')]
    pub(crate) overlays: Vec<Overlay>,
}

/// What can be drawn over bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Overlay {
    /// Points and normals of contacts, longer where they carry more
    Contacts,
    /// Friction of contacts
    Friction,
    /// Contacts in the colors in which they are solved
    Colors,
    /// Centers of mass
    Centers,
    /// Velocities
    Velocities,
    /// A color for each level above what stands fast
    Levels,
    /// Joints
    Joints,
    /// Limits of joints of six axes
    Limits,
    /// Boxes around shapes
    Bounds,
    /// Collision shapes, also of bodies that a glTF file gives another look
    Colliders,
    /// Sleeping bodies dim
    Asleep,
    /// A color for each island
    Islands,
}

/// `drystone simulate`.
#[derive(Args, Debug)]
#[command(after_help = SIMULATE_EXAMPLES)]
pub(crate) struct Simulate {
    /// A built-in scene (`drystone scenes`) with parameters such as pyramid:base=40, or a .gltf,
    /// .glb, .obj, .urdf, .xml (MJCF) or .json (drystone, Rigid-IPC) file; with --resume it may be left out
    #[arg(required_unless_present = "resume")]
    pub(crate) scene: Option<String>,

    /// How it is read.
    #[command(flatten)]
    pub(crate) reading: Reading,

    /// How long.
    #[command(flatten)]
    pub(crate) length: Length,

    /// What the world is like.
    #[command(flatten)]
    pub(crate) settings: Settings,

    /// Who steps it.
    #[command(flatten)]
    pub(crate) workers: Workers,

    /// Write the trajectory, one line a body and step
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) trace: Option<PathBuf>,

    /// Write only every K-th step to the trace
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) every: u64,

    /// Write what happened, one JSON object a line; the last one, of type end, says that none is missing
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

    /// Go on from a snapshot, for the further --seconds or --steps: every bit is as if the run had not
    /// been interrupted. SCENE may be left out; it must be the one that the snapshot came from. The
    /// world is set as it was but for what --hz, --substeps, --method and --set say now
    #[arg(long, value_name = "FILE")]
    pub(crate) resume: Option<PathBuf>,

    /// Write a log of the run that `drystone replay` runs again and compares, step by step
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,

    /// Tell how right the world is at the end: where energy came from and went, momentum, overlaps,
    /// friction, what contacts left unsolved, what is awake and why. Steps take longer with the ledger
    /// that this needs
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
    /// A recording that `simulate --record` wrote, or a journal of calls that a program wrote (`drystone::journal::Journal`)
    pub(crate) log: PathBuf,

    /// Who steps it.
    #[command(flatten)]
    pub(crate) workers: Workers,
}

/// `--render` and what belongs to it.
#[derive(Args, Debug)]
pub(crate) struct Rendering {
    /// Draw the end of the run as a .png, or the run as a film: .mp4, .webm, .mkv or .mov (by ffmpeg),
    /// .gif, or numbered pictures such as frame-%04d.png
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

/// The levels this machine has, by name.
fn simd_levels() -> PossibleValuesParser {
    PossibleValuesParser::new(SimdLevel::available().iter().map(|level| level.name()))
}

/// Parses a number that `fits`; `allowed` says which do.
fn number<T: FromStr>(text: &str, allowed: &str, fits: impl Fn(&T) -> bool) -> Result<T, String> {
    text.trim().parse().ok().filter(fits).ok_or_else(|| format!("expected {allowed}"))
}

fn seconds(text: &str) -> Result<f64, String> {
    number(text, "a number of seconds from 0 to 1e9", |s: &f64| (0.0..=1.0e9).contains(s))
}

fn hz(text: &str) -> Result<f32, String> {
    number(text, "a number of steps per second from 0.001 to 1e6", |hz: &f32| is_rate(*hz))
}

/// True if a world can be stepped so often a second.
pub(crate) fn is_rate(hz: f32) -> bool {
    (1.0e-3..=1.0e6).contains(&hz)
}

fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => {
            Ok((key.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("expected KEY=VALUE, such as sleep.enabled=false".to_owned()),
    }
}

fn bake_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if has_extension(&path, &["glb", "gltf"]) {
        Ok(path)
    } else {
        Err("expected a file name that ends in .glb or .gltf".to_owned())
    }
}

fn convert_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if has_extension(&path, &["json", "glb", "gltf"]) {
        Ok(path)
    } else {
        Err("expected a file name that ends in .json (the own format), .glb or .gltf".to_owned())
    }
}

fn render_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if RenderKind::of(&path).is_some() {
        Ok(path)
    } else {
        Err("expected a file name that ends in .png, .gif, .mp4, .webm, .mkv or .mov; of numbered \
             pictures with one number such as %04d"
            .to_owned())
    }
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.trim().parse().ok().filter(|n| (1..=16384).contains(n));
    let parts = text.split_once(['x', 'X', '×']);
    parts
        .and_then(|(width, height)| Some((side(width)?, side(height)?)))
        .ok_or_else(|| "expected a size from 1x1 to 16384x16384, such as 1280x720".to_owned())
}

fn fps(text: &str) -> Result<f64, String> {
    number(text, "a number of frames per second from 0.1 to 240", |f: &f64| {
        (0.1..=240.0).contains(f)
    })
}

/// True if the path ends in one of these extensions, in any case.
pub(crate) fn has_extension(path: &std::path::Path, extensions: &[&str]) -> bool {
    path.extension().is_some_and(|e| extensions.iter().any(|known| e.eq_ignore_ascii_case(known)))
}

/// `n thing` or `n things`.
pub(crate) fn count(n: impl Display, thing: &str) -> String {
    let n = n.to_string();
    match thing {
        _ if n == "1" => format!("1 {thing}"),
        "body" => format!("{n} bodies"),
        _ => format!("{n} {thing}s"),
    }
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::{Cli, Command};

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        for bad in [
            "--hz 0",
            "--hz -1",
            "--hz nan",
            "--hz inf",
            "--hz 1e-30",
            "--seconds -1",
            "--seconds nan",
            "--seconds inf",
            "--steps -1",
            "--steps 1.5",
            "--every 0",
            "--threads 0",
            "--threads 257",
            "--substeps 0",
            "--substeps 257",
            "--set x",
            "--set =1",
            "--method x",
            "--simd x",
            "--bake x.obj",
            "--seconds 1 --steps 1",
            "--every 2 --snapshot",
        ] {
            let line = format!("drystone simulate hello {bad}");
            let result = Cli::try_parse_from(line.split(' '));
            assert_eq!(result.unwrap_err().exit_code(), 2, "{bad}");
        }
        for bad in
            ["--threads 0", "--threads 1,", "--threads 1,x", "--runs 0", "--steps 1", "hello"]
        {
            let line = format!("drystone bench {bad}");
            let result = Cli::try_parse_from(line.split(' '));
            assert_eq!(result.unwrap_err().exit_code(), 2, "{bad}");
        }
        let good = "drystone simulate hello --hz 0.5 --seconds 0 --every 3 --set a=b=c --set d=";
        let Command::Simulate(args) = Cli::try_parse_from(good.split(' ')).unwrap().command else {
            panic!("another command");
        };
        assert_eq!(args.settings.set[0], ("a".to_owned(), "b=c".to_owned()));
    }

    #[cfg(feature = "render")]
    #[test]
    fn pictures_that_cannot_be_are_refused() {
        for bad in [
            "--render x.jpg",
            "--render x",
            "--render x.png --size 0x1",
            "--render x.png --size 10",
            "--render x.png --size 99999x1",
            "--render x.png --camera behind",
            "--render x.gif --fps 0",
            "--size 10x10",
            "--camera front",
        ] {
            let line = format!("drystone simulate hello {bad}");
            let result = Cli::try_parse_from(line.split(' '));
            assert_eq!(result.unwrap_err().exit_code(), 2, "{bad}");
        }
    }
}
