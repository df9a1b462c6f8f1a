//! Particles, ropes and cloths.

use drystone::journal::{Answer, Call, ParticleCall};
use drystone::particle::{
    ClothDef, LinkDef, LinkId, LinkKind, LinkSpring, ParticleDef, ParticleId, RopeDef, Strand,
};
use drystone::{Filter, Material, Vec3, World, limits};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use super::{PyWorld, body_id, gone};
use crate::arrays::{Table, array, numbers, vector, vectors, wrong_type};
use crate::errors::{bad, missing, refused};
use crate::options::{Options, dict, one_of};
use crate::shape::{filter, surface};

/// The particles and links of a rope, a cloth or a cloud, by their ids.
#[pyclass(name = "Strand", module = "drystone", frozen)]
pub(crate) struct PyStrand(Strand);

#[pymethods]
impl PyStrand {
    /// Ids of its particles (n,), uint64: of a rope from end to end, of a cloth row by row.
    #[getter]
    fn particles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let ids: Vec<u64> = self.0.particles.iter().map(|id| id.to_bits()).collect();
        let n = ids.len();
        array(py, ids, &[n])
    }

    /// Ids of its links (n,), uint64.
    #[getter]
    fn links<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let ids: Vec<u64> = self.0.links.iter().map(|id| id.to_bits()).collect();
        let n = ids.len();
        array(py, ids, &[n])
    }

    fn __repr__(&self) -> String {
        let Strand { particles, links } = &self.0;
        format!("<Strand: {} particles, {} links>", particles.len(), links.len())
    }
}

#[pymethods]
impl PyWorld {
    /// Adds a particle; returns its id. Keywords: `velocity` [m/s, world], `mass` [kg], `radius`
    /// [m], `pinned`, `gravity_scale`, `damping` [1/s], and the surface and filter of a shape.
    #[pyo3(signature = (position, **options))]
    fn add_particle(
        &self,
        position: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<u64> {
        let options = Options::new("a particle", options);
        let mut def = ParticleDef::at(vector("position", position)?);
        particle_def(&mut def, &options)?;
        options.set_real("mass", &mut def.mass)?;
        options.set_flag("pinned", &mut def.pinned)?;
        options.finish()?;
        let id = self.lock()?.run.world.add_particle(def).map_err(|e| refused(&e))?;
        Ok(id.to_bits())
    }

    /// Adds a rope between two points [m, world].
    ///
    /// Keywords: `links`, how many; `length` [m]; `mass` [kg] of all of it; `pinned`, two flags;
    /// `kind`, 'at_most', 'equal' or a spring; `tear_force` [N]; `tear_strain`; and of a particle.
    #[pyo3(signature = (start, end, links, **options))]
    fn add_rope(
        &self,
        start: &Bound<'_, PyAny>,
        end: &Bound<'_, PyAny>,
        links: usize,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyStrand> {
        let options = Options::new("a rope", options);
        let mut def = RopeDef::between(vector("start", start)?, vector("end", end)?, links);
        particle_def(&mut def.particle, &options)?;
        def.length = options.real("length")?;
        options.set_real("mass", &mut def.mass)?;
        if let Some(flags) = options.with("pinned", crate::arrays::reals::<2>)? {
            def.pinned = flags.map(|flag| flag != 0.0);
        }
        if let Some(kind) = options.with("kind", link_kind)? {
            def.kind = kind;
        }
        (def.tear_force, def.tear_strain) =
            (options.real("tear_force")?, options.real("tear_strain")?);
        options.finish()?;
        self.lock()?.run.world.add_rope(def).map(PyStrand).map_err(|e| refused(&e))
    }

    /// Adds a cloth: a corner [m, world], two sides [m, world], and the number of squares along
    /// each. Keywords: `mass` [kg] of all of it; `stretch`, `shear`, `bend`: 'at_most', 'equal',
    /// 'none' or a spring; `tear_force` [N], `tear_strain`; those of a particle.
    #[pyo3(signature = (corner, side_a, side_b, squares, **options))]
    fn add_cloth(
        &self,
        corner: &Bound<'_, PyAny>,
        side_a: &Bound<'_, PyAny>,
        side_b: &Bound<'_, PyAny>,
        squares: (usize, usize),
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyStrand> {
        let options = Options::new("a cloth", options);
        let sides = [vector("side_a", side_a)?, vector("side_b", side_b)?];
        let mut def = ClothDef::new(vector("corner", corner)?, sides, squares.into());
        particle_def(&mut def.particle, &options)?;
        options.set_real("mass", &mut def.mass)?;
        if let Some(kind) = options.with("stretch", link_kind)? {
            def.stretch = kind;
        }
        for (name, kind) in [("shear", &mut def.shear), ("bend", &mut def.bend)] {
            if let Some(given) = options.with(name, link_or_none)? {
                *kind = given;
            }
        }
        (def.tear_force, def.tear_strain) =
            (options.real("tear_force")?, options.real("tear_strain")?);
        options.finish()?;
        self.lock()?.run.world.add_cloth(def).map(PyStrand).map_err(|e| refused(&e))
    }

    /// Adds a particle at each of the points (n, 3) [m, world]. Keywords as of `add_particle`.
    #[pyo3(signature = (points, **options))]
    fn add_cloud(
        &self,
        points: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyStrand> {
        let points = vectors("points", points)?;
        let options = Options::new("a particle", options);
        let mut def = ParticleDef::default();
        particle_def(&mut def, &options)?;
        options.set_real("mass", &mut def.mass)?;
        options.set_flag("pinned", &mut def.pinned)?;
        options.finish()?;
        let made = self.lock()?.run.world.add_cloud(points, def);
        let strand = |particles| PyStrand(Strand { particles, links: Vec::new() });
        made.map(strand).map_err(|e| refused(&e))
    }

    /// Links two particles; returns the id of the link. `kind`: 'at_most', 'equal' or a spring;
    /// `length` [m]: their distance where it is not given.
    #[pyo3(signature = (a, b, kind, *, length=None, tear_force=None, tear_strain=None))]
    fn add_link(
        &self,
        a: u64,
        b: u64,
        kind: &Bound<'_, PyAny>,
        length: Option<f32>,
        tear_force: Option<f32>,
        tear_strain: Option<f32>,
    ) -> PyResult<u64> {
        let (a, b) = (particle("a", a)?, particle("b", b)?);
        let def = LinkDef {
            length,
            tear_force,
            tear_strain,
            ..LinkDef::new(a, b, link_kind("kind", kind)?)
        };
        let id = self.lock()?.run.world.add_link(def).map_err(|e| refused(&e))?;
        Ok(id.to_bits())
    }

    /// Removes a particle with its links.
    fn remove_particle(&self, particle: u64) -> PyResult<()> {
        let id = self::particle("particle", particle)?;
        match self.apply(&Call::RemoveParticle(id))? {
            Answer::Nothing => Err(gone("particle", particle)),
            _ => Ok(()),
        }
    }

    /// Removes a link.
    fn remove_link(&self, link: u64) -> PyResult<()> {
        let id = LinkId::from_bits(link).ok_or_else(|| gone("link", link))?;
        match self.apply(&Call::RemoveLink(id))? {
            Answer::Nothing => Err(gone("link", link)),
            _ => Ok(()),
        }
    }

    /// Holds a particle to a point of a body [m, body].
    fn attach_particle(
        slf: &Bound<'_, Self>,
        particle: u64,
        body: &Bound<'_, PyAny>,
        point: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let body = body_id(slf, "body", body)?;
        let call = ParticleCall::Attach(body, vector("point", point)?);
        slf.get().call_particle(particle, call)
    }

    /// Lets a particle go that a body holds.
    fn detach_particle(&self, particle: u64) -> PyResult<()> {
        self.call_particle(particle, ParticleCall::Detach)
    }

    /// Holds a particle where it is, or lets it go.
    #[pyo3(signature = (particle, pinned=true))]
    fn pin_particle(&self, particle: u64, pinned: bool) -> PyResult<()> {
        self.call_particle(particle, ParticleCall::SetPinned(pinned))
    }

    /// Adds an impulse to a particle [N s, world].
    fn push_particle(&self, particle: u64, impulse: &Bound<'_, PyAny>) -> PyResult<()> {
        self.call_particle(particle, ParticleCall::ApplyImpulse(vector("impulse", impulse)?))
    }

    /// Ids of the particles (n,), uint64: the order of the rows of their arrays.
    #[getter]
    fn particle_ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state = self.lock()?;
        let ids: Vec<u64> = state.run.world.particles().map(|p| p.id().to_bits()).collect();
        drop(state);
        let n = ids.len();
        array(py, ids, &[n])
    }

    /// Positions of the particles (n, 3) [m, world]; a copy, which can be assigned.
    #[getter]
    fn particle_positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.particle_rows(py, |p| p.position())
    }

    #[setter]
    fn set_particle_positions(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let limit = limits::POSITION;
        self.assign_particles(
            "particle_positions",
            value,
            limit,
            |p| p.position(),
            ParticleCall::SetPosition,
        )
    }

    /// Velocities of the particles (n, 3) [m/s, world]; a copy, which can be assigned.
    #[getter]
    fn particle_velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.particle_rows(py, |p| p.velocity())
    }

    #[setter]
    fn set_particle_velocities(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let limit = limits::SPEED;
        self.assign_particles(
            "particle_velocities",
            value,
            limit,
            |p| p.velocity(),
            ParticleCall::SetVelocity,
        )
    }

    /// The links as a structured array: id, a, b, length [m], distance [m], tension [N].
    fn links<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state = self.lock()?;
        let world = &state.run.world;
        let all = || world.links();
        Table::new(py, all().count())
            .column("id", all().map(|l| l.id().to_bits()))?
            .column("a", all().map(|l| l.particles()[0].to_bits()))?
            .column("b", all().map(|l| l.particles()[1].to_bits()))?
            .column("length", all().map(|l| l.length()))?
            .column("distance", all().map(|l| l.distance()))?
            .column("tension", all().map(|l| l.tension()))?
            .finish()
    }
}

type ParticleRef<'w> = drystone::particle::ParticleRef<'w>;

impl PyWorld {
    fn particle_rows<'py>(
        &self,
        py: Python<'py>,
        row: impl Fn(ParticleRef<'_>) -> Vec3,
    ) -> PyResult<Bound<'py, PyAny>> {
        let state = self.lock()?;
        let rows: Vec<f32> = state.run.world.particles().flat_map(|p| row(p).to_array()).collect();
        drop(state);
        let n = rows.len() / 3;
        array(py, rows, &[n, 3])
    }

    /// Assigns rows that differ, all or none.
    fn assign_particles(
        &self,
        field: &str,
        value: &Bound<'_, PyAny>,
        limit: limits::Limit,
        now: impl Fn(ParticleRef<'_>) -> Vec3,
        call: impl Fn(Vec3) -> ParticleCall,
    ) -> PyResult<()> {
        let count = |world: &World| world.particles().count();
        let n = count(&self.lock()?.run.world);
        let numbers = numbers(field, value, &[n, 3])?;
        let mut state = self.lock()?;
        let world = &mut state.run.world;
        let mut changes = Vec::new();
        for (i, (particle, row)) in world.particles().zip(numbers.as_chunks::<3>().0).enumerate() {
            let old = now(particle).to_array();
            if old.iter().zip(row).all(|(a, b)| a.to_bits() == b.to_bits()) {
                continue;
            }
            if !row.iter().all(|x| limit.admits(*x)) {
                return Err(bad(&format!("{field}[{i}]"), &format!("{row:?}"), limit.allowed));
            }
            changes.push((particle.id(), Vec3::from(*row)));
        }
        for (id, row) in changes {
            world.apply(&Call::Particle(id, call(row))).map_err(|e| refused(&e))?;
        }
        Ok(())
    }

    fn call_particle(&self, bits: u64, call: ParticleCall) -> PyResult<()> {
        let id = particle("particle", bits)?;
        let mut state = self.lock()?;
        let world = &mut state.run.world;
        if world.particle(id).is_none() {
            return Err(gone("particle", bits));
        }
        world.apply(&Call::Particle(id, call)).map(|_| ()).map_err(|e| refused(&e))
    }
}

fn particle(field: &str, bits: u64) -> PyResult<ParticleId> {
    ParticleId::from_bits(bits)
        .ok_or_else(|| missing(field, &bits.to_string(), "a particle of this world"))
}

/// The options that single particles and those of ropes and cloths have.
fn particle_def(def: &mut ParticleDef, options: &Options<'_, '_>) -> PyResult<()> {
    let ParticleDef { material, filter: layers, .. } = def;
    let (material, layers): (&mut Material, &mut Filter) = (material, layers);
    surface(material, options)?;
    filter(layers, options)?;
    options.set_vector("velocity", &mut def.velocity)?;
    options.set_real("radius", &mut def.radius)?;
    options.set_real("gravity_scale", &mut def.gravity_scale)?;
    options.set_real("damping", &mut def.damping)
}

/// A kind of link: 'equal', 'at_most', or a spring as a dict.
fn link_kind(field: &str, value: &Bound<'_, PyAny>) -> PyResult<LinkKind> {
    if value.is_instance_of::<PyString>() {
        let kinds = [LinkKind::Equal, LinkKind::AtMost];
        return one_of(field, value, &["equal", "at_most"]).map(|place| kinds[place]);
    }
    let given = dict(field, value)
        .map_err(|_| wrong_type(field, value, "'equal', 'at_most' or a dict of a spring"))?;
    let options = Options::new("a spring of a link", Some(&given));
    let hertz = options.real("hertz")?;
    let stiffness = options.real("stiffness")?;
    let spring = match (hertz, stiffness) {
        (Some(hertz), None) => {
            let damping_ratio = options.real("damping_ratio")?.unwrap_or(0.5);
            LinkSpring::Frequency { hertz, damping_ratio }
        }
        (None, Some(stiffness)) => {
            LinkSpring::Rate { stiffness, damping: options.real("damping")?.unwrap_or(0.0) }
        }
        _ => return Err(bad(field, "both or neither", "a dict with `hertz` or `stiffness`")),
    };
    options.finish()?;
    Ok(LinkKind::Spring(spring))
}

/// A kind of link, or 'none'.
fn link_or_none(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<LinkKind>> {
    if value.extract::<String>().is_ok_and(|word| word == "none") {
        return Ok(None);
    }
    link_kind(field, value).map(Some)
}
