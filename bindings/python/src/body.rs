//! A body of a world.

use drystone::journal::{BodyCall, Call};
use drystone::{BodyKind, BodyRef, MassDef, Pose};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::arrays::{array, pose, real, rotation, small, vec_out, vector, wxyz};
use crate::errors::{refused, unsuitable};
use crate::options::one_of;
use crate::world::{PyWorld, fracture, gone, time_step};

const KINDS: [(&str, BodyKind); 3] = [
    ("static", BodyKind::Static),
    ("kinematic", BodyKind::Kinematic),
    ("dynamic", BodyKind::Dynamic),
];

/// A body of a world, by its id. For many bodies use the arrays of the world.
#[pyclass(name = "Body", module = "drystone", frozen)]
pub(crate) struct PyBody {
    pub(crate) world: Py<PyWorld>,
    pub(crate) id: drystone::BodyId,
}

impl PyBody {
    fn read<T>(&self, read: impl FnOnce(BodyRef<'_>) -> T) -> PyResult<T> {
        let state = self.world.get().lock()?;
        let body = state.run.world.body(self.id);
        body.map(read).ok_or_else(|| gone("body", self.id.to_bits()))
    }

    fn call(&self, call: BodyCall) -> PyResult<()> {
        self.world.get().call_body(self.id, call)
    }

    /// Makes a call that pushes: on other bodies than dynamic ones the engine lets it be.
    fn push(&self, call: BodyCall) -> PyResult<()> {
        if self.read(|body| body.kind())? == BodyKind::Dynamic {
            return self.call(call);
        }
        Err(unsuitable("body", &self.__repr__(), "a dynamic body, which can be pushed"))
    }
}

#[pymethods]
impl PyBody {
    /// Its id, a number that no later body of this world has.
    #[getter]
    fn id(&self) -> u64 {
        self.id.to_bits()
    }

    /// Its world.
    #[getter]
    fn world(&self, py: Python<'_>) -> Py<PyWorld> {
        self.world.clone_ref(py)
    }

    /// Whether it is still in its world.
    #[getter]
    fn exists(&self) -> PyResult<bool> {
        Ok(self.world.get().lock()?.run.world.body(self.id).is_some())
    }

    /// Its name; empty where it has none.
    #[getter]
    fn name(&self) -> PyResult<String> {
        Ok(self.world.get().lock()?.name_of(self.id).to_owned())
    }

    /// 'static', 'kinematic' or 'dynamic'.
    #[getter]
    fn kind(&self) -> PyResult<&'static str> {
        let kind = self.read(|b| b.kind())?;
        Ok(KINDS.iter().find(|(_, known)| *known == kind).map_or("", |(name, _)| name))
    }

    #[setter]
    fn set_kind(&self, kind: &Bound<'_, PyString>) -> PyResult<()> {
        let place = one_of("kind", kind.as_any(), &KINDS.map(|(name, _)| name))?;
        self.call(BodyCall::SetKind(KINDS[place].1))
    }

    /// Position of its origin (3,) [m, world].
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vec_out(py, self.read(|b| b.position())?)
    }

    #[setter]
    fn set_position(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let position = vector("position", value)?;
        let rotation = self.read(|b| b.rotation())?;
        self.call(BodyCall::SetPose(Pose { position, rotation }))
    }

    /// Its rotation (4,) [w, x, y, z].
    #[getter]
    fn rotation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        small(py, wxyz(self.read(|b| b.rotation())?))
    }

    #[setter]
    fn set_rotation(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let rotation = rotation("rotation", value)?;
        let position = self.read(|b| b.position())?;
        self.call(BodyCall::SetPose(Pose { position, rotation }))
    }

    /// Velocity of its center of mass (3,) [m/s, world].
    #[getter]
    fn linear_velocity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vec_out(py, self.read(|b| b.linear_velocity())?)
    }

    #[setter]
    fn set_linear_velocity(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.call(BodyCall::SetLinearVelocity(vector("linear_velocity", value)?))
    }

    /// Its angular velocity (3,) [rad/s, world].
    #[getter]
    fn angular_velocity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vec_out(py, self.read(|b| b.angular_velocity())?)
    }

    #[setter]
    fn set_angular_velocity(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.call(BodyCall::SetAngularVelocity(vector("angular_velocity", value)?))
    }

    /// Position of its center of mass (3,) [m, world].
    #[getter]
    fn center_of_mass<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vec_out(py, self.read(|b| b.center_of_mass())?)
    }

    /// Its mass [kg]; 0 unless it is dynamic.
    #[getter]
    fn mass(&self) -> PyResult<f32> {
        self.read(|b| b.mass())
    }

    #[setter]
    fn set_mass(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.call(BodyCall::SetMass(MassDef::Mass(real("mass", value)?)))
    }

    /// Its inertia about the center of mass (3, 3) [kg m², world axes].
    #[getter]
    fn inertia<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let m = self.read(|b| b.inertia())?;
        let rows = [m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz];
        array(py, rows.to_vec(), &[3, 3])
    }

    /// Its kinetic energy [J].
    #[getter]
    fn kinetic_energy(&self) -> PyResult<f32> {
        self.read(|b| b.kinetic_energy())
    }

    /// Whether it sleeps.
    #[getter]
    fn asleep(&self) -> PyResult<bool> {
        self.read(|b| b.is_asleep())
    }

    /// Whether it takes part in the simulation.
    #[getter]
    fn enabled(&self) -> PyResult<bool> {
        self.read(|b| b.is_enabled())
    }

    #[setter]
    fn set_enabled(&self, enabled: bool) -> PyResult<()> {
        self.call(BodyCall::SetEnabled(enabled))
    }

    /// Factor by which gravity acts on it.
    #[getter]
    fn gravity_scale(&self) -> PyResult<f32> {
        self.read(|b| b.gravity_scale())
    }

    #[setter]
    fn set_gravity_scale(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.call(BodyCall::SetGravityScale(real("gravity_scale", value)?))
    }

    /// A number for the user.
    #[getter]
    fn user_data(&self) -> PyResult<u64> {
        self.read(|b| b.user_data())
    }

    #[setter]
    fn set_user_data(&self, data: u64) -> PyResult<()> {
        self.call(BodyCall::SetUserData(data))
    }

    /// Ids of its shapes (n,), uint64.
    #[getter]
    fn shape_ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let ids: Vec<u64> = self.read(|b| b.shapes().map(|id| id.to_bits()).collect())?;
        let n = ids.len();
        array(py, ids, &[n])
    }

    /// Velocity of a point that moves with it (3,) [m/s, world]; the point in [m, world].
    fn velocity_at<'py>(&self, point: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let at = vector("point", point)?;
        vec_out(point.py(), self.read(|b| b.velocity_at(at))?)
    }

    /// Adds an impulse [N s, world] at its center of mass, or at a point [m, world].
    #[pyo3(signature = (impulse, at=None))]
    fn apply_impulse(
        &self,
        impulse: &Bound<'_, PyAny>,
        at: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let impulse = vector("impulse", impulse)?;
        self.push(match at {
            Some(point) => BodyCall::ApplyImpulseAt(impulse, vector("at", point)?),
            None => BodyCall::ApplyImpulse(impulse),
        })
    }

    /// Adds an angular impulse [N m s, world].
    fn apply_angular_impulse(&self, impulse: &Bound<'_, PyAny>) -> PyResult<()> {
        self.push(BodyCall::ApplyAngularImpulse(vector("impulse", impulse)?))
    }

    /// Adds a force [N, world] for the next step alone, at its center of mass or at a point [m,
    /// world].
    #[pyo3(signature = (force, at=None))]
    fn add_step_force(
        &self,
        force: &Bound<'_, PyAny>,
        at: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let force = vector("force", force)?;
        self.push(match at {
            Some(point) => BodyCall::AddStepForceAt(force, vector("at", point)?),
            None => BodyCall::AddStepForce(force),
        })
    }

    /// Adds a torque [N m, world] for the next step alone.
    fn add_step_torque(&self, torque: &Bound<'_, PyAny>) -> PyResult<()> {
        self.push(BodyCall::AddStepTorque(vector("torque", torque)?))
    }

    /// Sets the force that acts in every step from now on [N, world].
    fn set_lasting_force(&self, force: &Bound<'_, PyAny>) -> PyResult<()> {
        self.push(BodyCall::SetLastingForce(vector("force", force)?))
    }

    /// Sets the torque that acts in every step from now on [N m, world].
    fn set_lasting_torque(&self, torque: &Bound<'_, PyAny>) -> PyResult<()> {
        self.push(BodyCall::SetLastingTorque(vector("torque", torque)?))
    }

    /// Sets the rates at which its velocities decay [1/s].
    fn set_damping(&self, linear: f32, angular: f32) -> PyResult<()> {
        self.call(BodyCall::SetDamping(linear, angular))
    }

    /// Gives a kinematic body the velocity that takes it to a pose in a step of `dt` [s].
    #[pyo3(signature = (position, dt, *, rotation=None))]
    fn move_to(
        &self,
        position: &Bound<'_, PyAny>,
        dt: &Bound<'_, PyAny>,
        rotation: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let mut target = pose(position, rotation)?;
        if rotation.is_none() {
            target.rotation = self.read(|b| b.rotation())?;
        }
        self.call(BodyCall::MoveTo(target, time_step(dt)?))
    }

    /// Wakes it.
    fn wake(&self) -> PyResult<()> {
        self.call(BodyCall::Wake)
    }

    /// Puts it to sleep.
    fn sleep(&self) -> PyResult<()> {
        self.call(BodyCall::Sleep)
    }

    /// Breaks it at a point [m, world] now, as `fracture` (a dict) says; returns the pieces.
    #[pyo3(signature = (point, **fracture))]
    fn break_at(
        slf: &Bound<'_, Self>,
        point: &Bound<'_, PyAny>,
        fracture: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Vec<Self>> {
        let at = vector("point", point)?;
        let how = match fracture {
            Some(given) => self::fracture(given)?,
            None => drystone::breakage::Fracture::default(),
        };
        let (py, body) = (slf.py(), slf.get());
        let mut state = body.world.get().lock()?;
        let there = state.run.world.body_mut(body.id);
        let there = there.ok_or_else(|| gone("body", body.id.to_bits()))?;
        let pieces = there.break_at(at, &how).map_err(|e| refused(&e))?;
        Ok(pieces.into_iter().map(|id| Self { world: body.world.clone_ref(py), id }).collect())
    }

    /// Removes it with its shapes and joints.
    fn remove(&self) -> PyResult<()> {
        match self.world.get().apply(&Call::RemoveBody(self.id))? {
            drystone::journal::Answer::Nothing => Err(gone("body", self.id.to_bits())),
            _ => Ok(()),
        }
    }

    /// A hash of the bits of its pose and velocity.
    fn state_hash(&self) -> PyResult<u64> {
        self.read(|b| b.state_hash())
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
        let name = self.name().unwrap_or_default();
        let name = if name.is_empty() { String::new() } else { format!(" '{name}'") };
        format!("<Body{name} id {:#x}>", self.id.to_bits())
    }
}
