//! A scene in neutral form: what the catalog builds, what files are read into, what every engine of
//! the benchmark is given.

use std::sync::Arc;

use drystone::breakage::JointStrength;
use drystone::contact::SurfaceRule;
use drystone::joint::SixDof;
use drystone::math::trig;
use drystone::particle::{ClothDef, LinkKind, ParticleDef, RopeDef};
use drystone::{Axis, BodyDef, JointKind, Pose, Quat, Vec3, WorldConfig, vec3};

use crate::gltf::Film;
use crate::visual::Visuals;

/// A body of a scene.
#[derive(Clone, Debug)]
pub struct SceneBody {
    /// The scene's own name for it, in traces and reports; unique in its scene.
    pub name: String,
    /// The body with its shapes.
    pub def: BodyDef,
}

/// A joint of a scene.
#[derive(Clone, Debug)]
pub struct SceneJoint {
    /// The scene's own name for it; may be empty.
    pub name: String,
    /// Number of the first body in [`Scene::bodies`].
    pub body_a: usize,
    /// Number of the second body.
    pub body_b: usize,
    /// Anchor on the first body [m, its frame].
    pub anchor_a: Vec3,
    /// Anchor on the second body [m, its frame].
    pub anchor_b: Vec3,
    /// What it does.
    pub kind: JointKind,
    /// Whether the two bodies collide.
    pub collide_connected: bool,
    /// What it can bear; `None`: anything.
    pub strength: Option<JointStrength>,
    /// Whether the whole tree of joints is solved at once: see [`drystone::JointDef::articulated`].
    pub articulated: bool,
    /// Whether it acts from the start: see [`drystone::JointDef::enabled`].
    pub enabled: bool,
    /// Any number of the user's.
    pub user_data: u64,
}

/// Holds `coordinate b = ratio · coordinate a + offset` between two joints of six axes of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneCoupling {
    /// Number of the joint that is followed, in [`Scene::joints`].
    pub joint_a: usize,
    /// Its axis.
    pub axis_a: Axis,
    /// Number of the joint that follows.
    pub joint_b: usize,
    /// Its axis.
    pub axis_b: Axis,
    /// How far b goes for each unit of a; not 0.
    pub ratio: f32,
    /// Where b is with a at 0 [m or rad].
    pub offset: f32,
}

/// A named place on a body, such as a link of a robot that is held fast on another.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFrame {
    /// Its name, in traces; unique among bodies and frames of its scene.
    pub name: String,
    /// Number of the body in [`Scene::bodies`].
    pub body: usize,
    /// Where it is [frame of the body].
    pub pose: Pose,
    /// The point whose velocity is its own: the center of mass of what it names [m, frame of the body].
    pub center: Vec3,
}

/// A particle of a strand that a body holds.
#[derive(Clone, Copy, Debug)]
pub struct SceneHold {
    /// Number of the particle in its strand.
    pub particle: usize,
    /// Number of the body in [`Scene::bodies`].
    pub body: usize,
    /// Where [m, frame of the body].
    pub point: Vec3,
}

/// A link between two particles of a strand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneLink {
    /// Number of the first particle in its strand.
    pub a: usize,
    /// Number of the second one.
    pub b: usize,
    /// What it does.
    pub kind: LinkKind,
    /// Its length [m]; `None`: the distance of its particles.
    pub length: Option<f32>,
    /// See [`drystone::particle::LinkDef::tear_strain`].
    pub tear_strain: Option<f32>,
    /// See [`drystone::particle::LinkDef::tear_force`].
    pub tear_force: Option<f32>,
}

/// What a strand is.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum StrandDef {
    /// A rope.
    Rope(RopeDef),
    /// A cloth.
    Cloth(ClothDef),
    /// A particle at each of these points [m, world].
    Cloud(Vec<Vec3>, ParticleDef),
}

/// Particles of a scene. Only drystone has them: engines beside it are given the bodies alone.
#[derive(Clone, Debug)]
pub struct SceneStrand {
    /// The scene's own name for it.
    pub name: String,
    /// What it is.
    pub def: StrandDef,
    /// Links between its particles, beside its own.
    pub links: Vec<SceneLink>,
    /// Numbers of its particles that are pinned where they are.
    pub pins: Vec<usize>,
    /// Its particles that bodies hold.
    pub holds: Vec<SceneHold>,
}

impl SceneStrand {
    /// A strand that nothing pins or holds.
    #[must_use]
    pub fn new(name: impl Into<String>, def: StrandDef) -> Self {
        let (pins, holds) = (Vec::new(), Vec::new());
        Self { name: name.into(), def, links: Vec::new(), pins, holds }
    }
}

impl SceneJoint {
    /// A joint of two bodies, each with its number and anchor [m, its frame]: they do not collide, and it
    /// bears anything.
    #[must_use]
    pub fn new(a: (usize, Vec3), b: (usize, Vec3), kind: impl Into<JointKind>) -> Self {
        Self {
            name: String::new(),
            body_a: a.0,
            body_b: b.0,
            anchor_a: a.1,
            anchor_b: b.1,
            kind: kind.into(),
            collide_connected: false,
            strength: None,
            articulated: false,
            enabled: true,
            user_data: 0,
        }
    }

    /// A joint of six axes at a point, of bodies that stand so, with these frames [world].
    #[must_use]
    pub fn at(
        ends: [(usize, Pose); 2],
        point: Vec3,
        frames: [Quat; 2],
        axes: impl Into<SixDof>,
    ) -> Self {
        let [(a, at_a), (b, at_b)] = ends;
        let in_frame = |at: Pose, frame: Quat| (at.rotation.conjugate() * frame).normalized();
        let (frame_a, frame_b) = (in_frame(at_a, frames[0]), in_frame(at_b, frames[1]));
        let kind = JointKind::SixDof(SixDof { frame_a, frame_b, ..axes.into() });
        Self::new((a, at_a.local_point(point)), (b, at_b.local_point(point)), kind)
    }
}

/// What happens to the bodies while the scene runs, besides physics.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum Script {
    /// Nothing.
    #[default]
    None,
    /// Before every step, body `body` (kinematic) is aimed at the point `radius` from `center` in the
    /// xz plane whose angle grows by `degrees_per_step` from 0: its velocity becomes the distance to
    /// it over the step time. It starts at angle 0.
    Orbit {
        /// Number of the body.
        body: usize,
        /// Center of the circle [m].
        center: Vec3,
        /// Radius [m].
        radius: f32,
        /// Degrees a step, with sign.
        degrees_per_step: f32,
    },
    /// Before steps `every`, 2 `every`, … (counted from 0) one more of `bodies` is added, in order,
    /// until all are there. They are not in [`Scene::bodies`].
    Drop {
        /// Steps between two of them.
        every: u64,
        /// The bodies.
        bodies: Vec<SceneBody>,
    },
    /// Lasting forces and torques act on dynamic bodies.
    Loads {
        /// The first step with them, counted from 0.
        from: u64,
        /// What acts.
        loads: Vec<Load>,
    },
    /// The bodies, none of which is dynamic, are where a film has them.
    Film(Arc<Film>),
    /// Groups of bodies come, and go, before certain steps.
    Waves(Vec<Wave>),
}

/// A force that acts on a dynamic body in every step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Number of the body.
    pub body: usize,
    /// At its center of mass [N, world].
    pub force: Vec3,
    /// About it [N m, world].
    pub torque: Vec3,
}

/// Bodies that leave and bodies with their joints that join before a step. The numbers of bodies go on from those
/// of the scene in the order in which they come.
#[derive(Clone, Debug)]
pub struct Wave {
    /// Before which step, counted from 0; waves are in the order of their steps.
    pub step: u64,
    /// Numbers of the bodies that leave, with their joints.
    pub removed: core::ops::Range<usize>,
    /// Those that join.
    pub bodies: Vec<SceneBody>,
    /// Joints that are added then.
    pub joints: Vec<SceneJoint>,
}

/// What a script wants before one step.
#[derive(Clone, Copy, Debug)]
pub enum ScriptAction<'a> {
    /// Nothing.
    None,
    /// The kinematic body `body` gets the velocity that takes it to `position` in the step, without a
    /// turn.
    Aim {
        /// Number of the body.
        body: usize,
        /// Where its origin is to be after the step [m].
        position: Vec3,
    },
    /// This body joins.
    Add(&'a SceneBody),
    /// Bodies leave and join.
    Wave(&'a Wave),
    /// From now on these act.
    Loads(&'a [Load]),
    /// Every body is where this film has it after the step.
    Film(&'a Film),
}

impl Script {
    /// The bodies that join while the scene runs, in the order in which they come.
    pub fn joining(&self) -> impl Iterator<Item = &SceneBody> {
        let (dropped, waves): (&[SceneBody], &[Wave]) = match self {
            Self::Drop { bodies, .. } => (bodies, &[]),
            Self::Waves(waves) => (&[], waves),
            _ => (&[], &[]),
        };
        dropped.iter().chain(waves.iter().flat_map(|w| &w.bodies))
    }

    /// What is to be done before step `step`, counted from 0.
    #[must_use]
    pub fn action(&self, step: u64) -> ScriptAction<'_> {
        match self {
            Self::None => ScriptAction::None,
            &Self::Orbit { body, center, radius, degrees_per_step } => {
                let position = orbit_point(center, radius, degrees_per_step, step + 1);
                ScriptAction::Aim { body, position }
            }
            Self::Drop { every, bodies } => {
                let every = (*every).max(1);
                let number = (step / every).checked_sub(1).filter(|_| step.is_multiple_of(every));
                let body = number.and_then(|n| bodies.get(usize::try_from(n).ok()?));
                body.map_or(ScriptAction::None, ScriptAction::Add)
            }
            Self::Loads { from, loads } if step == *from => ScriptAction::Loads(loads),
            Self::Loads { .. } => ScriptAction::None,
            Self::Film(film) => ScriptAction::Film(film),
            Self::Waves(waves) => {
                let wave = waves.binary_search_by_key(&step, |w| w.step).ok();
                wave.map_or(ScriptAction::None, |i| ScriptAction::Wave(&waves[i]))
            }
        }
    }
}

/// Where an orbiting body is to be after `steps` steps.
fn orbit_point(center: Vec3, radius: f32, degrees_per_step: f32, steps: u64) -> Vec3 {
    // The angle is kept within a turn in f64: a step's part of it would be lost in f32 after a while.
    let degrees = (f64::from(degrees_per_step) * steps as f64) % 360.0;
    #[expect(clippy::cast_possible_truncation, reason = "within ±2π")]
    let angle = degrees.to_radians() as f32;
    let (s, c) = trig::sin_cos(angle);
    center + vec3(c, 0.0, s) * radius
}

/// A scene.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its name.
    pub name: String,
    /// What it shows, in a line.
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
    /// Its particles, in the order in which they are added, after bodies and joints.
    pub strands: Vec<SceneStrand>,
    /// Named places on its bodies.
    pub frames: Vec<SceneFrame>,
    /// Pairs of its bodies, by their numbers, that never collide: see [`drystone::World::set_bodies_collide`].
    pub never_collide: Vec<[usize; 2]>,
    /// What surfaces of some layers do to each other: see [`drystone::World::set_surface_rules`].
    pub surface_rules: Vec<SurfaceRule>,
    /// What the surfaces of two of its bodies, by their numbers, do to each other: see
    /// [`drystone::World::set_surface_between`].
    pub surfaces_between: Vec<([usize; 2], SurfaceRule)>,
    /// What happens besides.
    pub script: Script,
    /// What it looks like, if a file says it and it was read.
    pub visuals: Arc<Visuals>,
    /// What of a file was left out, changed or approximated, and why; a line each.
    pub notes: Vec<String>,
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
            strands: Vec::new(),
            frames: Vec::new(),
            never_collide: Vec::new(),
            surface_rules: Vec::new(),
            surfaces_between: Vec::new(),
            script: Script::None,
            visuals: Arc::default(),
            notes: Vec::new(),
        }
    }

    /// Adds a body; returns its number.
    pub fn add(&mut self, name: impl Into<String>, def: BodyDef) -> usize {
        self.bodies.push(SceneBody { name: name.into(), def });
        self.bodies.len() - 1
    }
}
