//! A scene as a world that runs, with its script.

use drystone::{BodyDef, BodyId, DefError, JointDef, JointId, Pose, Vec3, World, trig, vec3};

use crate::scene::{Scene, SceneBody, Script};

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
        /// What is wrong with it.
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
        /// What is wrong with it.
        #[source]
        error: DefError,
    },
    /// A joint or the script names a body that the scene does not have.
    #[error("{user} names body number {number}, the scene has {bodies} bodies")]
    NoSuchBody {
        /// Who names it.
        user: String,
        /// The number given.
        number: usize,
        /// How many there are.
        bodies: usize,
    },
}

/// A scene that runs.
#[derive(Clone, Debug)]
pub struct Running {
    /// The world. Whoever steps it directly leaves the script out.
    pub world: World,
    /// Its bodies in the order in which they came.
    pub bodies: Vec<BodyId>,
    /// Their names.
    pub names: Vec<String>,
    /// Its joints in the order of the scene.
    pub joints: Vec<JointId>,
    script: Script,
    steps: u64,
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
            script: self.script.clone(),
            steps: 0,
        };
        for body in &self.bodies {
            running.add(&body.name, body.def.clone())?;
        }
        for number in 0..self.joints.len() {
            self.add_joint(number, &mut running)?;
        }
        match &self.script {
            Script::None => {}
            Script::Orbit { body, .. } => {
                running.at("the script", *body)?;
            }
            Script::Drop { bodies, .. } => {
                for SceneBody { name, def } in bodies {
                    def.validate().map_err(|error| body_error(name, error))?;
                }
            }
        }
        Ok(running)
    }

    fn add_joint(&self, number: usize, running: &mut Running) -> Result<(), BuildError> {
        let joint = &self.joints[number];
        let user = format!("joint {number}");
        let def = JointDef {
            body_a: running.at(&user, joint.body_a)?,
            body_b: running.at(&user, joint.body_b)?,
            anchor_a: joint.anchor_a,
            anchor_b: joint.anchor_b,
            kind: joint.kind,
            collide_connected: joint.collide_connected,
        };
        let id = running.world.add_joint(def).map_err(|error| BuildError::Joint {
            number,
            bodies: format!(
                "'{}' and '{}'",
                running.names[joint.body_a], running.names[joint.body_b]
            ),
            error,
        })?;
        running.joints.push(id);
        Ok(())
    }
}

fn body_error(name: &str, error: DefError) -> BuildError {
    BuildError::Body { name: name.to_owned(), error }
}

impl Running {
    fn add(&mut self, name: &str, def: BodyDef) -> Result<(), BuildError> {
        let id = self.world.add_body(def).map_err(|error| body_error(name, error))?;
        self.bodies.push(id);
        self.names.push(name.to_owned());
        Ok(())
    }

    fn at(&self, user: &str, number: usize) -> Result<BodyId, BuildError> {
        self.bodies.get(number).copied().ok_or_else(|| BuildError::NoSuchBody {
            user: user.to_owned(),
            number,
            bodies: self.bodies.len(),
        })
    }

    /// Steps taken with [`Self::step`].
    #[must_use]
    pub const fn step_count(&self) -> u64 {
        self.steps
    }

    /// Does what the script says and then advances the world by `dt` [s].
    ///
    /// # Errors
    /// The engine refuses what the script wants; the world has not advanced then.
    pub fn step(&mut self, dt: f32) -> Result<(), BuildError> {
        self.before_step(dt)?;
        self.world.step(dt);
        Ok(())
    }

    /// Does what the script says before the next step, which takes `dt` [s]: for callers that then step
    /// [`Self::world`] themselves, once.
    ///
    /// # Errors
    /// The engine refuses what the script wants.
    pub fn before_step(&mut self, dt: f32) -> Result<(), BuildError> {
        match &self.script {
            Script::None => {}
            &Script::Orbit { body, center, radius, degrees_per_step } => {
                let aim = orbit_point(center, radius, degrees_per_step, self.steps + 1);
                let id = self.at("the script", body)?;
                if let Some(mut mover) = self.world.body_mut(id) {
                    let pose = Pose::new(aim, mover.get().rotation());
                    mover.move_to(pose, dt).map_err(|e| body_error(&self.names[body], e))?;
                }
            }
            Script::Drop { every, bodies } => {
                let every = (*every).max(1);
                if self.steps > 0 && self.steps.is_multiple_of(every) {
                    let number = usize::try_from(self.steps / every - 1).unwrap_or(usize::MAX);
                    if let Some(SceneBody { name, def }) = bodies.get(number).cloned() {
                        self.add(&name, def)?;
                    }
                }
            }
        }
        self.steps += 1;
        Ok(())
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
