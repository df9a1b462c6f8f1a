//! Commands that show or write a scene: `info`, `convert`, `view`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::parse::convert_path;
use super::source::{Reading, Settings, Source};

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
    /// A built-in scene with parameters such as pyramid:base=40, or a .gltf, .glb, .obj, .urdf,
    /// .xml (MJCF) or .json (drystone, Rigid-IPC) file
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

    /// Settings of the world.
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

    /// Overlays that are drawn over bodies at first
    #[arg(long, value_name = "NAME[,NAME...]", value_delimiter = ',')]
    pub(crate) overlays: Vec<Overlay>,
}

/// Overlays over bodies.
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
