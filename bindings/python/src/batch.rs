//! Many copies of one scene, stepped in parallel: each is an engine's world of its own.

mod slot;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use drystone::journal::{BodyCall, Call};
use drystone::threads::Executor;
use drystone::{BodyId, BodyKind, BodyRef, Vec3};
use drystone_scene::{BuildError, Scene};
use numpy::Element;
use pyo3::prelude::*;

use self::slot::Slot;
use crate::arrays::{array, mask, numbers};
use crate::errors::{bad, broken, busy, refused, scene as scene_error, unbuildable};
use crate::options::whole;
use crate::scene::{PyScene, scene_of};
use crate::snapshot::PySnapshot;
use crate::world::{PyWorld, Quantity, State, executor, time_step};

/// Time between two looks at pending signals, such as Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// Most worlds and most rows of an array.
const MOST_WORLDS: usize = 1 << 20;

/// `n` worlds of one scene, stepped in parallel. World `i` is bit for bit a single `World` to which
/// the same was done, whatever `n` and the number of threads.
///
/// Arrays have shape (n, bodies, ...), bodies in the order of the scene. A body that is gone, for
/// example because it broke, has NaN and is not `alive`; bodies that came later, such as pieces,
/// are seen in `world(i)`. `mask` is n booleans, or a list of numbers of worlds; None: all.
#[pyclass(name = "Batch", module = "drystone", frozen, weakref)]
pub(crate) struct PyBatch {
    worlds: Mutex<Worlds>,
    executor: Arc<dyn Executor>,
    scene: Arc<Scene>,
    source: String,
    bodies: Vec<BodyId>,
    count: usize,
}

struct Worlds {
    start: Slot,
    slots: Vec<Mutex<Slot>>,
}

#[pymethods]
impl PyBatch {
    /// `n` worlds of `scene` (a `Scene`, a path or a built-in name) on `threads` threads, 0: all.
    #[new]
    #[pyo3(signature = (scene, n, *, threads=0))]
    fn new(
        py: Python<'_>,
        scene: &Bound<'_, PyAny>,
        n: &Bound<'_, PyAny>,
        threads: usize,
    ) -> PyResult<Self> {
        let count: usize = whole("n", n)?;
        if count == 0 || count > MOST_WORLDS {
            return Err(bad("n", &count.to_string(), "a number from 1 to 1,048,576"));
        }
        let (scene, source) = scene_of(scene)?;
        let executor = executor(threads);
        let start = py.detach(|| State::new(Arc::clone(&scene), &source));
        let start = Slot::new(&scene, start.map_err(|e| unbuildable(&source, &e))?.run);
        let bodies: Vec<BodyId> = start.world.bodies().map(|body| body.id()).collect();
        let slots = py.detach(|| (0..count).map(|_| Mutex::new(start.clone())).collect());
        let worlds = Mutex::new(Worlds { start, slots });
        Ok(Self { worlds, executor, scene, source, bodies, count })
    }

    /// Its scene.
    #[getter]
    fn scene(&self) -> PyScene {
        PyScene { scene: Arc::clone(&self.scene), source: self.source.clone() }
    }

    /// Names of its bodies, in the order of the arrays.
    #[getter]
    fn body_names(&self) -> PyResult<Vec<String>> {
        let worlds = self.lock()?;
        let run = &worlds.start.rest;
        let name = |id: &BodyId| {
            let place = run.bodies.iter().position(|known| known == id);
            place.and_then(|place| run.names.get(place)).cloned().unwrap_or_default()
        };
        Ok(self.bodies.iter().map(name).collect())
    }

    /// Number of bodies of each world.
    #[getter]
    fn body_count(&self) -> usize {
        self.bodies.len()
    }

    /// Threads that a step uses at most.
    #[getter]
    fn threads(&self) -> usize {
        self.executor.workers()
    }

    /// Length of a step where none is given [s].
    #[getter]
    fn dt(&self) -> f32 {
        1.0 / self.scene.hz
    }

    fn __len__(&self) -> usize {
        self.count
    }

    /// Advances the chosen worlds by `n` steps of `dt` [s]; other Python threads run meanwhile.
    #[pyo3(signature = (dt=None, n=None, *, mask=None))]
    fn step(
        &self,
        py: Python<'_>,
        dt: Option<&Bound<'_, PyAny>>,
        n: Option<&Bound<'_, PyAny>>,
        mask: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let mut left: u64 = n.map_or(Ok(1), |n| whole("n", n))?;
        let dt = dt.map_or(Ok(self.dt()), time_step)?;
        let chosen = self.chosen(mask)?;
        let guard = self.lock()?;
        let slots = &guard.slots;
        // A round is as many steps of every world as fit the time between two looks. A world finds
        // its own data in the cache when it steps several times in a row.
        let mut round = 4;
        while left > 0 {
            let steps = left.min(round);
            let start = Instant::now();
            let failed = py.detach(|| self.advance(slots, &chosen, dt, steps));
            if let Some((number, error)) = failed {
                let problem = format!("world {number}: {error}");
                let text = format!("{}: {problem}", self.source);
                return Err(scene_error(&text, &self.source, "", &problem, ""));
            }
            left -= steps;
            if start.elapsed() < LOOK / 2 {
                round *= 2;
            }
            py.check_signals()?;
        }
        Ok(())
    }

    /// Puts the chosen worlds back to the start of the scene.
    #[pyo3(signature = (mask=None))]
    fn reset(&self, py: Python<'_>, mask: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let chosen = self.chosen(mask)?;
        let guard = self.lock()?;
        let worlds = &*guard;
        py.detach(|| {
            self.executor.run(chosen.len(), &|_, chunk| {
                slot(&worlds.slots[chosen[chunk]]).clone_from(&worlds.start);
            });
        });
        Ok(())
    }

    /// Steps that each world has taken (n,), uint64.
    #[getter]
    fn step_count<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, |slot| slot.world.step_count())
    }

    /// A hash of the bits of all poses and velocities of each world (n,), uint64.
    fn state_hash<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, |slot| slot.world.state_hash())
    }

    /// Positions of the bodies' origins (n, bodies, 3) [m, world], float32; a copy.
    ///
    /// To set them, assign an array of the same shape: rows that differ move their body there.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.read(py, Quantity::Position)
    }

    #[setter]
    fn set_positions(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_state(py, Some(value), None, None, None, None)
    }

    /// Rotations (n, bodies, 4) [w, x, y, z]; a copy, assignable like `positions`.
    #[getter]
    fn rotations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.read(py, Quantity::Rotation)
    }

    #[setter]
    fn set_rotations(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_state(py, None, Some(value), None, None, None)
    }

    /// Velocities of the centers of mass (n, bodies, 3) [m/s, world]; a copy, assignable.
    #[getter]
    fn linear_velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.read(py, Quantity::LinearVelocity)
    }

    #[setter]
    fn set_linear_velocities(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_state(py, None, None, Some(value), None, None)
    }

    /// Angular velocities (n, bodies, 3) [rad/s, world]; a copy, assignable.
    #[getter]
    fn angular_velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.read(py, Quantity::AngularVelocity)
    }

    #[setter]
    fn set_angular_velocities(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_state(py, None, None, None, Some(value), None)
    }

    /// Whether each body is there (n, bodies), bool.
    #[getter]
    fn alive<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.cells(py, |body| body.is_some())
    }

    /// Whether each body sleeps (n, bodies), bool.
    #[getter]
    fn asleep<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.cells(py, |body| body.is_some_and(|body| body.is_asleep()))
    }

    /// Sets states of bodies in the chosen worlds: arrays (n, bodies, 3 or 4), of which rows of
    /// other worlds are not looked at. All or nothing is set.
    #[pyo3(signature = (positions=None, rotations=None, linear_velocities=None, angular_velocities=None, mask=None))]
    fn set_state(
        &self,
        py: Python<'_>,
        positions: Option<&Bound<'_, PyAny>>,
        rotations: Option<&Bound<'_, PyAny>>,
        linear_velocities: Option<&Bound<'_, PyAny>>,
        angular_velocities: Option<&Bound<'_, PyAny>>,
        mask: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let chosen = self.chosen(mask)?;
        let mut given = Vec::new();
        for (quantity, value) in [
            (Quantity::Position, positions),
            (Quantity::Rotation, rotations),
            (Quantity::LinearVelocity, linear_velocities),
            (Quantity::AngularVelocity, angular_velocities),
        ] {
            if let Some(value) = value {
                let shape = [self.count, self.bodies.len(), quantity.columns()];
                given.push((quantity, numbers(quantity.name(), value, &shape)?));
            }
        }
        let guard = self.lock()?;
        let slots = &guard.slots;
        py.detach(|| self.assign(slots, &chosen, &given))
    }

    /// Sets the forces [N, world] and torques [N m, world] that act on the bodies of the chosen
    /// worlds in every step from now on: arrays (n, bodies, 3). Bodies that are not dynamic take 0.
    ///
    /// A force beyond 1e10 m/s² is refused at its body; those before it are set then.
    #[pyo3(signature = (forces=None, torques=None, *, mask=None))]
    fn set_forces(
        &self,
        py: Python<'_>,
        forces: Option<&Bound<'_, PyAny>>,
        torques: Option<&Bound<'_, PyAny>>,
        mask: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let chosen = self.chosen(mask)?;
        let shape = [self.count, self.bodies.len(), 3];
        let read = |name: &str, value: Option<&Bound<'_, PyAny>>| {
            value.map(|value| numbers(name, value, &shape)).transpose()
        };
        let (forces, torques) = (read("forces", forces)?, read("torques", torques)?);
        let guard = self.lock()?;
        let slots = &guard.slots;
        py.detach(|| {
            if let Some(forces) = &forces {
                self.push(slots, &chosen, forces, "forces", BodyCall::SetLastingForce)?;
            }
            torques.as_ref().map_or(Ok(()), |torques| {
                self.push(slots, &chosen, torques, "torques", BodyCall::SetLastingTorque)
            })
        })
    }

    /// World `i` as a `World` of its own, which goes on from here.
    #[pyo3(signature = (i, *, threads=1))]
    fn world(&self, i: &Bound<'_, PyAny>, threads: usize) -> PyResult<PyWorld> {
        Ok(PyWorld::with(self.state_of(i)?, executor(threads)))
    }

    /// The exact state of world `i`.
    fn snapshot(&self, i: &Bound<'_, PyAny>) -> PyResult<PySnapshot> {
        Ok(PySnapshot::new(self.state_of(i)?))
    }

    /// Puts world `i` into the state of a snapshot of a world of the same scene.
    fn restore(&self, i: &Bound<'_, PyAny>, snapshot: &Bound<'_, PySnapshot>) -> PyResult<()> {
        let i = self.number("i", i)?;
        let run = &snapshot.get().state().run;
        let worlds = self.lock()?;
        let own = &worlds.start.rest;
        let is_of_scene = run.bodies.starts_with(&own.bodies) && run.names.starts_with(&own.names);
        if !is_of_scene {
            let allowed = "a snapshot of a world of this batch's scene";
            return Err(bad("snapshot", "one with other bodies", allowed));
        }
        slot(&worlds.slots[i]).take(run);
        Ok(())
    }

    /// Makes world `target`, or each of a list, a copy of world `source`.
    fn copy(&self, source: &Bound<'_, PyAny>, target: &Bound<'_, PyAny>) -> PyResult<()> {
        let from = self.number("source", source)?;
        let targets = match target.extract::<i64>() {
            Ok(_) => vec![self.number("target", target)?],
            Err(_) => self.numbers_of("target", Some(target))?,
        };
        let worlds = self.lock()?;
        let from = slot(&worlds.slots[from]).clone();
        for to in targets {
            slot(&worlds.slots[to]).clone_from(&from);
        }
        Ok(())
    }

    fn __repr__(&self) -> String {
        let (n, bodies) = (self.count, self.bodies.len());
        format!("<Batch of {n} worlds '{}' of {bodies} bodies>", self.scene.name)
    }
}

impl PyBatch {
    fn lock(&self) -> PyResult<MutexGuard<'_, Worlds>> {
        match self.worlds.try_lock() {
            Ok(worlds) => Ok(worlds),
            Err(TryLockError::WouldBlock) => Err(busy("batch")),
            Err(TryLockError::Poisoned(_)) => Err(broken("batch")),
        }
    }

    fn number(&self, field: &str, value: &Bound<'_, PyAny>) -> PyResult<usize> {
        let number: usize = whole(field, value)?;
        if number < self.count {
            return Ok(number);
        }
        Err(bad(field, &number.to_string(), &format!("a number from 0 to {}", self.count - 1)))
    }

    fn chosen(&self, mask: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<usize>> {
        self.numbers_of("mask", mask)
    }

    fn numbers_of(&self, field: &str, value: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<usize>> {
        let chosen = mask(field, value, self.count)?;
        Ok(chosen.iter().enumerate().filter(|(_, is)| **is).map(|(i, _)| i).collect())
    }

    /// Steps the chosen worlds; returns the failure of the first world that has one.
    fn advance(
        &self,
        slots: &[Mutex<Slot>],
        chosen: &[usize],
        dt: f32,
        steps: u64,
    ) -> Option<(usize, BuildError)> {
        let failed: Mutex<Option<(usize, BuildError)>> = Mutex::new(None);
        // A few worlds at once: fewer claims, and still enough pieces for a slow core.
        let piece = chosen.len().div_ceil(self.executor.workers() * 16).clamp(1, 64);
        self.executor.run(chosen.len().div_ceil(piece), &|_, chunk| {
            for number in chosen.iter().skip(chunk * piece).take(piece) {
                if let Err(error) = slot(&slots[*number]).advance(dt, steps) {
                    let mut first = failed.lock().unwrap_or_else(PoisonError::into_inner);
                    if first.as_ref().is_none_or(|(known, _)| number < known) {
                        *first = Some((*number, error));
                    }
                }
            }
        });
        failed.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    fn assign(
        &self,
        slots: &[Mutex<Slot>],
        chosen: &[usize],
        given: &[(Quantity, Vec<f32>)],
    ) -> PyResult<()> {
        let size = self.bodies.len();
        for (quantity, numbers) in given {
            let columns = quantity.columns();
            for number in chosen {
                let world = &slot(&slots[*number]).world;
                for (k, id) in self.bodies.iter().enumerate() {
                    let row = number * size + k;
                    quantity.check(world, *id, &numbers[row * columns..][..columns], row)?;
                }
            }
        }
        for number in chosen {
            let world = &mut slot(&slots[*number]).world;
            for (quantity, numbers) in given {
                let columns = quantity.columns();
                for (k, id) in self.bodies.iter().enumerate() {
                    let row = &numbers[(number * size + k) * columns..][..columns];
                    quantity.set(world, *id, row).map_err(|e| refused(&e))?;
                }
            }
        }
        Ok(())
    }

    fn push(
        &self,
        slots: &[Mutex<Slot>],
        chosen: &[usize],
        numbers: &[f32],
        field: &str,
        call: fn(Vec3) -> BodyCall,
    ) -> PyResult<()> {
        let size = self.bodies.len();
        let rows = numbers.as_chunks::<3>().0;
        for number in chosen {
            let world = &slot(&slots[*number]).world;
            for (k, id) in self.bodies.iter().enumerate() {
                let row = rows[number * size + k];
                let is_dynamic = world.body(*id).is_some_and(|b| b.kind() == BodyKind::Dynamic);
                let allowed = if !row.iter().all(|x| x.is_finite()) {
                    "finite numbers"
                } else if !is_dynamic && row.iter().any(|x| x.abs() > 0.0) {
                    "0 for a body that is not dynamic, or gone"
                } else {
                    continue;
                };
                let place = format!("{field}[{number}, {k}]");
                return Err(bad(&place, &format!("{row:?}"), allowed));
            }
        }
        for number in chosen {
            let world = &mut slot(&slots[*number]).world;
            for (k, id) in self.bodies.iter().enumerate() {
                if world.body(*id).is_some_and(|body| body.kind() == BodyKind::Dynamic) {
                    let row = Vec3::from(rows[number * size + k]);
                    world.apply(&Call::Body(*id, call(row))).map_err(|e| refused(&e))?;
                }
            }
        }
        Ok(())
    }

    fn read<'py>(&self, py: Python<'py>, quantity: Quantity) -> PyResult<Bound<'py, PyAny>> {
        let columns = quantity.columns();
        let numbers = {
            let guard = self.lock()?;
            let slots = &guard.slots;
            py.detach(|| {
                let mut numbers = Vec::with_capacity(self.count * self.bodies.len() * columns);
                for one in slots {
                    let world = &slot(one).world;
                    for id in &self.bodies {
                        let row = world.body(*id).map_or([f32::NAN; 4], |b| quantity.get(b));
                        numbers.extend_from_slice(&row[..columns]);
                    }
                }
                numbers
            })
        };
        array(py, numbers, &[self.count, self.bodies.len(), columns])
    }

    fn cells<'py, T: Element>(
        &self,
        py: Python<'py>,
        cell: impl Fn(Option<BodyRef<'_>>) -> T,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut cells = Vec::with_capacity(self.count * self.bodies.len());
        for one in &self.lock()?.slots {
            let world = &slot(one).world;
            cells.extend(self.bodies.iter().map(|id| cell(world.body(*id))));
        }
        array(py, cells, &[self.count, self.bodies.len()])
    }

    fn column<'py, T: Element>(
        &self,
        py: Python<'py>,
        item: impl Fn(&Slot) -> T,
    ) -> PyResult<Bound<'py, PyAny>> {
        let items: Vec<T> = self.lock()?.slots.iter().map(|one| item(&slot(one))).collect();
        array(py, items, &[self.count])
    }

    fn state_of(&self, i: &Bound<'_, PyAny>) -> PyResult<State> {
        let i = self.number("i", i)?;
        let worlds = self.lock()?;
        let run = slot(&worlds.slots[i]).running();
        Ok(State::of(Arc::clone(&self.scene), &self.source, run))
    }
}

/// A world of the batch. A panic in it leaves the whole batch unusable: see [`PyBatch::lock`].
fn slot(one: &Mutex<Slot>) -> MutexGuard<'_, Slot> {
    one.lock().unwrap_or_else(PoisonError::into_inner)
}
