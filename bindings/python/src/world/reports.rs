//! Reports of a world: events, contacts, the audit.

use drystone::audit::{Audit, Energy, JointErrors, Ledger, Momentum, Penetration};
use drystone::events::{ContactEvent, Events, FaultKind, FractureCause, JointLimit, SensorEvent};
use drystone::{BodyId, Vec3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::PyWorld;
use crate::arrays::{Table, array, vec_out};

/// The events of a step, each list as a structured array. They stay as they are when the world
/// goes on.
#[pyclass(name = "Events", module = "drystone", frozen)]
pub(crate) struct PyEvents(Box<Events>);

#[pymethods]
impl PyEvents {
    /// Shapes that began to touch: shape_a, shape_b, body_a, body_b.
    #[getter]
    fn contact_begin<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        touches(py, &self.0.contact_begin)
    }

    /// Shapes that ceased to touch: shape_a, shape_b, body_a, body_b.
    #[getter]
    fn contact_end<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        touches(py, &self.0.contact_end)
    }

    /// Landings: shape_a, shape_b, body_a, body_b, point [m, world], normal, speed [m/s], impulse
    /// [N s].
    #[getter]
    fn hits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let hits = &self.0.hits;
        Table::new(py, hits.len())
            .column("shape_a", hits.iter().map(|e| e.shape_a.to_bits()))?
            .column("shape_b", hits.iter().map(|e| e.shape_b.to_bits()))?
            .column("body_a", hits.iter().map(|e| e.body_a.to_bits()))?
            .column("body_b", hits.iter().map(|e| e.body_b.to_bits()))?
            .vectors("point", hits.iter().map(|e| e.point))?
            .vectors("normal", hits.iter().map(|e| e.normal))?
            .column("speed", hits.iter().map(|e| e.speed))?
            .column("impulse", hits.iter().map(|e| e.impulse))?
            .finish()
    }

    /// Forces of pairs with a shape that reports them: shape_a, shape_b, body_a, body_b, impulse
    /// on B [N s, world], normal_impulse [N s], force on B [N, world], greatest_force [N], and
    /// point_count, its number of rows in `force_points`.
    #[getter]
    fn contact_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all = &self.0.contact_forces;
        Table::new(py, all.len())
            .column("shape_a", all.iter().map(|e| e.shape_a.to_bits()))?
            .column("shape_b", all.iter().map(|e| e.shape_b.to_bits()))?
            .column("body_a", all.iter().map(|e| e.body_a.to_bits()))?
            .column("body_b", all.iter().map(|e| e.body_b.to_bits()))?
            .vectors("impulse", all.iter().map(|e| e.impulse))?
            .column("normal_impulse", all.iter().map(|e| e.normal_impulse))?
            .vectors("force", all.iter().map(|e| e.force))?
            .column("greatest_force", all.iter().map(|e| e.greatest_force))?
            .column("point_count", all.iter().map(|e| self.0.points_of(e).len() as u64))?
            .finish()
    }

    /// Points of the contact forces, in the same order: position [m, world], normal, impulse
    /// [N s], greatest_force [N].
    #[getter]
    fn force_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all = &self.0.force_points;
        Table::new(py, all.len())
            .vectors("position", all.iter().map(|p| p.position))?
            .vectors("normal", all.iter().map(|p| p.normal))?
            .column("impulse", all.iter().map(|p| p.impulse))?
            .column("greatest_force", all.iter().map(|p| p.greatest_force))?
            .finish()
    }

    /// Mean force of contacts on a body [N, world], over the pairs that report forces.
    fn contact_force_on<'py>(&self, py: Python<'py>, body: u64) -> PyResult<Bound<'py, PyAny>> {
        let force = BodyId::from_bits(body).map_or(Vec3::ZERO, |id| self.0.contact_force_on(id));
        vec_out(py, force)
    }

    /// Shapes that entered a sensor: sensor, visitor, sensor_body, visitor_body.
    #[getter]
    fn sensor_enter<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        sensed(py, &self.0.sensor_enter)
    }

    /// Shapes that left a sensor: sensor, visitor, sensor_body, visitor_body.
    #[getter]
    fn sensor_exit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        sensed(py, &self.0.sensor_exit)
    }

    /// Ids of bodies that fell asleep.
    #[getter]
    fn sleep<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        ids(py, self.0.sleep.iter().map(|id| id.to_bits()))
    }

    /// Ids of bodies that woke.
    #[getter]
    fn wake<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        ids(py, self.0.wake.iter().map(|id| id.to_bits()))
    }

    /// Joints that broke and were removed: joint, body_a, body_b, limit, force [N], torque [N m],
    /// impulse [N s], damage.
    #[getter]
    fn joint_break<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all = &self.0.joint_break;
        let limit = |limit| match limit {
            JointLimit::Force => "force",
            JointLimit::Torque => "torque",
            JointLimit::Impulse => "impulse",
            JointLimit::Fatigue => "fatigue",
            _ => "other",
        };
        Table::new(py, all.len())
            .column("joint", all.iter().map(|e| e.joint.to_bits()))?
            .column("body_a", all.iter().map(|e| e.body_a.to_bits()))?
            .column("body_b", all.iter().map(|e| e.body_b.to_bits()))?
            .words("limit", all.iter().map(|e| limit(e.limit)), 8)?
            .column("force", all.iter().map(|e| e.force))?
            .column("torque", all.iter().map(|e| e.torque))?
            .column("impulse", all.iter().map(|e| e.impulse))?
            .column("damage", all.iter().map(|e| e.damage))?
            .finish()
    }

    /// Links of particles that tore and were removed: link, a, b, force [N], strain.
    #[getter]
    fn link_tear<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all = &self.0.link_tear;
        Table::new(py, all.len())
            .column("link", all.iter().map(|e| e.link.to_bits()))?
            .column("a", all.iter().map(|e| e.a.to_bits()))?
            .column("b", all.iter().map(|e| e.b.to_bits()))?
            .column("force", all.iter().map(|e| e.force))?
            .column("strain", all.iter().map(|e| e.strain))?
            .finish()
    }

    /// Ids of particles whose body was removed.
    #[getter]
    fn detached<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        ids(py, self.0.detached.iter().map(|id| id.to_bits()))
    }

    /// Bonds that broke: body, shape_a, shape_b, point [m, world], tension [Pa], shear [Pa].
    #[getter]
    fn bond_break<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all = &self.0.bond_break;
        Table::new(py, all.len())
            .column("body", all.iter().map(|e| e.body.to_bits()))?
            .column("shape_a", all.iter().map(|e| e.shapes[0].to_bits()))?
            .column("shape_b", all.iter().map(|e| e.shapes[1].to_bits()))?
            .vectors("point", all.iter().map(|e| e.point))?
            .column("tension", all.iter().map(|e| e.tension))?
            .column("shear", all.iter().map(|e| e.shear))?
            .finish()
    }

    /// Bodies that came apart: body, cause ('glue', 'impulse', 'energy'), point [m, world], value,
    /// limit, and piece_count, its number of rows in `pieces`.
    #[getter]
    fn fractures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all = &self.0.fractures;
        let cause = |cause| match cause {
            FractureCause::Glue => "glue",
            FractureCause::Impulse => "impulse",
            FractureCause::Energy => "energy",
            _ => "other",
        };
        Table::new(py, all.len())
            .column("body", all.iter().map(|e| e.body.to_bits()))?
            .words("cause", all.iter().map(|e| cause(e.cause)), 8)?
            .vectors("point", all.iter().map(|e| e.point))?
            .column("value", all.iter().map(|e| e.value))?
            .column("limit", all.iter().map(|e| e.limit))?
            .column("piece_count", all.iter().map(|e| self.0.pieces_of(e).len() as u64))?
            .finish()
    }

    /// Ids of new bodies that are pieces, in the order of `fractures`.
    #[getter]
    fn pieces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        ids(py, self.0.pieces.iter().map(|id| id.to_bits()))
    }

    /// Faults: body, joint, particle (ids, 0: none), kind, step.
    #[getter]
    fn faults<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all = &self.0.faults;
        let kind = |kind| match kind {
            FaultKind::NotFinite => "not_finite",
            FaultKind::BadTimeStep => "bad_time_step",
            FaultKind::Refused(call) => call.name(),
            _ => "other",
        };
        Table::new(py, all.len())
            .column("body", all.iter().map(|e| e.body.map_or(0, |id| id.to_bits())))?
            .column("joint", all.iter().map(|e| e.joint.map_or(0, |id| id.to_bits())))?
            .column("particle", all.iter().map(|e| e.particle.map_or(0, |id| id.to_bits())))?
            .words("kind", all.iter().map(|e| kind(e.kind)), 32)?
            .column("step", all.iter().map(|e| e.step))?
            .finish()
    }
}

fn ids<'py>(py: Python<'py>, ids: impl Iterator<Item = u64>) -> PyResult<Bound<'py, PyAny>> {
    let ids: Vec<u64> = ids.collect();
    let n = ids.len();
    array(py, ids, &[n])
}

fn touches<'py>(py: Python<'py>, all: &[ContactEvent]) -> PyResult<Bound<'py, PyAny>> {
    Table::new(py, all.len())
        .column("shape_a", all.iter().map(|e| e.shape_a.to_bits()))?
        .column("shape_b", all.iter().map(|e| e.shape_b.to_bits()))?
        .column("body_a", all.iter().map(|e| e.body_a.to_bits()))?
        .column("body_b", all.iter().map(|e| e.body_b.to_bits()))?
        .finish()
}

fn sensed<'py>(py: Python<'py>, all: &[SensorEvent]) -> PyResult<Bound<'py, PyAny>> {
    Table::new(py, all.len())
        .column("sensor", all.iter().map(|e| e.sensor.to_bits()))?
        .column("visitor", all.iter().map(|e| e.visitor.to_bits()))?
        .column("sensor_body", all.iter().map(|e| e.sensor_body.to_bits()))?
        .column("visitor_body", all.iter().map(|e| e.visitor_body.to_bits()))?
        .finish()
}

#[pymethods]
impl PyWorld {
    /// The events of the last step.
    #[getter]
    fn events(&self) -> PyResult<PyEvents> {
        Ok(PyEvents(Box::new(self.lock()?.run.world.events().clone())))
    }

    /// The points of all contacts, as a structured array: shape_a, shape_b, body_a, body_b, contact
    /// (its number), normal from A to B, position [m, world] and separation [m] at the beginning of
    /// the step, impulse along the normal [N s] and friction_impulse of the contact on B [N s,
    /// world] in the last substep.
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state = self.lock()?;
        let mut points = Vec::new();
        for (number, contact) in (0_u64..).zip(state.run.world.contacts()) {
            points.extend(contact.points().map(|point| (number, contact, point)));
        }
        Table::new(py, points.len())
            .column("shape_a", points.iter().map(|(_, c, _)| c.shape_a().to_bits()))?
            .column("shape_b", points.iter().map(|(_, c, _)| c.shape_b().to_bits()))?
            .column("body_a", points.iter().map(|(_, c, _)| c.body_a().to_bits()))?
            .column("body_b", points.iter().map(|(_, c, _)| c.body_b().to_bits()))?
            .column("contact", points.iter().map(|(number, ..)| *number))?
            .vectors("normal", points.iter().map(|(_, c, _)| c.normal()))?
            .vectors("position", points.iter().map(|(.., p)| p.position))?
            .column("separation", points.iter().map(|(.., p)| p.separation))?
            .column("impulse", points.iter().map(|(.., p)| p.impulse))?
            .vectors("friction_impulse", points.iter().map(|(_, c, _)| c.friction_impulse()))?
            .finish()
    }

    /// Energy, momentum, overlaps and errors of the world now, as nested dicts.
    fn audit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let audit = self.lock()?.run.world.audit();
        audit_out(py, &audit)
    }

    /// Begins the energy balance that `audit` then has as 'ledger'.
    fn begin_ledger(&self) -> PyResult<()> {
        self.lock()?.run.world.begin_ledger();
        Ok(())
    }

    /// Ends the energy balance and returns it; None if none was begun.
    fn end_ledger<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let ledger = self.lock()?.run.world.end_ledger();
        ledger.map(|ledger| ledger_out(py, &ledger)).transpose()
    }

    /// Numbers of bodies, shapes, joints and so on, as a dict.
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counts = self.lock()?.run.world.counts();
        let dict = PyDict::new(py);
        for (name, count) in [
            ("static", counts.fixed),
            ("kinematic", counts.kinematic),
            ("dynamic", counts.dynamic),
            ("asleep", counts.asleep),
            ("shapes", counts.shapes),
            ("joints", counts.joints),
            ("particles", counts.particles),
            ("particles_asleep", counts.particles_asleep),
            ("links", counts.links),
            ("pairs", counts.pairs),
            ("contacts", counts.contacts),
        ] {
            dict.set_item(name, count)?;
        }
        Ok(dict)
    }
}

fn audit_out<'py>(py: Python<'py>, audit: &Audit) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("step", audit.step)?;
    dict.set_item("energy", energy_out(py, &audit.energy)?)?;
    let Momentum { mass, center_of_mass, linear, about_origin, about_center, .. } = audit.momentum;
    let momentum = PyDict::new(py);
    momentum.set_item("mass", mass)?;
    momentum.set_item("center_of_mass", vec_out(py, center_of_mass)?)?;
    momentum.set_item("linear", vec_out(py, linear)?)?;
    momentum.set_item("about_origin", vec_out(py, about_origin)?)?;
    momentum.set_item("about_center", vec_out(py, about_center)?)?;
    dict.set_item("momentum", momentum)?;
    let Penetration { points, max, p99, mean, .. } = audit.penetration;
    let depth = PyDict::new(py);
    depth.set_item("points", points)?;
    depth.set_item("max", max)?;
    depth.set_item("p99", p99)?;
    depth.set_item("mean", mean)?;
    dict.set_item("penetration", depth)?;
    let JointErrors { linear, angular, .. } = audit.joints;
    let joints = PyDict::new(py);
    joints.set_item("linear", linear)?;
    joints.set_item("angular", angular)?;
    dict.set_item("joints", joints)?;
    let residual = PyDict::new(py);
    residual.set_item("speed", audit.residual.speed)?;
    residual.set_item("relative", audit.residual.relative)?;
    residual.set_item("gap", audit.residual.gap)?;
    residual.set_item("pull", audit.residual.pull)?;
    dict.set_item("residual", residual)?;
    dict.set_item("cone_use", audit.cone.map(|cone| cone.ratio))?;
    let bodies: Vec<u64> = audit.non_finite.iter().map(|id| id.to_bits()).collect();
    dict.set_item("non_finite", bodies)?;
    let ledger = audit.ledger.map(|ledger| ledger_out(py, &ledger)).transpose()?;
    dict.set_item("ledger", ledger)?;
    Ok(dict)
}

fn energy_out<'py>(py: Python<'py>, energy: &Energy) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("linear", energy.linear)?;
    dict.set_item("angular", energy.angular)?;
    dict.set_item("potential", energy.potential)?;
    dict.set_item("elastic", energy.elastic)?;
    dict.set_item("kinetic", energy.kinetic())?;
    dict.set_item("total", energy.total())?;
    Ok(dict)
}

fn ledger_out<'py>(py: Python<'py>, ledger: &Ledger) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("steps", ledger.steps)?;
    dict.set_item("start", energy_out(py, &ledger.start)?)?;
    dict.set_item("now", energy_out(py, &ledger.now)?)?;
    for (name, work) in [
        ("forces", ledger.forces),
        ("impulses", ledger.impulses),
        ("changes", ledger.changes),
        ("kinematic", ledger.kinematic),
        ("dissipated", ledger.dissipated),
    ] {
        dict.set_item(name, work)?;
    }
    Ok(dict)
}
