//! The picture and the numbers that the window gets.

use std::sync::{Arc, Mutex};

use drystone::{Vec3, WorldConfig, WorldCounts};
use drystone_render::{Drawing, Subject};

use crate::picked::Picked;
use crate::side::Sample;

/// One of the runs that are shown.
#[derive(Clone, Debug)]
pub struct View {
    /// The picture.
    pub drawing: Drawing,
    /// How many of everything there are.
    pub counts: WorldCounts,
    /// The settings.
    pub config: WorldConfig,
    /// Steps since the last picture.
    pub samples: Vec<Sample>,
    /// The world's hash, while it stands still.
    pub hash: Option<u64>,
}

/// The pictures and numbers that the window shows.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The scene's name.
    pub name: String,
    /// How many scenes were opened before this one.
    pub scene: u64,
    /// One run, or two side by side.
    pub views: Vec<View>,
    /// The subject of the picture.
    pub subject: Arc<Subject>,
    /// Steps taken.
    pub step: u64,
    /// The last step that was reached.
    pub furthest: u64,
    /// The last step of a film.
    pub film: Option<u64>,
    /// Length of a step [s].
    pub dt: f32,
    /// Whether the world runs.
    pub playing: bool,
    /// The pull of the mouse: from where on the body to where it is pulled [m, world].
    pub held: Option<(Vec3, Vec3)>,
    /// Answers to [`super::Command::Grab`] so far: how many, and whether the last one met a body.
    pub grabs: (u64, bool),
    /// The body that is looked at.
    pub picked: Option<Picked>,
    /// A message for the user.
    pub message: Option<String>,
    /// Parts of the scene's file that were left out, a line each.
    pub notes: Arc<[String]>,
}

/// The newest picture, until the window takes it.
pub type Slot = Arc<Mutex<Option<Shown>>>;
