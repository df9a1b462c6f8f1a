//! The scene, the length of its run, its settings and its workers, which several commands take.

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use drystone::method::Method;
use serde::{Deserialize, Serialize};

use super::parse::{assignment, height, hz, seconds, simd_levels};

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

    /// For .urdf files: whether the world holds the first link [default: auto, which holds the base
    /// of an arm and frees a robot on several legs or wheels]
    #[arg(long, value_name = "KIND")]
    pub(crate) base: Option<Base>,

    /// For .urdf files: adds a ground at this height [m]
    #[arg(long, value_name = "Z", num_args = 0..=1, default_missing_value = "0", allow_negative_numbers = true, value_parser = height)]
    pub(crate) ground: Option<f32>,

    /// For .urdf and MJCF files: robots are articulations in reduced coordinates, whose joints are
    /// exact, instead of bodies and joints
    #[arg(long)]
    #[serde(default)]
    pub(crate) reduced: bool,

    /// Refuse a file with physics that is not read (`drystone info` names it). With convert, also
    /// refuse one that OUT cannot say in full
    #[arg(long)]
    #[serde(default)]
    pub(crate) strict: bool,
}

/// The base of a robot's first link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
pub(crate) enum Base {
    /// As its joints look
    Auto,
    /// The world
    Fixed,
    /// Nothing
    Floating,
}

/// The collision shape of a mesh without physics.
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

/// Settings of the world, over those of the scene.
#[derive(Args, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Settings {
    /// Steps per second [default: the scene's own, else 60]
    #[arg(long, value_name = "F", value_parser = hz)]
    pub(crate) hz: Option<f32>,

    /// Solver substeps per step [default: the method's own]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub(crate) substeps: Option<u32>,

    /// Stepping method (`drystone methods` describes them) [default: the scene's own, else
    /// soft-step]
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(Method::NAMES))]
    pub(crate) method: Option<String>,

    /// A field of the world's configuration, such as gravity=0,-1.62,0 or contact.hertz=60;
    /// repeatable
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment)]
    pub(crate) set: Vec<(String, String)>,
}

/// Workers that step a world.
#[derive(Args, Debug)]
pub(crate) struct Workers {
    /// Worker threads, the caller included [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: Option<u16>,

    /// Instruction set to use [default: the machine's best]; the result does not depend on it
    #[arg(long, value_name = "LEVEL", value_parser = simd_levels())]
    pub(crate) simd: Option<String>,
}
