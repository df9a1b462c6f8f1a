//! A scene as a world that runs, with its script.

use drystone::{BodyDef, BodyId, BodyKind, DefError, JointDef, JointId, Pose, World};

use crate::scene::{Scene, SceneBody, Script, ScriptAction};

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
            Script::None | Script::Film(_) => {}
            Script::Orbit { body, .. } | Script::Pull { body, .. } => {
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
            strength: joint.strength,
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
        // Taken out, so that it can be asked while bodies join.
        let script = std::mem::take(&mut self.script);
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

    fn act(&mut self, action: ScriptAction<'_>, dt: f32) -> Result<(), BuildError> {
        match action {
            ScriptAction::None => {}
            ScriptAction::Aim { body, position } => {
                let id = self.at("the script", body)?;
                if let Some(mut mover) = self.world.body_mut(id) {
                    let pose = Pose::new(position, mover.get().rotation());
                    mover.move_to(pose, dt).map_err(|e| body_error(&self.names[body], e))?;
                }
            }
            ScriptAction::Pull { body, force } => {
                let id = self.at("the script", body)?;
                if let Some(mut pulled) = self.world.body_mut(id) {
                    pulled
                        .set_lasting_force(force)
                        .map_err(|e| body_error(&self.names[body], e))?;
                }
            }
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
                    let Some(mut body) = self.world.body_mut(*id) else { continue };
                    if body.get().kind() == BodyKind::Kinematic {
                        body.set_pose(film.pose(number, time))
                            .map_err(|e| body_error(&self.names[number], e))?;
                    }
                }
            }
        }
        Ok(())
    }
}
