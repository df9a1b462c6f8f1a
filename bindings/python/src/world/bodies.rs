//! The bodies of a world as arrays.

use drystone::limits::{self, Limit};
use drystone::{BodyId, BodyKind, Pose, Quat, Vec3, World};
use pyo3::prelude::*;

use super::PyWorld;
use crate::arrays::{array, numbers, wxyz};
use crate::body::PyBody;
use crate::errors::{bad, refused};

#[pymethods]
impl PyWorld {
    /// Number of bodies.
    #[getter]
    fn body_count(&self) -> PyResult<usize> {
        Ok(count(&self.lock()?.run.world))
    }

    /// All bodies, in the order of the arrays.
    #[getter]
    fn bodies(slf: &Bound<'_, Self>) -> PyResult<Vec<PyBody>> {
        let ids: Vec<BodyId> = slf.get().lock()?.run.world.bodies().map(|b| b.id()).collect();
        Ok(ids.into_iter().map(|id| PyBody { world: slf.clone().unbind(), id }).collect())
    }

    /// Ids of the bodies (n,), uint64: the order of the rows of all arrays.
    #[getter]
    fn body_ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let ids: Vec<u64> = self.lock()?.run.world.bodies().map(|b| b.id().to_bits()).collect();
        let n = ids.len();
        array(py, ids, &[n])
    }

    /// Names of the bodies, in the order of the arrays; empty where a body has none.
    #[getter]
    fn body_names(&self) -> PyResult<Vec<String>> {
        let state = self.lock()?;
        let mut names = std::collections::BTreeMap::new();
        names.extend(state.run.bodies.iter().zip(&state.run.names));
        names.extend(state.names.iter().map(|(name, id)| (id, name)));
        let bodies = state.run.world.bodies();
        Ok(bodies.map(|b| names.get(&b.id()).map_or_else(String::new, |n| (*n).clone())).collect())
    }

    /// Positions of the bodies' origins (n, 3) [m, world], float32; a copy.
    ///
    /// To set them, assign an array of the same shape: rows that differ move their body there.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.rows(py, |b| b.position().to_array())
    }

    #[setter]
    fn set_positions(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(value, Quantity::Position)
    }

    /// Rotations (n, 4) [w, x, y, z], unit quaternions; a copy, assignable like `positions`.
    #[getter]
    fn rotations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.rows(py, |b| wxyz(b.rotation()))
    }

    #[setter]
    fn set_rotations(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(value, Quantity::Rotation)
    }

    /// Velocities of the centers of mass (n, 3) [m/s, world]; a copy, assignable like `positions`.
    #[getter]
    fn linear_velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.rows(py, |b| b.linear_velocity().to_array())
    }

    #[setter]
    fn set_linear_velocities(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(value, Quantity::LinearVelocity)
    }

    /// Angular velocities (n, 3) [rad/s, world]; a copy, assignable like `positions`.
    #[getter]
    fn angular_velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.rows(py, |b| b.angular_velocity().to_array())
    }

    #[setter]
    fn set_angular_velocities(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.assign(value, Quantity::AngularVelocity)
    }

    /// Positions of the centers of mass (n, 3) [m, world]; a copy.
    #[getter]
    fn centers_of_mass<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.rows(py, |b| b.center_of_mass().to_array())
    }

    /// Masses (n,) [kg]; 0 for static and kinematic bodies.
    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, |b| b.mass())
    }

    /// Whether each body sleeps (n,), bool.
    #[getter]
    fn asleep<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, |b| b.is_asleep())
    }

    /// Whether each body is dynamic (n,), bool.
    #[getter]
    fn dynamic<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, |b| b.kind() == BodyKind::Dynamic)
    }
}

impl PyWorld {
    fn rows<'py, const N: usize>(
        &self,
        py: Python<'py>,
        row: impl Fn(drystone::BodyRef<'_>) -> [f32; N],
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut numbers = Vec::new();
        let state = self.lock()?;
        for body in state.run.world.bodies() {
            numbers.extend_from_slice(&row(body));
        }
        drop(state);
        let n = numbers.len() / N;
        array(py, numbers, &[n, N])
    }

    fn column<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        item: impl Fn(drystone::BodyRef<'_>) -> T,
    ) -> PyResult<Bound<'py, PyAny>> {
        let items: Vec<T> = self.lock()?.run.world.bodies().map(item).collect();
        let n = items.len();
        array(py, items, &[n])
    }

    fn assign(&self, value: &Bound<'_, PyAny>, quantity: Quantity) -> PyResult<()> {
        let n = count(&self.lock()?.run.world);
        let numbers = numbers(quantity.name(), value, &[n, quantity.columns()])?;
        let mut state = self.lock()?;
        let world = &mut state.run.world;
        let ids: Vec<BodyId> = world.bodies().map(|body| body.id()).collect();
        let rows = || ids.iter().zip(numbers.chunks_exact(quantity.columns()));
        for (i, (id, row)) in rows().enumerate() {
            quantity.check(world, *id, row, i)?;
        }
        for (id, row) in rows() {
            quantity.set(world, *id, row).map_err(|e| refused(&e))?;
        }
        Ok(())
    }
}

fn count(world: &World) -> usize {
    world.bodies().count()
}

/// A quantity of all bodies that can be assigned.
#[derive(Clone, Copy)]
pub(crate) enum Quantity {
    Position,
    Rotation,
    LinearVelocity,
    AngularVelocity,
}

impl Quantity {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Position => "positions",
            Self::Rotation => "rotations",
            Self::LinearVelocity => "linear_velocities",
            Self::AngularVelocity => "angular_velocities",
        }
    }

    pub(crate) const fn columns(self) -> usize {
        if matches!(self, Self::Rotation) { 4 } else { 3 }
    }

    const fn limit(self) -> Limit {
        match self {
            Self::Position => limits::POSITION,
            _ => limits::SPEED,
        }
    }

    /// The row of a body, and in the last column of short rows 0.
    pub(crate) fn get(self, body: drystone::BodyRef<'_>) -> [f32; 4] {
        let [x, y, z] = match self {
            Self::Rotation => return wxyz(body.rotation()),
            Self::Position => body.position().to_array(),
            Self::LinearVelocity => body.linear_velocity().to_array(),
            Self::AngularVelocity => body.angular_velocity().to_array(),
        };
        [x, y, z, 0.0]
    }

    /// Whether a row differs from that of the body, bit by bit.
    pub(crate) fn differs(self, body: drystone::BodyRef<'_>, row: &[f32]) -> bool {
        let now = self.get(body);
        now.iter().zip(row).any(|(a, b)| a.to_bits() != b.to_bits())
    }

    /// Checks a row that differs, so that an assignment is made as a whole or not at all.
    pub(crate) fn check(
        self,
        world: &World,
        id: BodyId,
        row: &[f32],
        number: usize,
    ) -> PyResult<()> {
        if !world.body(id).is_some_and(|body| self.differs(body, row)) {
            return Ok(());
        }
        let (is_good, allowed) = match self {
            Self::Rotation => {
                let square: f32 = row.iter().map(|x| x * x).sum();
                (UNIT.contains(&square), "a unit quaternion [w, x, y, z]")
            }
            _ => (row.iter().all(|x| self.limit().admits(*x)), self.limit().allowed),
        };
        if is_good {
            return Ok(());
        }
        Err(bad(&format!("{}[{number}]", self.name()), &format!("{row:?}"), allowed))
    }

    /// Sets the row of one body. A body whose numbers are these already is not woken.
    pub(crate) fn set(
        self,
        world: &mut World,
        id: BodyId,
        row: &[f32],
    ) -> Result<(), drystone::DefError> {
        let Some(mut body) = world.body_mut(id) else { return Ok(()) };
        let now = body.get();
        if !self.differs(now, row) {
            return Ok(());
        }
        let mut pose = Pose { position: now.position(), rotation: now.rotation() };
        let (mut v, mut w) = (now.linear_velocity(), now.angular_velocity());
        match (self, row) {
            (Self::Position, &[x, y, z]) => pose.position = Vec3::from([x, y, z]),
            (Self::Rotation, &[w, x, y, z]) => pose.rotation = Quat::new(x, y, z, w),
            (Self::LinearVelocity, &[x, y, z]) => v = Vec3::from([x, y, z]),
            (Self::AngularVelocity, &[x, y, z]) => w = Vec3::from([x, y, z]),
            _ => return Ok(()),
        }
        body.correct_state(pose, v, w).map(|_| ())
    }
}

/// Squared lengths of quaternions that the engine takes for unit ones, and normalizes.
const UNIT: core::ops::Range<f32> = 0.9..1.1;
