//! A joint of a world.

use drystone::journal::{Answer, AxisCall, Call, JointCall};
use drystone::{Axis, JointKind, JointRef};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{real, rotation, vec_out};
use crate::body::PyBody;
use crate::joint::{axis_named, spring_def};
use crate::world::{PyWorld, gone};

/// A joint or coupling of a world, by its id.
#[pyclass(name = "Joint", module = "drystone", frozen)]
pub(crate) struct PyJoint {
    pub(crate) world: Py<PyWorld>,
    pub(crate) id: drystone::JointId,
}

impl PyJoint {
    fn read<T>(&self, read: impl FnOnce(JointRef<'_>) -> T) -> PyResult<T> {
        let state = self.world.get().lock()?;
        let joint = state.run.world.joint(self.id);
        joint.map(read).ok_or_else(|| gone("joint", self.id.to_bits()))
    }

    fn call(&self, call: JointCall) -> PyResult<()> {
        self.world.get().call_joint(self.id, call)
    }

    fn call_axis(&self, axis: Option<&Bound<'_, PyAny>>, call: AxisCall) -> PyResult<()> {
        let axis = axis.map(|axis| axis_named("axis", axis)).transpose()?;
        self.call(JointCall::Axis(axis, call))
    }

    fn axis_value(
        &self,
        axis: Option<&Bound<'_, PyAny>>,
        read: impl FnOnce(drystone::joint::AxisRef<'_>) -> f32,
    ) -> PyResult<Option<f32>> {
        let axis: Option<Axis> = axis.map(|axis| axis_named("axis", axis)).transpose()?;
        self.read(|joint| {
            let found = match axis {
                Some(axis) => joint.axis(axis),
                None => joint.hinge().or_else(|| joint.slider()),
            };
            found.map(read)
        })
    }
}

#[pymethods]
impl PyJoint {
    /// Its id, a number that no later joint of this world has.
    #[getter]
    fn id(&self) -> u64 {
        self.id.to_bits()
    }

    /// Its world.
    #[getter]
    fn world(&self, py: Python<'_>) -> Py<PyWorld> {
        self.world.clone_ref(py)
    }

    /// Whether it is still in its world: joints that break are removed.
    #[getter]
    fn exists(&self) -> PyResult<bool> {
        Ok(self.world.get().lock()?.run.world.joint(self.id).is_some())
    }

    /// 'ball', 'distance', 'six_dof', 'pulley' or 'coupling': most kinds are joints of six axes.
    #[getter]
    fn kind(&self) -> PyResult<&'static str> {
        self.read(|joint| match joint.kind() {
            JointKind::Ball => "ball",
            JointKind::Distance { .. } => "distance",
            JointKind::SixDof(_) => "six_dof",
            JointKind::Pulley(_) => "pulley",
            JointKind::Coupling(_) => "coupling",
            _ => "other",
        })
    }

    /// Its first body.
    #[getter]
    fn body_a(&self, py: Python<'_>) -> PyResult<PyBody> {
        Ok(PyBody { world: self.world.clone_ref(py), id: self.read(|joint| joint.body_a())? })
    }

    /// Its second body.
    #[getter]
    fn body_b(&self, py: Python<'_>) -> PyResult<PyBody> {
        Ok(PyBody { world: self.world.clone_ref(py), id: self.read(|joint| joint.body_b())? })
    }

    /// Its anchor on the first body (3,) [m, world].
    #[getter]
    fn anchor_a<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vec_out(py, self.read(|joint| joint.anchor_a())?)
    }

    /// Its anchor on the second body (3,) [m, world].
    #[getter]
    fn anchor_b<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vec_out(py, self.read(|joint| joint.anchor_b())?)
    }

    /// Distance of its anchors [m].
    #[getter]
    fn length(&self) -> PyResult<f32> {
        self.read(|joint| joint.length())
    }

    /// Force on its second body (3,) [N, world].
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vec_out(py, self.read(|joint| joint.force())?)
    }

    /// Torque on its second body (3,) [N m, world].
    #[getter]
    fn torque<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vec_out(py, self.read(|joint| joint.torque())?)
    }

    /// Its linear error [m].
    #[getter]
    fn error(&self) -> PyResult<f32> {
        self.read(|joint| joint.error())
    }

    /// Whether it acts.
    #[getter]
    fn enabled(&self) -> PyResult<bool> {
        self.read(|joint| joint.is_enabled())
    }

    #[setter]
    fn set_enabled(&self, enabled: bool) -> PyResult<()> {
        self.call(JointCall::SetEnabled(enabled))
    }

    /// Coordinate of an axis [m; rad]: of the only one of a hinge or slider, or of a named one
    /// ('x', 'y', 'z', 'turn_x', 'turn_y', 'turn_z'). None where the joint has no such axis.
    #[pyo3(signature = (axis=None))]
    fn position(&self, axis: Option<&Bound<'_, PyAny>>) -> PyResult<Option<f32>> {
        self.axis_value(axis, |axis| axis.position())
    }

    /// Speed of an axis [m/s; rad/s]; see `position`.
    #[pyo3(signature = (axis=None))]
    fn speed(&self, axis: Option<&Bound<'_, PyAny>>) -> PyResult<Option<f32>> {
        self.axis_value(axis, |axis| axis.speed())
    }

    /// Force of the drive of an axis [N; N m]; see `position`.
    #[pyo3(signature = (axis=None))]
    fn drive_force(&self, axis: Option<&Bound<'_, PyAny>>) -> PyResult<Option<f32>> {
        self.axis_value(axis, |axis| axis.drive_force())
    }

    /// Sets a motor: speed [m/s; rad/s], maximum force [N; N m].
    #[pyo3(signature = (speed, max_force, *, axis=None))]
    fn set_motor(
        &self,
        speed: &Bound<'_, PyAny>,
        max_force: &Bound<'_, PyAny>,
        axis: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let call = AxisCall::SetMotor(real("speed", speed)?, real("max_force", max_force)?);
        self.call_axis(axis, call)
    }

    /// Sets a servo: target [m; rad], spring, maximum force [N; N m].
    #[pyo3(signature = (target, spring, max_force=None, *, axis=None))]
    fn set_servo(
        &self,
        target: &Bound<'_, PyAny>,
        spring: &Bound<'_, PyAny>,
        max_force: Option<&Bound<'_, PyAny>>,
        axis: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let max = max_force.map_or(Ok(f32::INFINITY), |max| real("max_force", max))?;
        let call = AxisCall::SetServo(real("target", target)?, spring_def("spring", spring)?, max);
        self.call_axis(axis, call)
    }

    /// Sets the target of the drives of all three rotations [w, x, y, z], with their spring.
    #[pyo3(signature = (target, spring, max_torque=None))]
    fn set_target_rotation(
        &self,
        target: &Bound<'_, PyAny>,
        spring: &Bound<'_, PyDict>,
        max_torque: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let max = max_torque.map_or(Ok(f32::INFINITY), |max| real("max_torque", max))?;
        let spring = spring_def("spring", spring.as_any())?;
        self.call(JointCall::SetTargetRotation(rotation("target", target)?, spring, max))
    }

    /// Removes the drive of an axis.
    #[pyo3(signature = (*, axis=None))]
    fn clear_drive(&self, axis: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        self.call_axis(axis, AxisCall::SetDrive(None))
    }

    /// Sets hard limits of an axis [m; rad].
    #[pyo3(signature = (minimum, maximum, *, axis=None))]
    fn set_limits(
        &self,
        minimum: f32,
        maximum: f32,
        axis: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        self.call_axis(axis, AxisCall::SetLimits(minimum, maximum))
    }

    /// Sets the range of a distance joint or rope [m].
    fn set_lengths(&self, minimum: f32, maximum: f32) -> PyResult<()> {
        self.call(JointCall::SetLengths(minimum, maximum))
    }

    /// Wakes its bodies.
    fn wake(&self) -> PyResult<()> {
        self.call(JointCall::Wake)
    }

    /// Removes it.
    fn remove(&self) -> PyResult<()> {
        match self.world.get().apply(&Call::RemoveJoint(self.id))? {
            Answer::Nothing => Err(gone("joint", self.id.to_bits())),
            _ => Ok(()),
        }
    }

    fn __index__(&self) -> u64 {
        self.id.to_bits()
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        let Ok(other) = other.cast::<Self>() else { return false };
        let other = other.get();
        self.id == other.id && self.world.is(&other.world)
    }

    fn __hash__(&self) -> u64 {
        self.id.to_bits()
    }

    fn __repr__(&self) -> String {
        let kind = self.kind().unwrap_or("gone");
        format!("<Joint {kind} id {:#x}>", self.id.to_bits())
    }
}
