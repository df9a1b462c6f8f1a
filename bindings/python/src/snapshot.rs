//! Snapshots: the exact state of a world.

use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::world::{PyWorld, State, executor};

/// The exact state of a world. A world that goes on from it has the same bits. It can be pickled.
#[pyclass(name = "Snapshot", module = "drystone", frozen)]
pub(crate) struct PySnapshot(Box<State>);

#[pymethods]
impl PySnapshot {
    /// The snapshot of `to_bytes()`. The bytes need not be trusted.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &Bound<'_, PyBytes>) -> PyResult<Self> {
        let bytes = data.as_bytes();
        py.detach(|| State::from_bytes(bytes)).map(Self::new)
    }

    /// The snapshot as bytes, for files and other processes.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.0.to_bytes())?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// A new world in this state; `threads`, 0: all cores.
    #[pyo3(signature = (*, threads=1))]
    fn world(&self, py: Python<'_>, threads: usize) -> PyWorld {
        let state = py.detach(|| (*self.0).clone());
        PyWorld::with(state, executor(threads))
    }

    /// Steps that its world had taken.
    #[getter]
    fn step_count(&self) -> u64 {
        self.0.run.world.step_count()
    }

    /// The hash of its world: see `World.state_hash`.
    fn state_hash(&self) -> u64 {
        self.0.run.world.state_hash()
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let make = py.get_type::<Self>().getattr("from_bytes")?;
        Ok((make, (self.to_bytes(py)?,)))
    }

    fn __repr__(&self) -> String {
        format!("<Snapshot at step {}>", self.step_count())
    }
}

impl PySnapshot {
    pub(crate) fn new(state: State) -> Self {
        Self(Box::new(state))
    }

    pub(crate) fn state(&self) -> &State {
        &self.0
    }
}
