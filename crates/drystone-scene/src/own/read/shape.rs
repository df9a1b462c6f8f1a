//! Shapes and surfaces.

use std::sync::Arc;

use drystone::events::{ContactReports, Senses};
use drystone::{Hull, Mesh, Shape, ShapeDef, Vec3};

use super::reader::{Reader, known};
use crate::error::SceneError;
use crate::own::document::{self, Geometry};
use crate::own::place::Place;
use crate::own::saved_hull::SavedHull;
use crate::read::mesh::Solid;

/// The member of a shape that gives its kind.
pub(super) fn key(shape: &document::Shape) -> Option<&'static str> {
    let all = [
        (shape.shape.is_some(), "shape"),
        (shape.sphere.is_some(), "sphere"),
        (shape.capsule.is_some(), "capsule"),
        (shape.cuboid.is_some(), "box"),
        (shape.cylinder.is_some(), "cylinder"),
        (shape.cone.is_some(), "cone"),
        (shape.half_space.is_some(), "half_space"),
        (shape.hull.is_some(), "hull"),
        (shape.mesh.is_some(), "mesh"),
        (shape.hulls.is_some(), "hulls"),
    ];
    let mut said = all.into_iter().filter(|(is_there, _)| *is_there);
    let first = said.next().map(|(_, name)| name);
    if said.next().is_some() { None } else { first }
}

const KINDS: &str =
    "one of shape, sphere, capsule, box, cylinder, cone, half_space, hull, mesh, hulls";

impl Reader<'_> {
    /// A shape of a body: several where a mesh is taken apart.
    pub(super) fn shape(
        &mut self,
        place: &Place,
        shape: &document::Shape,
    ) -> Result<Vec<ShapeDef>, SceneError> {
        let shapes = self.shape_of(place, shape)?;
        let Some(first) = shapes.first() else { return Ok(Vec::new()) };
        let mut def = ShapeDef::new(first.clone());
        def.pose = self.pose(place, shape.position, shape.rotation)?;
        def.density = shape.density.unwrap_or(def.density);
        if let Some(material) = &shape.material {
            def.material = self.material_of(&place.key("material"), material)?;
        }
        if let Some(filter) = &shape.filter {
            def.filter = self.filter(&place.key("filter"), filter)?;
        }
        def.sensor = shape.sensor.unwrap_or(def.sensor);
        if let Some(senses) = &shape.senses {
            def.senses = Senses {
                statics: senses.statics.unwrap_or(false),
                sensors: senses.sensors.unwrap_or(false),
            };
        }
        def.surface_velocity = shape.surface_velocity.map_or(def.surface_velocity, Vec3::from);
        def.surface_spin = shape.surface_spin.map_or(def.surface_spin, Vec3::from);
        def.one_way = shape.one_way.map(Vec3::from);
        def.hooks = shape.hooks.unwrap_or(def.hooks);
        def.enabled = shape.enabled.unwrap_or(def.enabled);
        if let Some(reports) = &shape.reports {
            let default = ContactReports::default();
            def.reports = ContactReports {
                touches: reports.touches.unwrap_or(default.touches),
                hits: reports.hits.unwrap_or(default.hits),
                hit_speed: reports.hit_speed,
                forces: reports.forces.unwrap_or(default.forces),
            };
        }
        def.user_data = shape.user_data.unwrap_or(def.user_data);
        Ok(shapes.into_iter().map(|shape| ShapeDef { shape, ..def.clone() }).collect())
    }

    /// The geometry of a body's shape, by name or here.
    fn shape_of(
        &mut self,
        place: &Place,
        shape: &document::Shape,
    ) -> Result<Vec<Shape>, SceneError> {
        let Some(key) = key(shape) else {
            return Err(self.fail(place, "it has no kind, or more than one", KINDS));
        };
        if let Some(name) = &shape.shape {
            return self.shapes.get(name).cloned().ok_or_else(|| {
                let problem = format!("is \"{name}\", which no shape is called");
                self.fail(&place.key(key), problem, &known(self.shapes.keys()))
            });
        }
        let geometry = [
            shape.sphere.clone().map(Geometry::Sphere),
            shape.capsule.clone().map(Geometry::Capsule),
            shape.cuboid.clone().map(Geometry::Box),
            shape.cylinder.clone().map(Geometry::Cylinder),
            shape.cone.clone().map(Geometry::Cone),
            shape.half_space.clone().map(Geometry::HalfSpace),
            shape.hull.clone().map(Geometry::Hull),
            shape.mesh.clone().map(Geometry::Mesh),
            shape.hulls.clone().map(Geometry::Hulls),
        ];
        let Some(geometry) = geometry.into_iter().flatten().next() else { return Ok(Vec::new()) };
        self.made(&place.key(key), &geometry)
    }

    /// A shape of the file's table.
    pub(super) fn geometry(
        &mut self,
        place: &Place,
        geometry: &Geometry,
    ) -> Result<Vec<Shape>, SceneError> {
        let key = match geometry {
            Geometry::Sphere(_) => "sphere",
            Geometry::Capsule(_) => "capsule",
            Geometry::Box(_) => "box",
            Geometry::Cylinder(_) => "cylinder",
            Geometry::Cone(_) => "cone",
            Geometry::HalfSpace(_) => "half_space",
            Geometry::Hull(_) => "hull",
            Geometry::Mesh(_) => "mesh",
            Geometry::Hulls(_) => "hulls",
        };
        let shapes = self.made(&place.key(key), geometry)?;
        for shape in &shapes {
            shape.validate().map_err(|e| {
                self.fail(&place.key(key).field(e.field), format!("is {}", e.value), e.allowed)
            })?;
        }
        Ok(shapes)
    }

    fn made(&mut self, place: &Place, geometry: &Geometry) -> Result<Vec<Shape>, SceneError> {
        let one = match geometry {
            Geometry::Sphere(s) => Shape::Sphere { radius: s.radius },
            Geometry::Capsule(c) => Shape::Capsule { half_height: c.half_height, radius: c.radius },
            Geometry::Box(b) => Shape::Box { half_extents: b.half_extents.into() },
            Geometry::Cylinder(c) => {
                Shape::Cylinder { half_height: c.half_height, radius: c.radius }
            }
            Geometry::Cone(c) => Shape::Cone {
                half_height: c.half_height,
                radius_bottom: c.radius_bottom,
                radius_top: c.radius_top.unwrap_or(0.0),
            },
            Geometry::HalfSpace(h) => {
                let given = h.normal.unwrap_or([0.0, 1.0, 0.0]);
                let mut normal = Vec3::from(given);
                // A unit vector keeps its bits.
                if !((normal.length() - 1.0).abs() < 1.0e-6) {
                    normal = self.direction(&place.key("normal"), given)?;
                }
                Shape::HalfSpace { normal, offset: h.offset.unwrap_or(0.0) }
            }
            Geometry::Hull(document::Hull { file: Some(file), points: None, scale, .. }) => {
                return self.shapes_of_file(place, Solid::Hull, file, *scale);
            }
            Geometry::Mesh(document::Mesh {
                file: Some(file),
                vertices: None,
                triangles: None,
                scale,
            }) => {
                return self.shapes_of_file(place, Solid::Mesh, file, *scale);
            }
            Geometry::Hull(hull) => self.hull(place, hull)?,
            Geometry::Mesh(mesh) => self.mesh(place, mesh)?,
            Geometry::Hulls(hulls) => {
                return self.shapes_of_file(place, Solid::Hulls, &hulls.file, hulls.scale);
            }
        };
        Ok(vec![one])
    }

    fn hull(&self, place: &Place, hull: &document::Hull) -> Result<Shape, SceneError> {
        let made = match (&hull.points, &hull.file, hull.scale) {
            (Some(points), None, None) => {
                let points: Vec<Vec3> = points.iter().map(|p| Vec3::from(*p)).collect();
                match (&hull.faces, &hull.planes) {
                    (None, None) => Hull::from_points(&points).map_err(|e| e.to_string()),
                    (Some(faces), Some(planes)) => {
                        let planes =
                            planes.iter().map(|[x, y, z, offset]| drystone::geometry::Plane {
                                normal: Vec3::from([*x, *y, *z]),
                                offset: *offset,
                            });
                        let (planes, faces) = (planes.collect(), faces.clone());
                        SavedHull { vertices: points, planes, faces, cuboid: None }.hull()
                    }
                    _ => Err("it has faces without planes, or planes without faces".to_owned()),
                }
            }
            _ => {
                return Err(self.fail(
                    place,
                    "it has not one source",
                    "either points, or a file with its scale",
                ));
            }
        };
        let hull = made.map_err(|e| self.fail(place, e, "points that span a volume"))?;
        Ok(Shape::Hull(Arc::new(hull)))
    }

    fn mesh(&self, place: &Place, mesh: &document::Mesh) -> Result<Shape, SceneError> {
        let made = match (&mesh.vertices, &mesh.triangles, &mesh.file, mesh.scale) {
            (Some(vertices), Some(triangles), None, None) => {
                Mesh::new(vertices.iter().map(|v| Vec3::from(*v)).collect(), triangles.clone())
            }
            _ => {
                let allowed = "either vertices and triangles, or a file with its scale";
                return Err(self.fail(place, "it has not one source", allowed));
            }
        };
        let mesh = made
            .map_err(|e| self.fail(place, e, "a mesh with at least one triangle with an area"))?;
        Ok(Shape::Mesh(Arc::new(mesh)))
    }
}
