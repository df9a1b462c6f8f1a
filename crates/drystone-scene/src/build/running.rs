//! A scene as a world that runs, with its script.

use std::collections::BTreeMap;
use std::sync::Arc;

use drystone::articulation::ArticulationId;
use drystone::joint::CouplingDef;
use drystone::particle::{LinkDef, Strand};
use drystone::{BodyDef, BodyId, BodyKind, DefError, JointDef, JointId, Pose, World};
use serde::{Deserialize, Serialize};

use crate::scene::{
    Load, Scene, SceneBody, SceneCoupling, SceneFrame, SceneJoint, SceneStrand, Script,
    ScriptAction, StrandDef, Wave,
};
use crate::visual::Visuals;

/// The engine refused something of a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The configuration.
    #[error("configuration: {0}")]
    Config(#[source] DefError),
    /// A body.
    #[error("body '{name}': {error}")]
    Body {
        /// Its name.
        name: String,
        /// The engine's error.
        #[source]
        error: DefError,
    },
    /// A joint.
    #[error("joint {number} between {bodies}: {error}")]
    Joint {
        /// Its number in the scene, from 0.
        number: usize,
        /// The names of its two bodies.
        bodies: String,
        /// The engine's error.
        #[source]
        error: DefError,
    },
    /// A coupling.
    #[error("coupling {number}: {error}")]
    Coupling {
        /// Its number in the scene, from 0.
        number: usize,
        /// The engine's error.
        #[source]
        error: DefError,
    },
    /// An articulation.
    #[error("tree {number}: {error}")]
    Articulation {
        /// Its number in the scene, from 0.
        number: usize,
        /// The engine's error.
        #[source]
        error: DefError,
    },
    /// A rope, a cloth or a cloud.
    #[error("strand '{name}': {error}")]
    Strand {
        /// Its name.
        name: String,
        /// The engine's error.
        #[source]
        error: DefError,
    },
    /// The rules of surfaces.
    #[error("surface_rules: {0}")]
    SurfaceRules(#[source] DefError),
    /// A coupling names a joint that the scene does not have.
    #[error("coupling {number} names joint number {joint}, the scene has {joints} joints")]
    NoSuchJoint {
        /// Its number in the scene, from 0.
        number: usize,
        /// The number given.
        joint: usize,
        /// How many there are.
        joints: usize,
    },
    /// A strand names a particle that it does not have.
    #[error("strand '{name}' names its particle number {number}, it has {particles}")]
    NoSuchParticle {
        /// Its name.
        name: String,
        /// The number given.
        number: usize,
        /// How many there are.
        particles: usize,
    },
    /// A joint or the script names a body that the scene does not have.
    #[error("{user} names body number {number}, the scene has {bodies} bodies")]
    NoSuchBody {
        /// The thing that names it.
        user: String,
        /// The number given.
        number: usize,
        /// How many there are.
        bodies: usize,
    },
}

/// A scene that runs. Serde leaves out its world and the data of the scene: [`Scene::save`] keeps
/// both together.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Running {
    /// The world. If you step it directly, the script does not run.
    #[serde(skip)]
    pub world: World,
    /// Its bodies in the order in which they came, including those that are gone. Pieces that
    /// others broke into are among them after [`Self::after_step`].
    pub bodies: Vec<BodyId>,
    /// Their names. Pieces of a body `wall` are `wall piece 1`, `wall piece 2`, … in the order in
    /// which they came off, pieces of its pieces too.
    pub names: Vec<String>,
    /// Its joints in the order of the scene, then of the script.
    pub joints: Vec<JointId>,
    /// Its articulations in the order of the scene's trees; none if the scene is not reduced.
    #[serde(default)]
    pub articulations: Vec<ArticulationId>,
    /// Its couplings in the order of the scene.
    pub couplings: Vec<JointId>,
    /// Its ropes, cloths and clouds in the order of the scene.
    pub strands: Vec<Strand>,
    /// Named places on its bodies, as the scene has them.
    #[serde(skip)]
    pub frames: Vec<SceneFrame>,
    /// Its visuals, as the scene has them.
    #[serde(skip)]
    pub visuals: Arc<Visuals>,
    /// Number of bodies that the scene and its script brought.
    pub(super) brought: Vec<BodyId>,
    /// Number of the body that a piece came from at first.
    pub(super) origins: BTreeMap<BodyId, usize>,
    /// How many pieces came off a body so far, by its number.
    pub(super) pieces: BTreeMap<usize, usize>,
    #[serde(skip)]
    pub(super) script: Script,
    pub(super) steps: u64,
}

impl Scene {
    /// The scene as a world.
    ///
    /// # Errors
    /// The first body or joint that the engine refuses.
    pub fn build(&self) -> Result<Running, BuildError> {
        let world = World::new(self.config.clone()).map_err(BuildError::Config)?;
        let mut running = Running {
            world,
            bodies: Vec::with_capacity(self.bodies.len()),
            names: Vec::with_capacity(self.bodies.len()),
            joints: Vec::with_capacity(self.joints.len()),
            articulations: Vec::new(),
            couplings: Vec::with_capacity(self.couplings.len()),
            strands: Vec::with_capacity(self.strands.len()),
            frames: self.frames.clone(),
            visuals: Arc::clone(&self.visuals),
            brought: Vec::with_capacity(self.bodies.len()),
            origins: BTreeMap::new(),
            pieces: BTreeMap::new(),
            script: self.script.clone(),
            steps: 0,
        };
        for body in &self.bodies {
            running.add(&body.name, body.def.clone())?;
        }
        let rules = running.world.set_surface_rules(self.surface_rules.clone());
        rules.map_err(BuildError::SurfaceRules)?;
        for pair in &self.never_collide {
            let user = "never_collide";
            let (a, b) = (running.at(user, pair[0])?, running.at(user, pair[1])?);
            running.world.set_bodies_collide(a, b, false);
        }
        for (pair, rule) in &self.surfaces_between {
            let user = "surfaces_between";
            let (a, b) = (running.at(user, pair[0])?, running.at(user, pair[1])?);
            let rule = running.world.set_surface_between(a, b, Some(*rule));
            rule.map_err(BuildError::SurfaceRules)?;
        }
        let mut replaced = vec![false; self.joints.len()];
        if self.reduced {
            self.add_trees(&mut running, &mut replaced)?;
        }
        for (joint, replaced) in self.joints.iter().zip(replaced) {
            // A disabled joint keeps its bodies from colliding.
            running.add_joint(joint, joint.enabled && !replaced)?;
        }
        for number in 0..self.couplings.len() {
            self.add_coupling(number, &mut running)?;
        }
        for frame in &self.frames {
            running.at(&format!("the frame '{}'", frame.name), frame.body)?;
        }
        for strand in &self.strands {
            running.add_strand(strand)?;
        }
        match &self.script {
            Script::None | Script::Film(_) => {}
            Script::Orbit { body, .. } => {
                running.at("the script", *body)?;
            }
            Script::Loads { loads, .. } => {
                for load in loads {
                    running.at("the script", load.body)?;
                }
            }
            Script::Drop { .. } | Script::Waves(_) => {
                for SceneBody { name, def } in self.script.joining() {
                    def.validate().map_err(|error| body_error(name, error))?;
                }
            }
        }
        Ok(running)
    }
}

impl Scene {
    /// Makes articulations of the trees. Marks the joints that they replace, and those that hold
    /// nothing.
    fn add_trees(&self, running: &mut Running, replaced: &mut [bool]) -> Result<(), BuildError> {
        for (number, tree) in self.trees.iter().enumerate() {
            let user = "a tree";
            for body in &tree.between {
                let id = running.at(user, *body)?;
                if let Some(mut body) = running.world.body_mut(id) {
                    body.set_enabled(false);
                }
            }
            let bodies = tree.bodies.iter().map(|body| running.at(user, *body));
            let bodies: Vec<BodyId> = bodies.collect::<Result<_, _>>()?;
            let made = running.world.articulate(tree.def.clone(), &bodies);
            let refused = |error| BuildError::Articulation { number, error };
            running.articulations.push(made.map_err(refused)?);
            for joint in &tree.joints {
                if let Some(replaced) = replaced.get_mut(*joint) {
                    *replaced = true;
                }
            }
        }
        for (joint, replaced) in self.joints.iter().zip(replaced) {
            *replaced |= joint.holds_nothing();
        }
        Ok(())
    }

    fn add_coupling(&self, number: usize, running: &mut Running) -> Result<(), BuildError> {
        let SceneCoupling { joint_a, axis_a, joint_b, axis_b, ratio, offset } =
            self.couplings[number];
        let find = |joint: usize| {
            let joints = running.joints.len();
            let id = running.joints.get(joint).copied();
            id.ok_or(BuildError::NoSuchJoint { number, joint, joints })
        };
        let (joint_a, joint_b) = (find(joint_a)?, find(joint_b)?);
        let def = CouplingDef { joint_a, axis_a, joint_b, axis_b, ratio, offset };
        let added = running.world.add_coupling(def);
        running.couplings.push(added.map_err(|error| BuildError::Coupling { number, error })?);
        Ok(())
    }
}

fn body_error(name: &str, error: DefError) -> BuildError {
    BuildError::Body { name: name.to_owned(), error }
}

impl Running {
    /// Adds a body of the scene or of the script.
    ///
    /// # Errors
    /// The engine refuses it.
    pub fn add(&mut self, name: &str, def: BodyDef) -> Result<(), BuildError> {
        let id = self.world.add_body(def).map_err(|error| body_error(name, error))?;
        self.brought.push(id);
        self.learn(id, name.to_owned());
        Ok(())
    }

    fn add_strand(&mut self, strand: &SceneStrand) -> Result<(), BuildError> {
        let SceneStrand { name, def, links, pins, holds } = strand;
        let refused = |error| BuildError::Strand { name: name.clone(), error };
        let made = match def {
            StrandDef::Rope(def) => self.world.add_rope(*def),
            StrandDef::Cloth(def) => self.world.add_cloth(*def),
            StrandDef::Cloud(points, def) => self
                .world
                .add_cloud(points.iter().copied(), *def)
                .map(|particles| Strand { particles, links: Vec::new() }),
        };
        let mut made = made.map_err(refused)?;
        for link in links {
            let particles = made.particles.len();
            let missing = |number: usize| BuildError::NoSuchParticle {
                name: name.clone(),
                number,
                particles,
            };
            let find = |n: usize| made.particles.get(n).copied().ok_or_else(|| missing(n));
            let def = LinkDef {
                length: link.length,
                tear_strain: link.tear_strain,
                tear_force: link.tear_force,
                ..LinkDef::new(find(link.a)?, find(link.b)?, link.kind)
            };
            let id = self.world.add_link(def).map_err(refused)?;
            made.links.push(id);
        }
        let particle = |number: usize| {
            let particles = made.particles.len();
            let name = || name.clone();
            let missing = || BuildError::NoSuchParticle { name: name(), number, particles };
            made.particles.get(number).copied().ok_or_else(missing)
        };
        for number in pins {
            if let Some(mut pinned) = self.world.particle_mut(particle(*number)?) {
                pinned.set_pinned(true);
            }
        }
        for hold in holds {
            let body = self.at(name, hold.body)?;
            let held = particle(hold.particle)?;
            if let Some(mut held) = self.world.particle_mut(held) {
                held.attach(body, hold.point).map_err(refused)?;
            }
        }
        self.strands.push(made);
        Ok(())
    }

    fn learn(&mut self, id: BodyId, name: String) {
        self.bodies.push(id);
        self.names.push(name);
    }

    fn add_joint(&mut self, joint: &SceneJoint, enabled: bool) -> Result<(), BuildError> {
        let number = self.joints.len();
        let user = format!("joint {number}");
        let (a, b) = (self.at(&user, joint.body_a)?, self.at(&user, joint.body_b)?);
        let def = JointDef {
            collide_connected: joint.collide_connected,
            strength: joint.strength,
            articulated: joint.articulated,
            enabled,
            user_data: joint.user_data,
            ..JointDef::new(a, b, joint.kind).with_anchors(joint.anchor_a, joint.anchor_b)
        };
        let id = self.world.add_joint(def).map_err(|error| {
            let [a, b] = [def.body_a, def.body_b].map(|id| self.name_of(id));
            BuildError::Joint { number, bodies: format!("'{a}' and '{b}'"), error }
        })?;
        self.joints.push(id);
        Ok(())
    }

    /// The bodies that scene and script brought, by their numbers.
    #[must_use]
    pub fn brought(&self) -> &[BodyId] {
        &self.brought
    }

    /// Whether a body is a piece of one that broke.
    #[must_use]
    pub fn is_piece(&self, id: BodyId) -> bool {
        self.origins.contains_key(&id)
    }

    fn name_of(&self, id: BodyId) -> &str {
        let number = self.bodies.iter().position(|b| *b == id);
        number.map_or("", |n| &self.names[n])
    }

    /// Bodies leave and join, as the script says.
    ///
    /// # Errors
    /// The engine refuses a body or a joint, or a joint names a body that is not there.
    pub fn bring(&mut self, wave: &Wave) -> Result<(), BuildError> {
        for number in wave.removed.clone() {
            let id = self.at("the script", number)?;
            self.world.remove_body(id);
        }
        for SceneBody { name, def } in &wave.bodies {
            self.add(name, def.clone())?;
        }
        for joint in &wave.joints {
            self.add_joint(joint, joint.enabled)?;
        }
        Ok(())
    }

    /// Learns the bodies that others broke into in the last step. Does nothing when it is called
    /// again.
    pub fn after_step(&mut self) {
        let events = self.world.events();
        let known = |id: &BodyId| self.origins.contains_key(id);
        if events.pieces.is_empty() || events.pieces.iter().all(known) {
            return;
        }
        let mut found = Vec::new();
        for event in &events.fractures {
            found.extend(events.pieces_of(event).iter().map(|piece| (event.body, *piece)));
        }
        for (from, piece) in found {
            let number = self.origins.get(&from).copied();
            let origin = number.or_else(|| self.bodies.iter().position(|b| *b == from));
            let Some(origin) = origin else { continue };
            let count = self.pieces.entry(origin).or_default();
            *count += 1;
            let name = format!("{} piece {count}", self.names[origin]);
            self.origins.insert(piece, origin);
            self.learn(piece, name);
        }
    }

    fn at(&self, user: &str, number: usize) -> Result<BodyId, BuildError> {
        self.brought.get(number).copied().ok_or_else(|| BuildError::NoSuchBody {
            user: user.to_owned(),
            number,
            bodies: self.brought.len(),
        })
    }

    /// Steps taken with [`Self::step`].
    #[must_use]
    pub const fn step_count(&self) -> u64 {
        self.steps
    }

    /// Carries out the script and then advances the world by `dt` [s].
    ///
    /// # Errors
    /// The engine refuses an action of the script; the world has not advanced then.
    pub fn step(&mut self, dt: f32) -> Result<(), BuildError> {
        self.before_step(dt)?;
        self.world.step(dt);
        self.after_step();
        Ok(())
    }

    /// Carries out the script before the next step, which takes `dt` [s]: for callers that then
    /// step [`Self::world`] themselves, once, and then call [`Self::after_step`].
    ///
    /// # Errors
    /// The engine refuses an action of the script.
    pub fn before_step(&mut self, dt: f32) -> Result<(), BuildError> {
        self.after_step();
        let script = core::mem::take(&mut self.script);
        let done = self.act(script.action(self.steps), dt);
        self.script = script;
        done?;
        self.steps += 1;
        Ok(())
    }

    /// The length of the film that it plays, if it is one [s].
    #[must_use]
    pub fn film_seconds(&self) -> Option<f32> {
        match &self.script {
            Script::Film(film) => Some(film.seconds()),
            _ => None,
        }
    }

    fn load(&mut self, load: &Load) -> Result<(), BuildError> {
        let id = self.at("the script", load.body)?;
        let Some(mut body) = self.world.body_mut(id) else { return Ok(()) };
        body.set_lasting_force(load.force);
        body.set_lasting_torque(load.torque);
        Ok(())
    }

    fn act(&mut self, action: ScriptAction<'_>, dt: f32) -> Result<(), BuildError> {
        match action {
            ScriptAction::None => {}
            ScriptAction::Wave(wave) => self.bring(wave)?,
            ScriptAction::Aim { body, position } => {
                let id = self.at("the script", body)?;
                if let Some(mut mover) = self.world.body_mut(id) {
                    let pose = Pose::new(position, mover.get().rotation());
                    mover.move_to(pose, dt);
                }
            }
            ScriptAction::Loads(loads) => loads.iter().try_for_each(|load| self.load(load))?,
            ScriptAction::Add(body) => {
                let SceneBody { name, def } = body.clone();
                self.add(&name, def)?;
            }
            ScriptAction::Film(film) => {
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "a time in f32, as in the file"
                )]
                let time = ((self.steps + 1) as f64 * f64::from(dt)) as f32;
                while let Some(SceneBody { name, def }) = film.late(self.bodies.len(), time) {
                    self.add(name, def.clone())?;
                }
                for (number, id) in self.bodies.iter().enumerate() {
                    if film.is_gone(number, time) {
                        self.world.remove_body(*id);
                        continue;
                    }
                    let Some(mut body) = self.world.body_mut(*id) else { continue };
                    if body.get().kind() == BodyKind::Kinematic {
                        body.set_pose(film.pose(number, time));
                    }
                }
            }
        }
        Ok(())
    }
}
