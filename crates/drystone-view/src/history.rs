//! A run that can go back: states at some steps, what the user did at each, and the steps between by
//! doing them again. That gives the same bits, for the engine does.

use std::collections::BTreeMap;

use drystone::{BodyDef, BodyId, ShapeDef, Vec3, WorldConfig};
use drystone_scene::{BuildError, Running};

/// States kept at most; where there are more, every other one is given up.
const MOST_STATES: usize = 64;

/// What the user does to a world before a step.
#[derive(Clone, Debug)]
pub enum Input {
    /// A force on a body for one step.
    Force {
        /// The body.
        body: BodyId,
        /// The force [N, world].
        force: Vec3,
        /// Where it acts [m, world].
        at: Vec3,
        /// And a torque [N m, world].
        torque: Vec3,
    },
    /// A ball is shot.
    Shot {
        /// Where it starts [m, world].
        from: Vec3,
        /// Its velocity [m/s, world].
        velocity: Vec3,
        /// Its radius [m].
        radius: f32,
    },
    /// Other settings.
    Config(Box<WorldConfig>),
}

/// A run with its past.
#[derive(Debug)]
pub struct History {
    running: Running,
    dt: f32,
    /// States before the step of their number; the first one stays.
    states: BTreeMap<u64, Running>,
    /// Steps between states.
    every: u64,
    inputs: BTreeMap<u64, Vec<Input>>,
    furthest: u64,
}

impl History {
    /// A run from its beginning, in steps of `dt` [s].
    #[must_use]
    pub fn new(running: Running, dt: f32) -> Self {
        let states = BTreeMap::from([(0, running.clone())]);
        Self { running, dt, states, every: 8, inputs: BTreeMap::new(), furthest: 0 }
    }

    /// The run as it is now.
    #[must_use]
    pub const fn now(&self) -> &Running {
        &self.running
    }

    /// Steps taken up to now.
    #[must_use]
    pub const fn step_count(&self) -> u64 {
        self.running.step_count()
    }

    /// The last step that was reached.
    #[must_use]
    pub const fn furthest(&self) -> u64 {
        self.furthest
    }

    /// Length of a step [s].
    #[must_use]
    pub const fn dt(&self) -> f32 {
        self.dt
    }

    /// Takes a step. Where the past is played again and `inputs` is empty it stays as it was;
    /// otherwise what came after it is forgotten.
    ///
    /// # Errors
    /// The engine refuses what the scene's script wants; no step was taken.
    pub fn step(&mut self, inputs: Vec<Input>) -> Result<(), BuildError> {
        let step = self.step_count();
        if !inputs.is_empty() {
            self.furthest = step;
            self.states.split_off(&(step + 1));
            self.inputs.split_off(&step);
            self.inputs.insert(step, inputs);
        }
        self.advance()
    }

    /// Goes to a step, back or forward.
    ///
    /// # Errors
    /// The engine refuses what the scene's script wants; the run stands before that step.
    pub fn seek(&mut self, step: u64) -> Result<(), BuildError> {
        let here = self.step_count();
        if let Some((&number, state)) = self.states.range(..=step).next_back()
            && (step < here || number > here)
        {
            self.running = state.clone();
        }
        while self.step_count() < step {
            self.advance()?;
        }
        Ok(())
    }

    /// Takes a step with the inputs that it had.
    fn advance(&mut self) -> Result<(), BuildError> {
        let step = self.step_count();
        if step.is_multiple_of(self.every) && !self.states.contains_key(&step) {
            self.states.insert(step, self.running.clone());
            if self.states.len() > MOST_STATES {
                self.every *= 2;
                let every = self.every;
                self.states.retain(|number, _| number.is_multiple_of(every));
            }
        }
        for input in self.inputs.get(&step).into_iter().flatten() {
            apply(&mut self.running, input);
        }
        self.running.step(self.dt)?;
        self.furthest = self.furthest.max(self.step_count());
        Ok(())
    }
}

/// What the engine refuses of an input does not happen: a body may be gone, a place beyond its limits.
fn apply(running: &mut Running, input: &Input) {
    let world = &mut running.world;
    match input {
        Input::Force { body, force, at, torque } => {
            if let Some(mut body) = world.body_mut(*body) {
                body.wake();
                let _ = body.add_step_force_at(*force, *at);
                let _ = body.add_step_torque(*torque);
            }
        }
        Input::Shot { from, velocity, radius } => {
            let shape = ShapeDef { density: 3000.0, ..ShapeDef::sphere(*radius) };
            let mut def = BodyDef::dynamic().with_position(*from).with_shape(shape);
            def.linear_velocity = *velocity;
            let _ = world.add_body(def);
        }
        Input::Config(config) => {
            let _ = world.set_config((**config).clone());
            world.wake_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use drystone::vec3;

    use super::{History, Input};

    fn pyramid() -> History {
        let scene = drystone_scene::named("pyramid:base=4").unwrap();
        History::new(scene.build().unwrap(), 1.0 / 60.0)
    }

    fn shot() -> Input {
        Input::Shot { from: vec3(0.0, 1.0, 6.0), velocity: vec3(0.0, 0.0, -20.0), radius: 0.3 }
    }

    #[test]
    fn going_back_and_forth_gives_the_same_bits_with_what_the_user_did() {
        let mut history = pyramid();
        let mut hashes = vec![history.now().world.state_hash()];
        for step in 0..150 {
            let inputs = if step == 20 { vec![shot()] } else { Vec::new() };
            history.step(inputs).unwrap();
            hashes.push(history.now().world.state_hash());
        }
        assert_ne!(hashes[150], hashes[149], "something moves");
        for step in [149, 3, 90, 21, 20, 0, 150] {
            history.seek(step).unwrap();
            let hash = history.now().world.state_hash();
            assert_eq!(hash, hashes[usize::try_from(step).unwrap()], "step {step}");
        }
    }

    #[test]
    fn a_new_deed_in_the_past_makes_another_future() {
        let mut history = pyramid();
        history.seek(60).unwrap();
        let end = history.now().world.state_hash();
        history.seek(30).unwrap();
        history.step(vec![shot()]).unwrap();
        assert_eq!(history.furthest(), 31);
        history.seek(60).unwrap();
        assert_ne!(history.now().world.state_hash(), end);
    }

    #[test]
    fn states_stay_few() {
        let mut history = pyramid();
        history.seek(1200).unwrap();
        assert!(history.states.len() <= super::MOST_STATES);
        history.seek(1).unwrap();
        assert_eq!((history.step_count(), history.furthest()), (1, 1200));
    }
}
