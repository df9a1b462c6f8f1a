//! A scene in neutral form: the catalog builds it, files are read into it, and every engine of the
//! benchmark gets it. It does not depend on any file format.

mod film;
mod parts;
mod script;

use std::sync::Arc;

use drystone::contact::SurfaceRule;
use drystone::{BodyDef, WorldConfig};

use crate::visual::Visuals;

pub(crate) use self::film::{Between, Keys, Link, Sampler};

pub use self::film::Film;
pub use self::parts::{
    SceneBody, SceneCoupling, SceneFrame, SceneHold, SceneJoint, SceneLink, SceneStrand, SceneTree,
    StrandDef,
};
pub use self::script::{Load, Script, ScriptAction, Wave};

/// A scene.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its name.
    pub name: String,
    /// A summary of the scene, in a line.
    pub summary: String,
    /// Gravity, method and the other settings it is made for.
    pub config: WorldConfig,
    /// Steps a second it is made for.
    pub hz: f32,
    /// How long it is worth simulating [s].
    pub seconds: f32,
    /// Its bodies, in the order in which they are added.
    pub bodies: Vec<SceneBody>,
    /// Its joints, in the order in which they are added.
    pub joints: Vec<SceneJoint>,
    /// Its couplings, added after the joints.
    pub couplings: Vec<SceneCoupling>,
    /// Trees of its bodies in reduced coordinates. They count only if it is `reduced`.
    pub trees: Vec<SceneTree>,
    /// Whether the trees are articulations, in place of their joints; default false.
    pub reduced: bool,
    /// Its particles, in the order in which they are added, after bodies and joints.
    pub strands: Vec<SceneStrand>,
    /// Named places on its bodies.
    pub frames: Vec<SceneFrame>,
    /// Pairs of its bodies, by their numbers, that never collide: see
    /// [`drystone::World::set_bodies_collide`].
    pub never_collide: Vec<[usize; 2]>,
    /// Rules for surfaces of some layers: see [`drystone::World::set_surface_rules`].
    pub surface_rules: Vec<SurfaceRule>,
    /// Rules for the surfaces of two of its bodies, by their numbers: see
    /// [`drystone::World::set_surface_between`].
    pub surfaces_between: Vec<([usize; 2], SurfaceRule)>,
    /// Actions while it runs, besides physics.
    pub script: Script,
    /// Its visuals, if a file has them and they were read.
    pub visuals: Arc<Visuals>,
    /// Parts of a file that were left out, changed or approximated, and why; a line each.
    pub notes: Vec<String>,
    /// Notes that name a part of the file's physics that was left out.
    pub left_out: Vec<String>,
}

impl Scene {
    /// An empty scene with default settings, 60 steps a second, 10 s long.
    #[must_use]
    pub fn new(name: &str, summary: &str) -> Self {
        Self {
            name: name.to_owned(),
            summary: summary.to_owned(),
            config: WorldConfig::default(),
            hz: 60.0,
            seconds: 10.0,
            bodies: Vec::new(),
            joints: Vec::new(),
            couplings: Vec::new(),
            trees: Vec::new(),
            reduced: false,
            strands: Vec::new(),
            frames: Vec::new(),
            never_collide: Vec::new(),
            surface_rules: Vec::new(),
            surfaces_between: Vec::new(),
            script: Script::None,
            visuals: Arc::default(),
            notes: Vec::new(),
            left_out: Vec::new(),
        }
    }

    /// Adds a body; returns its number.
    pub fn add(&mut self, name: impl Into<String>, def: BodyDef) -> usize {
        self.bodies.push(SceneBody { name: name.into(), def });
        self.bodies.len() - 1
    }
}
