//! Shapes, with their surface, place and filter.

use drystone::contact::Combine;
use drystone::events::{ContactReports, Senses};
use drystone::{Filter, Hull, Material, Mesh, Pose, Shape, ShapeDef};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::arrays::{array, real, triangles, vector, vectors};
use crate::errors::{bad, refused};
use crate::options::{Options, one_of};

const RULES: [(&str, Combine); 5] = [
    ("geometric_mean", Combine::GeometricMean),
    ("multiply", Combine::Multiply),
    ("maximum", Combine::Maximum),
    ("minimum", Combine::Minimum),
    ("average", Combine::Average),
];

/// A shape of a body: made once, used for any number of bodies and queries.
///
/// Every constructor takes these keywords: `position` [m, body], `rotation` [w, x, y, z, body],
/// `density` [kg/m³], `friction`, `kinetic_friction`, `restitution`, `rolling_resistance`,
/// `spinning_resistance`, `friction_combine`, `restitution_combine`, `layers`, `mask`, `exclude`,
/// `sensor`, `senses_statics`, `senses_sensors`, `surface_velocity` [m/s, shape], `surface_spin`
/// [rad/s, shape], `one_way`, `report_touches`, `report_hits`, `hit_speed` [m/s],
/// `report_forces`, `enabled`, `user_data`.
#[pyclass(name = "Shape", module = "drystone", frozen)]
pub(crate) struct PyShape(pub(crate) ShapeDef);

#[pymethods]
impl PyShape {
    /// A ball of this radius [m].
    #[staticmethod]
    #[pyo3(signature = (radius, **options))]
    fn sphere(radius: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        Self::made(Shape::sphere(real("radius", radius)?), options)
    }

    /// A capsule along y: half the distance of the centers of its end balls [m], and radius [m].
    #[staticmethod]
    #[pyo3(signature = (half_height, radius, **options))]
    fn capsule(
        half_height: &Bound<'_, PyAny>,
        radius: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let shape = Shape::capsule(real("half_height", half_height)?, real("radius", radius)?);
        Self::made(shape, options)
    }

    /// A box with these half extents [m].
    #[staticmethod]
    #[pyo3(signature = (half_extents, **options))]
    fn box_half(
        half_extents: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        Self::made(Shape::box_half(vector("half_extents", half_extents)?), options)
    }

    /// A box with these edge lengths [m].
    #[staticmethod]
    #[pyo3(signature = (extents, **options))]
    fn box_full(extents: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        Self::made(Shape::box_full(vector("extents", extents)?), options)
    }

    /// A cylinder along y: half its height [m], and radius [m].
    #[staticmethod]
    #[pyo3(signature = (half_height, radius, **options))]
    fn cylinder(
        half_height: &Bound<'_, PyAny>,
        radius: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let shape = Shape::cylinder(real("half_height", half_height)?, real("radius", radius)?);
        Self::made(shape, options)
    }

    /// A cone along y, tip up: half its height [m], radius at the bottom [m], and radius at the
    /// top [m]. Its origin is at half height.
    #[staticmethod]
    #[pyo3(signature = (half_height, radius, radius_top=None, **options))]
    fn cone(
        half_height: &Bound<'_, PyAny>,
        radius: &Bound<'_, PyAny>,
        radius_top: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let half_height = real("half_height", half_height)?;
        let radius_bottom = real("radius", radius)?;
        let radius_top = radius_top.map_or(Ok(0.0), |top| real("radius_top", top))?;
        Self::made(Shape::Cone { half_height, radius_bottom, radius_top }, options)
    }

    /// All points with `normal · p <= offset` [m, body]: infinite ground, for static bodies.
    #[staticmethod]
    #[pyo3(signature = (normal=None, offset=None, **options))]
    fn half_space(
        normal: Option<&Bound<'_, PyAny>>,
        offset: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let normal = normal.map_or(Ok(drystone::Vec3::Y), |n| vector("normal", n))?;
        let offset = offset.map_or(Ok(0.0), |d| real("offset", d))?;
        Self::made(Shape::half_space(normal, offset), options)
    }

    /// The convex hull of points, an array of shape (n, 3) [m, body].
    #[staticmethod]
    #[pyo3(signature = (points, **options))]
    fn hull(points: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let points = vectors("points", points)?;
        let hull = Hull::from_points(&points);
        let hull = hull.map_err(|e| bad("points", &e.to_string(), "points that span a volume"))?;
        Self::made(Shape::Hull(hull.into()), options)
    }

    /// A triangle mesh, for static and kinematic bodies: vertices (n, 3) [m, body], and the
    /// numbers of the three vertices of each triangle (m, 3).
    #[staticmethod]
    #[pyo3(name = "mesh", signature = (vertices, triangles, **options))]
    fn triangle_mesh(
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let (vertices, corners) =
            (vectors("vertices", vertices)?, self::triangles("triangles", triangles)?);
        let mesh = Mesh::new(vertices, corners);
        let mesh = mesh.map_err(|e| bad("triangles", &e.to_string(), "a mesh of triangles"))?;
        Self::made(Shape::Mesh(mesh.into()), options)
    }

    /// The same geometry with other options; those that are not given stay.
    #[pyo3(name = "replace", signature = (**options))]
    fn with_options(&self, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut def = self.0.clone();
        configure(&mut def, options)?;
        Ok(Self(def))
    }

    /// Its kind, such as 'sphere'.
    #[getter]
    fn kind(&self) -> String {
        self.0.shape.kind().replace([' ', '-'], "_")
    }

    /// Its density [kg/m³].
    #[getter]
    fn density(&self) -> f32 {
        self.0.density
    }

    /// Its friction coefficient.
    #[getter]
    fn friction(&self) -> f32 {
        self.0.material.friction
    }

    /// Its coefficient of restitution.
    #[getter]
    fn restitution(&self) -> f32 {
        self.0.material.restitution
    }

    /// Whether it is a sensor.
    #[getter]
    fn sensor(&self) -> bool {
        self.0.sensor
    }

    /// Corners of a hull or a mesh (n, 3) [m, shape]; None for other kinds.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let corners = match &self.0.shape {
            Shape::Hull(hull) => hull.vertices(),
            Shape::Mesh(mesh) => mesh.vertices(),
            _ => return Ok(None),
        };
        let numbers: Vec<f32> = corners.iter().flat_map(|v| v.to_array()).collect();
        array(py, numbers, &[corners.len(), 3]).map(Some)
    }

    fn __repr__(&self) -> String {
        match &self.0.shape {
            Shape::Hull(hull) => format!("<Shape hull of {} corners>", hull.vertices().len()),
            Shape::Mesh(mesh) => format!("<Shape mesh of {} triangles>", mesh.triangles().len()),
            shape => format!("<Shape {shape:?}>"),
        }
    }
}

impl PyShape {
    fn made(shape: Shape, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut def = ShapeDef::new(shape);
        configure(&mut def, options)?;
        Ok(Self(def))
    }
}

fn configure(def: &mut ShapeDef, given: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
    let options = Options::new("a shape", given);
    let ShapeDef { pose: Pose { position, rotation }, density, .. } = def;
    options.set_vector("position", position)?;
    if let Some(turned) = options.rotation("rotation")? {
        *rotation = turned;
    }
    options.set_real("density", density)?;
    surface(&mut def.material, &options)?;
    filter(&mut def.filter, &options)?;
    options.set_flag("sensor", &mut def.sensor)?;
    let Senses { statics, sensors } = &mut def.senses;
    options.set_flag("senses_statics", statics)?;
    options.set_flag("senses_sensors", sensors)?;
    options.set_vector("surface_velocity", &mut def.surface_velocity)?;
    options.set_vector("surface_spin", &mut def.surface_spin)?;
    if let Some(front) = options.vector("one_way")? {
        def.one_way = Some(front);
    }
    let ContactReports { touches, hits, hit_speed, forces } = &mut def.reports;
    options.set_flag("report_touches", touches)?;
    options.set_flag("report_hits", hits)?;
    if let Some(speed) = options.real("hit_speed")? {
        *hit_speed = Some(speed);
    }
    options.set_flag("report_forces", forces)?;
    options.set_flag("enabled", &mut def.enabled)?;
    options.set_whole("user_data", &mut def.user_data)?;
    options.finish()?;
    def.validate().map_err(|e| refused(&e))
}

pub(crate) fn surface(material: &mut Material, options: &Options<'_, '_>) -> PyResult<()> {
    options.set_real("friction", &mut material.friction)?;
    if let Some(kinetic) = options.real("kinetic_friction")? {
        material.kinetic_friction = Some(kinetic);
    }
    options.set_real("restitution", &mut material.restitution)?;
    options.set_real("rolling_resistance", &mut material.rolling_resistance)?;
    options.set_real("spinning_resistance", &mut material.spinning_resistance)?;
    let rule = |field: &str, value: &Bound<'_, PyAny>| {
        one_of(field, value, &RULES.map(|(name, _)| name)).map(|place| RULES[place].1)
    };
    if let Some(rule) = options.with("friction_combine", rule)? {
        material.friction_combine = rule;
    }
    if let Some(rule) = options.with("restitution_combine", rule)? {
        material.restitution_combine = rule;
    }
    Ok(())
}

pub(crate) fn filter(filter: &mut Filter, options: &Options<'_, '_>) -> PyResult<()> {
    options.set_whole("layers", &mut filter.layers)?;
    options.set_whole("mask", &mut filter.mask)?;
    options.set_whole("exclude", &mut filter.exclude)
}

/// The shapes of a list, or a single shape.
pub(crate) fn shapes(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<ShapeDef>> {
    if let Ok(one) = value.cast::<PyShape>() {
        return Ok(vec![one.get().0.clone()]);
    }
    let allowed = "a Shape, or a list of them";
    let wrong = |value: &Bound<'_, PyAny>| crate::arrays::wrong_type(field, value, allowed);
    if value.is_instance_of::<PyString>() {
        return Err(wrong(value));
    }
    let mut shapes = Vec::new();
    for item in value.try_iter().map_err(|_| wrong(value))? {
        let item = item?;
        match item.cast::<PyShape>() {
            Ok(shape) => shapes.push(shape.get().0.clone()),
            Err(_) => return Err(wrong(&item)),
        }
    }
    Ok(shapes)
}
