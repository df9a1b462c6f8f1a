//! Python bindings of drystone: a thin layer over the engine and its scenes.
//!
//! Bodies go to Python as arrays of all of them. Each call checks its arguments first, then holds
//! the lock of its world, and lets other Python threads run while it steps.

mod arrays;
mod batch;
mod body;
mod errors;
mod joint;
mod joint_ref;
mod options;
mod scene;
mod shape;
mod snapshot;
mod world;

use pyo3::prelude::*;

/// The engine's half of the package.
#[pymodule(gil_used = false)]
mod _drystone {
    #[pymodule_export]
    use crate::batch::PyBatch;
    #[pymodule_export]
    use crate::body::PyBody;
    #[pymodule_export]
    use crate::errors::{DefError, SceneError, SnapshotError};
    #[pymodule_export]
    use crate::joint_ref::PyJoint;
    #[pymodule_export]
    use crate::scene::PyScene;
    #[pymodule_export]
    use crate::shape::PyShape;
    #[pymodule_export]
    use crate::snapshot::PySnapshot;
    #[pymodule_export]
    use crate::world::{PyEvents, PyHit, PyStrand, PyWorld};
    use pyo3::prelude::*;

    /// The version of the package.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
