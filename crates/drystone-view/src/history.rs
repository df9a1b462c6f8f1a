//! A run that can go back: states at some steps, the user's actions at each, and the steps between
//! by doing them again. That gives the same bits, for the engine does.

use std::collections::BTreeMap;

use drystone::{
    AxisLocks, BodyDef, BodyId, BodyKind, MassDef, Pose, ShapeDef, Stage, Vec3, World, WorldConfig,
};
use drystone_scene::{BuildError, Running};

/// States kept at most; where there are more, every other one is given up.
const MOST_STATES: usize = 64;
/// Memory that they take at most [bytes], by a rough count; a page in a browser has less.
const MOST_BYTES: usize = if cfg!(target_arch = "wasm32") { 1 << 27 } else { 1 << 29 };

/// From here on a state is large [bytes].
const LARGE: usize = 1 << 21;

/// An action of the user on a world before a step.
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
    /// A ball or a box is shot.
    Shot {
        /// Where it starts [m, world].
        from: Vec3,
        /// Its velocity [m/s, world].
        velocity: Vec3,
        /// Radius of the ball, half the edge of the box [m].
        radius: f32,
        /// Whether it is a box.
        boxed: bool,
    },
    /// A body is taken away.
    Remove(BodyId),
    /// A second body like this one, beside it.
    Duplicate(BodyId),
    /// A body is held where it is, or no longer.
    Freeze(BodyId, bool),
    /// Other settings.
    Config(Box<WorldConfig>),
}

/// A run with its past.
#[derive(Clone, Debug)]
pub struct History {
    running: Running,
    dt: f32,
    /// States before the step of their number; the first one stays.
    states: BTreeMap<u64, Running>,
    /// Steps between states.
    every: u64,
    /// The user's actions before the step of their number.
    inputs: BTreeMap<u64, Vec<Input>>,
    /// How many of the next step's inputs have already been done.
    done: usize,
    furthest: u64,
}

impl History {
    /// A run from its beginning, in steps of `dt` [s].
    #[must_use]
    pub fn new(running: Running, dt: f32) -> Self {
        let states = BTreeMap::from([(0, running.clone())]);
        // A large state takes as long to copy as a step: they are kept less often.
        let every = if bytes(&running.world) > LARGE { 32 } else { 8 };
        Self { running, dt, states, every, inputs: BTreeMap::new(), done: 0, furthest: 0 }
    }

    /// Another run with the same past. It keeps only the first state: the others come again as they
    /// are needed.
    #[must_use]
    pub fn fork(&self) -> Self {
        let states = self.states.iter().take(1).map(|(n, state)| (*n, state.clone())).collect();
        let (running, inputs) = (self.running.clone(), self.inputs.clone());
        let Self { dt, every, done, furthest, .. } = *self;
        Self { running, dt, states, every, inputs, done, furthest }
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

    /// Applies an action now. Actions that came later in an earlier run of this step are forgotten.
    pub fn act(&mut self, input: Input) {
        let step = self.step_count();
        self.keep_state();
        apply(&mut self.running, &input);
        self.furthest = step;
        self.states.split_off(&(step + 1));
        self.inputs.split_off(&(step + 1));
        let inputs = self.inputs.entry(step).or_default();
        inputs.truncate(self.done);
        // A slider that is dragged gives new settings with every picture.
        if let (Some(Input::Config(last)), Input::Config(new)) = (inputs.last_mut(), &input) {
            last.clone_from(new);
        } else {
            inputs.push(input);
        }
        self.done = inputs.len();
    }

    /// Takes a step, with the inputs that it had when it was first taken; `after` runs after each
    /// of the engine's stages.
    ///
    /// # Errors
    /// The engine refuses an action of the scene's script; no step was taken.
    pub fn step(&mut self, after: &mut dyn FnMut(Stage)) -> Result<(), BuildError> {
        let step = self.step_count();
        self.keep_state();
        for input in self.inputs.get(&step).into_iter().flatten().skip(self.done) {
            apply(&mut self.running, input);
        }
        // They must not be done again if the step fails.
        self.done = self.inputs.get(&step).map_or(0, Vec::len);
        self.running.before_step(self.dt)?;
        self.running.world.step_observed(self.dt, after);
        self.running.after_step();
        self.done = 0;
        self.furthest = self.furthest.max(self.step_count());
        Ok(())
    }

    /// Goes to a step, back or forward.
    ///
    /// # Errors
    /// The engine refuses an action of the scene's script; the run stands before that step.
    pub fn seek(&mut self, step: u64) -> Result<(), BuildError> {
        let here = self.step_count();
        if let Some((&number, state)) = self.states.range(..=step).next_back()
            && (step < here || number > here || (step == here && self.done > 0 && number == here))
        {
            self.running = state.clone();
            self.done = 0;
        }
        while self.step_count() < step {
            self.step(&mut |_| ())?;
        }
        Ok(())
    }

    /// Keeps the state before the next step, if it is time and nothing was done to it.
    fn keep_state(&mut self) {
        let step = self.step_count();
        if self.done > 0 || !step.is_multiple_of(self.every) || self.states.contains_key(&step) {
            return;
        }
        self.states.insert(step, self.running.clone());
        let most = (MOST_BYTES / bytes(&self.running.world).max(1)).clamp(2, MOST_STATES);
        while self.states.len() > most {
            self.every *= 2;
            let every = self.every;
            self.states.retain(|number, _| number.is_multiple_of(every));
        }
    }
}

/// Approximate memory of a copy of a world.
fn bytes(world: &World) -> usize {
    let counts = world.counts();
    let bodies = counts.fixed + counts.kinematic + counts.dynamic;
    600 * bodies + 400 * (counts.shapes + counts.joints) + 400 * counts.pairs
}

/// An input that the engine refuses has no effect: a body may be gone, a place beyond its limits.
fn apply(running: &mut Running, input: &Input) {
    let world = &mut running.world;
    match input {
        Input::Force { body, force, at, torque } => {
            if let Some(mut body) = world.body_mut(*body) {
                body.wake();
                body.add_step_force_at(*force, *at);
                body.add_step_torque(*torque);
            }
        }
        &Input::Shot { from, velocity, radius, boxed } => {
            let shape =
                if boxed { ShapeDef::box_half([radius; 3]) } else { ShapeDef::sphere(radius) };
            let shape = ShapeDef { density: 3000.0, ..shape };
            let mut def = BodyDef::dynamic().with_position(from).with_shape(shape);
            def.linear_velocity = velocity;
            // It is none of a file's, and looks like none.
            def.user_data = u64::MAX;
            let _ = world.add_body(def);
        }
        Input::Remove(body) => {
            let _ = world.remove_body(*body);
        }
        Input::Duplicate(body) => {
            if let Some(def) = duplicate(world, *body) {
                let _ = world.add_body(def);
            }
        }
        Input::Freeze(body, frozen) => {
            if let Some(mut body) = world.body_mut(*body) {
                let held = AxisLocks { linear: [true; 3], angular: [true; 3] };
                body.set_locks(if *frozen { held } else { AxisLocks::NONE });
                body.set_linear_velocity(Vec3::ZERO);
                body.set_angular_velocity(Vec3::ZERO);
                body.wake();
            }
        }
        Input::Config(config) => {
            let _ = world.set_config((**config).clone());
            world.wake_all();
        }
    }
}

/// A body like another one, above it: it falls on it.
fn duplicate(world: &World, id: BodyId) -> Option<BodyDef> {
    let body = world.body(id)?;
    let up = (-world.config().gravity).normalize_or(Vec3::Y);
    let (kind, user_data) = (body.kind(), body.user_data());
    let mut def = BodyDef { kind, user_data, ..BodyDef::default() };
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    for shape in body.shapes().filter_map(|id| world.shape(id)) {
        let bounds = shape.bounds();
        let half = bounds.half_extents().dot(up.abs());
        let middle = bounds.center().dot(up);
        (low, high) = (low.min(middle - half), high.max(middle + half));
        def.shapes.push(ShapeDef {
            pose: shape.local_pose(),
            density: shape.density(),
            material: shape.material(),
            filter: shape.filter(),
            sensor: shape.is_sensor(),
            ..ShapeDef::new(shape.shape().clone())
        });
    }
    let Pose { position, rotation } = body.pose();
    def.position = position + up * (1.05 * (high - low).clamp(0.0, 1.0e3));
    def.rotation = rotation;
    if body.kind() == BodyKind::Dynamic && body.mass() > 0.0 {
        def.mass = MassDef::Mass(body.mass());
    }
    Some(def)
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
        Input::Shot {
            from: vec3(0.0, 1.0, 6.0),
            velocity: vec3(0.0, 0.0, -20.0),
            radius: 0.3,
            boxed: false,
        }
    }

    #[test]
    fn going_back_and_forth_gives_the_same_bits_with_what_the_user_did() {
        let mut history = pyramid();
        let mut hashes = vec![history.now().world.state_hash()];
        for step in 0..150 {
            if step == 20 {
                history.act(shot());
            }
            history.step(&mut |_| ()).unwrap();
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
        history.act(shot());
        history.step(&mut |_| ()).unwrap();
        assert_eq!(history.furthest(), 31);
        history.seek(60).unwrap();
        assert_ne!(history.now().world.state_hash(), end);
    }

    #[test]
    fn deeds_are_seen_at_once_and_done_once() {
        let mut history = pyramid();
        history.seek(16).unwrap();
        let bodies = |h: &History| h.now().world.bodies().count();
        let (before, body) = (bodies(&history), history.now().bodies[3]);
        history.act(Input::Duplicate(body));
        history.act(Input::Remove(history.now().bodies[5]));
        history.act(shot());
        assert_eq!(bodies(&history), before + 1, "one more, one less, one shot");
        history.seek(40).unwrap();
        assert_eq!(bodies(&history), before + 1);
        let hash = history.now().world.state_hash();
        history.seek(15).unwrap();
        assert_eq!(bodies(&history), before);
        history.seek(40).unwrap();
        assert_eq!(history.now().world.state_hash(), hash);
        let fork = history.fork();
        for mut run in [history, fork] {
            run.seek(3).unwrap();
            run.seek(40).unwrap();
            assert_eq!(run.now().world.state_hash(), hash);
        }
    }

    #[test]
    fn what_is_frozen_stays_where_it_is() {
        let mut history =
            History::new(drystone_scene::named("hello").unwrap().build().unwrap(), 1.0 / 60.0);
        let world = &history.now().world;
        let ball = world.bodies().find(|b| b.kind() == drystone::BodyKind::Dynamic).unwrap();
        let (ball, at) = (ball.id(), ball.position());
        history.act(Input::Freeze(ball, true));
        history.seek(60).unwrap();
        assert_eq!(history.now().world.body(ball).unwrap().position(), at);
        history.act(Input::Freeze(ball, false));
        history.seek(90).unwrap();
        assert!(history.now().world.body(ball).unwrap().position().y < at.y - 0.1);
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
