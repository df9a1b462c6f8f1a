//! A world: one simulation.

mod add;
mod bodies;
mod particles;
mod queries;
mod reports;
mod state;

use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use std::time::{Duration, Instant};

use drystone::journal::{Answer, BodyCall, Call, JointCall};
use drystone::threads::{Executor, Inline, Team};
use drystone::{BodyId, JointId, WorldConfig, limits};
use drystone_scene::Scene;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};

use crate::arrays::{reals, shown, vector};
use crate::body::PyBody;
use crate::errors::{bad, broken, busy, missing, refused, unbuildable};
use crate::joint_ref::PyJoint;
use crate::options::whole;
use crate::scene::{PyScene, scene_of};
use crate::snapshot::PySnapshot;

pub(crate) use self::add::fracture;
pub(crate) use self::bodies::Quantity;
pub(crate) use self::particles::PyStrand;
pub(crate) use self::queries::PyHit;
pub(crate) use self::reports::PyEvents;
pub(crate) use self::state::State;

/// Time between two looks at pending signals, such as Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// One simulation: empty, to be built by hand, or of a scene.
///
/// Arrays have one row for each body, in the order of `body_ids`: for a scene without removals, the
/// order of the scene. Rotations are [w, x, y, z].
#[pyclass(name = "World", module = "drystone", frozen, weakref)]
pub(crate) struct PyWorld {
    state: Mutex<State>,
    executor: Arc<dyn Executor>,
}

#[pymethods]
impl PyWorld {
    /// A world of `scene` (a `Scene`, a path or a built-in name), or an empty one.
    ///
    /// `gravity` [m/s², world]; `threads`, 0: all cores, the results are the same for any number;
    /// `method` by name, such as 'soft-step'; `substeps`, 0: the method's own; `config`, a dict of
    /// paths such as 'contact.hertz' and values.
    #[new]
    #[pyo3(signature = (scene=None, *, gravity=None, threads=1, method=None, substeps=None, config=None))]
    fn new(
        py: Python<'_>,
        scene: Option<&Bound<'_, PyAny>>,
        gravity: Option<&Bound<'_, PyAny>>,
        threads: usize,
        method: Option<&Bound<'_, PyAny>>,
        substeps: Option<&Bound<'_, PyAny>>,
        config: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let (mut scene, source) = match scene {
            Some(scene) => scene_of(scene)?,
            None => (Arc::new(Scene::new("", "")), String::new()),
        };
        let mut settings = scene.config.clone();
        for (path, value) in [("method", method), ("substeps", substeps)] {
            if let Some(value) = value {
                set(&mut settings, path, value)?;
            }
        }
        for (path, value) in config.into_iter().flat_map(|config| config.iter()) {
            let path: String = path.extract()?;
            set(&mut settings, &path, &value)?;
        }
        if let Some(gravity) = gravity {
            settings.gravity = vector("gravity", gravity)?;
        }
        settings.validate().map_err(|e| refused(&e))?;
        if settings != scene.config {
            scene = Arc::new(Scene { config: settings, ..(*scene).clone() });
        }
        let state = py.detach(|| State::new(scene, &source));
        let state = state.map_err(|e| unbuildable(&source, &e))?;
        Ok(Self::with(state, executor(threads)))
    }

    /// Advances time by `n` steps (1) of `dt` [s]; `dt` is that of the scene where it is not given.
    ///
    /// Other Python threads run meanwhile. Events are those of the last step. Ctrl-C stops between
    /// two steps.
    #[pyo3(signature = (dt=None, n=None))]
    fn step(
        &self,
        py: Python<'_>,
        dt: Option<&Bound<'_, PyAny>>,
        n: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let mut left: u64 = n.map_or(Ok(1), |n| whole("n", n))?;
        let given = dt.map(time_step).transpose()?;
        let mut guard = self.lock()?;
        let state = &mut *guard;
        let dt = given.unwrap_or_else(|| state.dt());
        loop {
            let done = py.detach(|| {
                let start = Instant::now();
                while left > 0 {
                    state.run.step(dt)?;
                    left -= 1;
                    if start.elapsed() > LOOK {
                        break;
                    }
                }
                Ok(())
            });
            done.map_err(|e| unbuildable(&state.source, &e))?;
            if left == 0 {
                return Ok(());
            }
            py.check_signals()?;
        }
    }

    /// Length of a step where none is given [s].
    #[getter]
    fn dt(&self) -> PyResult<f32> {
        Ok(self.lock()?.dt())
    }

    /// The scene that it was made of; an empty one for a world built by hand.
    #[getter]
    fn scene(&self) -> PyResult<PyScene> {
        let state = self.lock()?;
        Ok(PyScene { scene: Arc::clone(&state.scene), source: state.source.clone() })
    }

    /// Threads that a step uses at most.
    #[getter]
    fn threads(&self) -> usize {
        self.executor.workers()
    }

    /// Steps taken so far.
    #[getter]
    fn step_count(&self) -> PyResult<u64> {
        Ok(self.lock()?.run.world.step_count())
    }

    /// Acceleration of free bodies [m/s², world].
    #[getter]
    fn gravity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let gravity = self.lock()?.run.world.config().gravity;
        crate::arrays::vec_out(py, gravity)
    }

    #[setter]
    fn set_gravity(&self, gravity: &Bound<'_, PyAny>) -> PyResult<()> {
        let gravity = vector("gravity", gravity)?;
        self.apply(&Call::SetGravity(gravity)).map(|_| ())
    }

    /// Sets the setting at a path such as 'contact.hertz'.
    fn set_config(&self, path: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let text = config_text(value)?;
        let world = &mut self.lock()?.run.world;
        let mut config = world.config().clone();
        config.set(path, &text).and_then(|()| world.set_config(config)).map_err(|e| refused(&e))
    }

    /// The paths of `set_config` and of the keyword `config`.
    #[staticmethod]
    fn config_paths() -> Vec<&'static str> {
        WorldConfig::PATHS.to_vec()
    }

    /// A hash of the bits of all poses and velocities: equal runs give equal hashes, on any machine
    /// and with any number of threads.
    fn state_hash(&self) -> PyResult<u64> {
        Ok(self.lock()?.run.world.state_hash())
    }

    /// The state, exact to the bit, to restore this world or another one. Cheap: a copy in memory;
    /// `to_bytes()` and pickle store it.
    fn snapshot(&self, py: Python<'_>) -> PyResult<PySnapshot> {
        let guard = self.lock()?;
        let state = &*guard;
        let mut copy = py.detach(|| state.clone());
        copy.run.world.set_executor(Arc::new(Inline));
        Ok(PySnapshot::new(copy))
    }

    /// Goes on from a snapshot, with the same bits. Bodies and other objects keep their ids.
    fn restore(&self, py: Python<'_>, snapshot: &Bound<'_, PySnapshot>) -> PyResult<()> {
        let mut guard = self.lock()?;
        let (state, saved) = (&mut *guard, snapshot.get().state());
        py.detach(|| {
            *state = saved.clone();
            state.run.world.set_executor(Arc::clone(&self.executor));
        });
        Ok(())
    }

    /// A world that goes on from here on its own, with as many threads.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let guard = self.lock()?;
        let state = &*guard;
        let copy = py.detach(|| state.clone());
        Ok(Self::with(copy, executor(self.executor.workers())))
    }

    fn __copy__(&self, py: Python<'_>) -> PyResult<Self> {
        self.copy(py)
    }

    fn __deepcopy__(&self, py: Python<'_>, memo: &Bound<'_, PyAny>) -> PyResult<Self> {
        let _ = memo;
        self.copy(py)
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (PySnapshot, usize))> {
        let make = py.get_type::<Self>().getattr("_from_pickle")?;
        Ok((make, (self.snapshot(py)?, self.executor.workers())))
    }

    #[staticmethod]
    fn _from_pickle(py: Python<'_>, snapshot: &Bound<'_, PySnapshot>, threads: usize) -> Self {
        let saved = snapshot.get().state();
        let state = py.detach(|| saved.clone());
        Self::with(state, executor(threads))
    }

    /// Wakes all bodies and particles.
    fn wake_all(&self) -> PyResult<()> {
        self.apply(&Call::WakeAll).map(|_| ())
    }

    fn __repr__(&self) -> String {
        let Ok(state) = self.lock() else { return "<World in use>".to_owned() };
        let counts = state.run.world.counts();
        let bodies = counts.fixed + counts.kinematic + counts.dynamic;
        format!("<World: {bodies} bodies, step {}>", state.run.world.step_count())
    }
}

impl PyWorld {
    pub(crate) fn with(mut state: State, executor: Arc<dyn Executor>) -> Self {
        state.run.world.set_executor(Arc::clone(&executor));
        Self { state: Mutex::new(state), executor }
    }

    /// The state, unless another thread holds it.
    pub(crate) fn lock(&self) -> PyResult<MutexGuard<'_, State>> {
        match self.state.try_lock() {
            Ok(state) => Ok(state),
            Err(TryLockError::WouldBlock) => Err(busy("world")),
            Err(TryLockError::Poisoned(_)) => Err(broken("world")),
        }
    }

    /// Makes a call of the engine.
    pub(crate) fn apply(&self, call: &Call) -> PyResult<Answer> {
        self.lock()?.run.world.apply(call).map_err(|e| refused(&e))
    }

    pub(crate) fn call_body(&self, id: BodyId, call: BodyCall) -> PyResult<()> {
        match self.apply(&Call::Body(id, call))? {
            Answer::Nothing => Err(gone("body", id.to_bits())),
            _ => Ok(()),
        }
    }

    pub(crate) fn call_joint(&self, id: JointId, call: JointCall) -> PyResult<()> {
        match self.apply(&Call::Joint(id, call))? {
            Answer::Nothing => Err(gone("joint", id.to_bits())),
            _ => Ok(()),
        }
    }
}

/// The exception of an object that is no longer there.
pub(crate) fn gone(what: &str, bits: u64) -> PyErr {
    missing(what, &format!("id {bits:#x}, which is not there"), &format!("a {what} of this world"))
}

/// The id of a body: a `Body` of this world, its id, or its name.
pub(crate) fn body_id(
    world: &Bound<'_, PyWorld>,
    field: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<BodyId> {
    let absent = || missing(field, &shown(value), "a body of this world");
    if let Ok(body) = value.cast::<PyBody>() {
        let body = body.get();
        return if body.world.is(world) { Ok(body.id) } else { Err(absent()) };
    }
    if let Ok(name) = value.cast::<PyString>() {
        return world.get().lock()?.named(&name.to_string_lossy()).ok_or_else(absent);
    }
    let bits: u64 = value
        .extract()
        .map_err(|_| crate::arrays::wrong_type(field, value, "a Body, its id or its name"))?;
    let id = BodyId::from_bits(bits).ok_or_else(absent)?;
    let there = world.get().lock()?.run.world.body(id).is_some();
    if there { Ok(id) } else { Err(absent()) }
}

/// The id of a joint: a `Joint` of this world, or its id.
pub(crate) fn joint_id(
    world: &Bound<'_, PyWorld>,
    field: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<JointId> {
    let absent = || missing(field, &shown(value), "a joint of this world");
    if let Ok(joint) = value.cast::<PyJoint>() {
        let joint = joint.get();
        return if joint.world.is(world) { Ok(joint.id) } else { Err(absent()) };
    }
    let bits: u64 = value
        .extract()
        .map_err(|_| crate::arrays::wrong_type(field, value, "a Joint or its id"))?;
    JointId::from_bits(bits).ok_or_else(absent)
}

/// Threads for one world.
pub(crate) fn executor(threads: usize) -> Arc<dyn Executor> {
    let all = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = if threads == 0 { all() } else { threads };
    if threads > 1 { Arc::new(Team::new(threads)) } else { Arc::new(Inline) }
}

/// The length of a step [s].
pub(crate) fn time_step(value: &Bound<'_, PyAny>) -> PyResult<f32> {
    let dt = crate::arrays::real("dt", value)?;
    if limits::TIME_STEP.admits(dt) {
        return Ok(dt);
    }
    Err(bad("dt", &dt.to_string(), limits::TIME_STEP.allowed))
}

fn set(config: &mut WorldConfig, path: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
    config.set(path, &config_text(value)?).map_err(|e| refused(&e))
}

/// A value of the configuration as the engine's text.
fn config_text(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(flag.is_true().to_string());
    }
    if value.is_instance_of::<PyString>() || value.extract::<f64>().is_ok() {
        return Ok(value.str()?.to_string());
    }
    let [x, y, z] = reals::<3>("config", value)?;
    Ok(format!("{x},{y},{z}"))
}
