//! Queries: rays, shape casts, overlaps, nearest shapes.

use drystone::query::{
    BodyKinds, Inside, Motion, NearestShape, QueryFilter, RayHit, RayQuery, ShapeHit, ShapeQuery,
};
use drystone::{BodyId, BodyKind, Filter, Pose, Quat, ShapeId, Vec3};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use super::{PyWorld, body_id};
use crate::arrays::{NO_VECTOR, Table, pose, real, rows, vec_out, vector, vectors, wrong_type};
use crate::errors::{bad, refused};
use crate::options::{Options, one_of};
use crate::shape::PyShape;

/// A hit of a ray or of a moving shape.
#[pyclass(name = "Hit", module = "drystone", frozen)]
pub(crate) struct PyHit {
    shape: ShapeId,
    body: BodyId,
    fraction: f32,
    point: Vec3,
    normal: Vec3,
    inside: bool,
}

#[pymethods]
impl PyHit {
    /// Id of the shape.
    #[getter]
    fn shape(&self) -> u64 {
        self.shape.to_bits()
    }

    /// Id of its body.
    #[getter]
    fn body(&self) -> u64 {
        self.body.to_bits()
    }

    /// Fraction of the way, 0 to 1.
    #[getter]
    fn fraction(&self) -> f32 {
        self.fraction
    }

    /// Point of the hit (3,) [m, world].
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vec_out(py, self.point)
    }

    /// Outward normal of the surface (3,) [world].
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vec_out(py, self.normal)
    }

    /// Whether it began in the shape.
    #[getter]
    fn inside(&self) -> bool {
        self.inside
    }

    fn __repr__(&self) -> String {
        let Vec3 { x, y, z } = self.point;
        format!("<Hit of body {:#x} at ({x}, {y}, {z})>", self.body.to_bits())
    }
}

impl From<RayHit> for PyHit {
    fn from(hit: RayHit) -> Self {
        let RayHit { shape, body, fraction, point, normal, inside, .. } = hit;
        Self { shape, body, fraction, point, normal, inside }
    }
}

impl From<ShapeHit> for PyHit {
    fn from(hit: ShapeHit) -> Self {
        let ShapeHit { shape, body, fraction, point, normal, inside, .. } = hit;
        Self { shape, body, fraction, point, normal, inside }
    }
}

/// All queries take these keywords: `layers`, `mask`, `exclude` (bits), `exclude_bodies`, `kinds`
/// ('static', 'kinematic', 'dynamic', or a list), `sensors`, `inside` ('solid', 'hollow' or
/// 'ignore').
#[pymethods]
impl PyWorld {
    /// The first shape on the way from `origin` by `delta` [m, world]; None where there is none.
    #[pyo3(signature = (origin, delta, **filter))]
    fn ray(
        slf: &Bound<'_, Self>,
        origin: &Bound<'_, PyAny>,
        delta: &Bound<'_, PyAny>,
        filter: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Option<PyHit>> {
        let seen = Seen::new(slf, filter)?;
        let (origin, delta) = (vector("origin", origin)?, vector("delta", delta)?);
        let state = slf.get().lock()?;
        let hit = state.run.world.query().cast_ray(origin, delta, seen.filter());
        Ok(hit.map_err(|e| refused(&e))?.map(PyHit::from))
    }

    /// The first shape on each of many rays: arrays (n, 3) of origins and of ways [m, world].
    ///
    /// A structured array (n,): hit (bool), body and shape (ids, 0 without a hit), fraction
    /// (infinite without one), point, normal (NaN without one), inside. All threads take part.
    #[pyo3(signature = (origins, deltas, **filter))]
    fn rays<'py>(
        slf: &Bound<'py, Self>,
        origins: &Bound<'py, PyAny>,
        deltas: &Bound<'py, PyAny>,
        filter: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let seen = Seen::new(slf, filter)?;
        let (origins, deltas) = (vectors("origins", origins)?, vectors("deltas", deltas)?);
        let same = same_length("deltas", origins.len(), deltas.len());
        same?;
        let rays: Vec<_> =
            origins.iter().zip(&deltas).map(|(o, d)| RayQuery::new(*o, *d)).collect();
        let mut hits = Vec::new();
        {
            let guard = slf.get().lock()?;
            let world = &guard.run.world;
            let (filter, hits) = (seen.filter(), &mut hits);
            let cast = slf.py().detach(|| world.query().cast_rays(&rays, filter, hits));
            cast.map_err(|e| refused(&e))?;
        }
        let hits: Vec<_> = hits.into_iter().map(|hit| hit.map(PyHit::from)).collect();
        table(slf.py(), &hits)
    }

    /// The first shape that a convex shape hits on its way from a position by `delta` [m, world],
    /// while it turns by the rotation vector `turn` [rad, world]. None where there is none.
    #[pyo3(signature = (shape, position, delta, *, rotation=None, turn=None, **filter))]
    fn shape_cast(
        slf: &Bound<'_, Self>,
        shape: &Bound<'_, PyShape>,
        position: &Bound<'_, PyAny>,
        delta: &Bound<'_, PyAny>,
        rotation: Option<&Bound<'_, PyAny>>,
        turn: Option<&Bound<'_, PyAny>>,
        filter: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Option<PyHit>> {
        let seen = Seen::new(slf, filter)?;
        let from = pose(position, rotation)?;
        let turn = turn.map_or(Ok(Vec3::ZERO), |turn| vector("turn", turn))?;
        let motion = Motion::by(vector("delta", delta)?).with_turn(turn);
        let shape = &shape.get().0.shape;
        let state = slf.get().lock()?;
        let hit = state.run.world.query().cast_shape(shape, from, motion, seen.filter());
        Ok(hit.map_err(|e| refused(&e))?.map(PyHit::from))
    }

    /// `shape_cast` of one shape from many positions (n, 3) by many ways (n, 3) [m, world], with
    /// rotations (n, 4) if they are given. A structured array as of `rays`.
    #[pyo3(signature = (shape, positions, deltas, *, rotations=None, **filter))]
    fn shape_casts<'py>(
        slf: &Bound<'py, Self>,
        shape: &Bound<'py, PyShape>,
        positions: &Bound<'py, PyAny>,
        deltas: &Bound<'py, PyAny>,
        rotations: Option<&Bound<'py, PyAny>>,
        filter: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let seen = Seen::new(slf, filter)?;
        let (positions, deltas) = (vectors("positions", positions)?, vectors("deltas", deltas)?);
        same_length("deltas", positions.len(), deltas.len())?;
        let turned = match rotations {
            Some(rotations) => {
                let numbers = rows("rotations", rotations, 4)?;
                let turned = numbers.as_chunks::<4>().0.iter();
                turned.map(|[w, x, y, z]| Quat::new(*x, *y, *z, *w)).collect()
            }
            None => vec![Quat::IDENTITY; positions.len()],
        };
        same_length("rotations", positions.len(), turned.len())?;
        let starts = positions.iter().zip(turned);
        let casts: Vec<_> = starts
            .zip(&deltas)
            .map(|((position, rotation), delta)| {
                ShapeQuery::new(Pose { position: *position, rotation }, *delta)
            })
            .collect();
        let shape = &shape.get().0.shape;
        let mut hits = Vec::new();
        {
            let guard = slf.get().lock()?;
            let world = &guard.run.world;
            let (filter, hits) = (seen.filter(), &mut hits);
            let cast = slf.py().detach(|| world.query().cast_shapes(shape, &casts, filter, hits));
            cast.map_err(|e| refused(&e))?;
        }
        let hits: Vec<_> = hits.into_iter().map(|hit| hit.map(PyHit::from)).collect();
        table(slf.py(), &hits)
    }

    /// The shapes that a convex shape at a position [m, world] overlaps: a structured array of
    /// `shape` and `body` ids.
    #[pyo3(signature = (shape, position, *, rotation=None, **filter))]
    fn overlap<'py>(
        slf: &Bound<'py, Self>,
        shape: &Bound<'py, PyShape>,
        position: &Bound<'py, PyAny>,
        rotation: Option<&Bound<'py, PyAny>>,
        filter: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let seen = Seen::new(slf, filter)?;
        let at = pose(position, rotation)?;
        let shape = &shape.get().0.shape;
        let state = slf.get().lock()?;
        let found = state.run.world.query().overlap_shape(shape, at, seen.filter());
        listed(slf.py(), &state.run.world, &found.map_err(|e| refused(&e))?)
    }

    /// The shapes that a point [m, world] lies in: see `overlap`.
    #[pyo3(signature = (point, **filter))]
    fn overlap_point<'py>(
        slf: &Bound<'py, Self>,
        point: &Bound<'py, PyAny>,
        filter: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let seen = Seen::new(slf, filter)?;
        let at = vector("point", point)?;
        let state = slf.get().lock()?;
        let found = state.run.world.query().overlap_point(at, seen.filter());
        listed(slf.py(), &state.run.world, &found.map_err(|e| refused(&e))?)
    }

    /// The shapes within `reach` [m] of a convex shape at a position [m, world], nearest first: a
    /// structured array of shape, body, distance [m], point, own_point [m, world], normal.
    #[pyo3(signature = (shape, position, reach, *, rotation=None, **filter))]
    fn nearest<'py>(
        slf: &Bound<'py, Self>,
        shape: &Bound<'py, PyShape>,
        position: &Bound<'py, PyAny>,
        reach: &Bound<'py, PyAny>,
        rotation: Option<&Bound<'py, PyAny>>,
        filter: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let seen = Seen::new(slf, filter)?;
        let (at, reach) = (pose(position, rotation)?, real("reach", reach)?);
        let shape = &shape.get().0.shape;
        let mut near: Vec<NearestShape> = Vec::new();
        let found = {
            let state = slf.get().lock()?;
            let query = state.run.world.query();
            query.nearest_all(shape, at, reach, seen.filter(), &mut near)
        };
        found.map_err(|e| refused(&e))?;
        Table::new(slf.py(), near.len())
            .column("shape", near.iter().map(|n| n.shape.to_bits()))?
            .column("body", near.iter().map(|n| n.body.to_bits()))?
            .column("distance", near.iter().map(|n| n.distance))?
            .vectors("point", near.iter().map(|n| n.point))?
            .vectors("own_point", near.iter().map(|n| n.own_point))?
            .vectors("normal", near.iter().map(|n| n.normal))?
            .finish()
    }
}

fn same_length(field: &str, length: usize, found: usize) -> PyResult<()> {
    if length == found {
        return Ok(());
    }
    Err(bad(field, &format!("{found} rows"), &format!("an array of {length} rows, like the first")))
}

fn table<'py>(py: Python<'py>, hits: &[Option<PyHit>]) -> PyResult<Bound<'py, PyAny>> {
    let of =
        |read: fn(&PyHit) -> Vec3| hits.iter().map(move |hit| hit.as_ref().map_or(NO_VECTOR, read));
    let id = |read: fn(&PyHit) -> u64| hits.iter().map(move |hit| hit.as_ref().map_or(0, read));
    Table::new(py, hits.len())
        .column("hit", hits.iter().map(Option::is_some))?
        .column("body", id(|hit| hit.body.to_bits()))?
        .column("shape", id(|hit| hit.shape.to_bits()))?
        .column(
            "fraction",
            hits.iter().map(|hit| hit.as_ref().map_or(f32::INFINITY, |h| h.fraction)),
        )?
        .vectors("point", of(|hit| hit.point))?
        .vectors("normal", of(|hit| hit.normal))?
        .column("inside", hits.iter().map(|hit| hit.as_ref().is_some_and(|hit| hit.inside)))?
        .finish()
}

fn listed<'py>(
    py: Python<'py>,
    world: &drystone::World,
    shapes: &[ShapeId],
) -> PyResult<Bound<'py, PyAny>> {
    let body = |id: &ShapeId| world.shape(*id).map_or(0, |shape| shape.body().to_bits());
    Table::new(py, shapes.len())
        .column("shape", shapes.iter().map(|id| id.to_bits()))?
        .column("body", shapes.iter().map(body))?
        .finish()
}

/// The keywords of a query.
struct Seen {
    filter: Option<Filter>,
    kinds: BodyKinds,
    sensors: bool,
    exclude: Vec<BodyId>,
    inside: Inside,
}

impl Seen {
    fn new(world: &Bound<'_, PyWorld>, given: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let options = Options::new("a query", given);
        let mut filter = Filter { layers: u64::MAX, ..Filter::default() };
        crate::shape::filter(&mut filter, &options)?;
        let is_default = filter == Filter { layers: u64::MAX, ..Filter::default() };
        let kinds = options.with("kinds", body_kinds)?.unwrap_or_default();
        let sensors = options.flag("sensors")?.unwrap_or(false);
        let exclude = options.with("exclude_bodies", |field, value| {
            let items =
                value.try_iter().map_err(|_| wrong_type(field, value, "a list of bodies"))?;
            items.map(|body| body_id(world, field, &body?)).collect()
        })?;
        let rules = [Inside::Solid, Inside::Hollow, Inside::Ignore];
        let inside = options.one_of("inside", &["solid", "hollow", "ignore"])?;
        options.finish()?;
        Ok(Self {
            filter: (!is_default).then_some(filter),
            kinds,
            sensors,
            exclude: exclude.unwrap_or_default(),
            inside: inside.map_or(Inside::Solid, |place| rules[place]),
        })
    }

    fn filter(&self) -> QueryFilter<'_> {
        QueryFilter {
            filter: self.filter,
            kinds: self.kinds,
            sensors: self.sensors,
            exclude: &self.exclude,
            inside: self.inside,
            ..QueryFilter::default()
        }
    }
}

fn body_kinds(field: &str, value: &Bound<'_, PyAny>) -> PyResult<BodyKinds> {
    let kinds = [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic];
    let kind = |value: &Bound<'_, PyAny>| {
        let place = one_of(field, value, &["static", "kinematic", "dynamic"])?;
        Ok::<_, PyErr>(BodyKinds::from(kinds[place]))
    };
    if value.is_instance_of::<PyString>() {
        return kind(value);
    }
    let mut set: Option<BodyKinds> = None;
    for item in value.try_iter().map_err(|_| wrong_type(field, value, "kinds of bodies"))? {
        let next = kind(&item?)?;
        set = Some(set.map_or(next, |set| set | next));
    }
    set.ok_or_else(|| bad(field, "nothing", "at least one kind of body"))
}
