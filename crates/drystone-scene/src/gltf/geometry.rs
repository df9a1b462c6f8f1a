//! Collision geometry: implicit shapes and meshes, with the scale of their node.

use std::collections::BTreeMap;
use std::sync::Arc;

use drystone::math::{Mat3, trig};
use drystone::{BodyKind, Hull, Mesh, Shape, Vec3, vec3};

use super::document::Document;
use super::nodes::{Node, Tree};
use crate::error::SceneError;
use crate::read::json::At;
use crate::read::mesh::{Solid, Triangles};
use crate::transform::Affine;

/// Makes the shapes of a document.
pub(crate) struct Geometry<'a> {
    pub(crate) document: &'a Document,
    pub(crate) tree: &'a Tree,
    implicit: Vec<At<'a>>,
    /// Shapes made so far, so that equal ones are shared.
    made: BTreeMap<Key, Vec<Shape>>,
}

/// The source of a shape, besides the document.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    source: (&'static str, usize),
    linear: [u32; 9],
    hull: bool,
    is_dynamic: bool,
}

/// Names under which the extension with the shapes goes: the present one and the one of older
/// drafts.
pub(crate) const SHAPE_EXTENSIONS: [&str; 2] = ["KHR_implicit_shapes", "KHR_collision_shapes"];

/// The longest edge of an infinite plane on a moving body [m].
const PLANE: f32 = 1000.0;

impl<'a> Geometry<'a> {
    pub(crate) fn new(document: &'a Document, tree: &'a Tree) -> Result<Self, SceneError> {
        let root = At::root(&document.json);
        let mut implicit = Vec::new();
        for name in SHAPE_EXTENSIONS {
            if let Some(extension) = root.dig(&["extensions", name]) {
                implicit = extension.list("shapes")?;
                break;
            }
        }
        Ok(Self { document, tree, implicit, made: BTreeMap::new() })
    }

    /// The shapes of a collider or trigger `at` on node `node`, in that node's frame, for a body of
    /// kind `kind`. None if the geometry is switched off by a zero scale.
    pub(crate) fn shapes(
        &mut self,
        at: &At<'_>,
        node: usize,
        kind: BodyKind,
        notes: &mut Vec<String>,
    ) -> Result<Vec<Shape>, SceneError> {
        // Newer drafts wrap the reference in "geometry", older ones name the shape right here.
        let geometry = at.get("geometry").unwrap_or_else(|| at.clone()).object()?;
        let name = self.tree.name(node);
        let owner = &self.tree.nodes[node];
        let zero = owner.scale.abs().max_element() <= 1.0e-9;
        let flat = owner.scale.abs().min_element() <= 1.0e-9;
        let hull = geometry.flag("convexHull")?;
        if let Some(reference) = geometry.get("shape") {
            let shape = self.implicit[reference.index(self.implicit.len(), "shapes")?].clone();
            if zero {
                notes.push(format!(
                    "{name}: its scale is zero, its collision shape is switched off"
                ));
                return Ok(Vec::new());
            }
            let kind_at = shape.need("type")?;
            if kind_at.text()? == "mesh" {
                let inner = shape.need("mesh")?;
                let hull = hull
                    || inner.flag("convexHull")?
                    || shape
                        .dig(&["extensions", "KHR_physics_rigid_bodies"])
                        .map_or(Ok(false), |e| e.flag("convexHull"))?;
                return self.mesh(&inner.need("mesh")?, owner, hull, kind, &name, notes);
            }
            if flat {
                notes.push(format!(
                    "{name}: its scale is zero along an axis, its collision shape is left out"
                ));
                return Ok(Vec::new());
            }
            if owner.sheared {
                notes.push(format!(
                    "{name}: its transform shears, the collision shape is not sheared"
                ));
            }
            return implicit(&shape, owner.scale.abs(), kind, &name, notes).map(|s| vec![s]);
        }
        if zero {
            notes.push(format!("{name}: its scale is zero, its collision shape is switched off"));
            return Ok(Vec::new());
        }
        if let Some(reference) = geometry.get("mesh") {
            return self.mesh(&reference, owner, hull, kind, &name, notes);
        }
        if let Some(reference) = geometry.get("node") {
            let source = reference.index(self.tree.nodes.len(), "nodes")?;
            let key = key(("node", source), owner, hull, kind);
            return self.cached(key, |this, map| {
                let mut triangles = Triangles::default();
                triangles.add_node(this.document, this.tree, source, map, notes)?;
                finish(triangles, solid(hull, kind), &reference, &name, notes)
            });
        }
        Err(geometry.error("it names no geometry", "one of \"shape\", \"mesh\" or \"node\""))
    }

    /// The shapes of mesh `reference` as seen from node `owner`.
    pub(crate) fn mesh(
        &mut self,
        reference: &At<'_>,
        owner: &Node,
        hull: bool,
        kind: BodyKind,
        name: &str,
        notes: &mut Vec<String>,
    ) -> Result<Vec<Shape>, SceneError> {
        let key = key(("mesh", reference.size()?), owner, hull, kind);
        self.cached(key, |this, map| {
            let mut triangles = Triangles::default();
            triangles.add_mesh(this.document, reference, map, notes)?;
            finish(triangles, solid(hull, kind), reference, name, notes)
        })
    }

    fn cached(
        &mut self,
        key: (Key, Affine),
        make: impl FnOnce(&Self, &Affine) -> Result<Vec<Shape>, SceneError>,
    ) -> Result<Vec<Shape>, SceneError> {
        let (key, map) = key;
        if let Some(shapes) = self.made.get(&key) {
            return Ok(shapes.clone());
        }
        let shapes = make(self, &map)?;
        self.made.insert(key, shapes.clone());
        Ok(shapes)
    }
}

/// The part of a node's world transform that its pose leaves out: scale and shear.
pub(crate) fn stretch(node: &Node) -> Affine {
    let r = node.pose.rotation.to_mat3();
    let column = |c: Vec3| r.transpose_mul(c);
    let l = node.world.linear;
    // Where the transform is just a scale, no rounding of the rotation shall tilt the mesh.
    let linear = if node.sheared {
        Mat3 { x: column(l.x), y: column(l.y), z: column(l.z) }
    } else {
        Mat3::diagonal(node.scale)
    };
    Affine { linear, translation: Vec3::ZERO }
}

fn key(source: (&'static str, usize), owner: &Node, hull: bool, kind: BodyKind) -> (Key, Affine) {
    let map = stretch(owner);
    let l = map.linear;
    let linear = [l.x.x, l.x.y, l.x.z, l.y.x, l.y.y, l.y.z, l.z.x, l.z.y, l.z.z].map(f32::to_bits);
    (Key { source, linear, hull, is_dynamic: kind == BodyKind::Dynamic }, map)
}

fn finish(
    triangles: Triangles,
    solid: Solid,
    at: &At<'_>,
    name: &str,
    notes: &mut Vec<String>,
) -> Result<Vec<Shape>, SceneError> {
    triangles.shapes(solid, name, notes).map_err(|e| at.error(e.problem, e.allowed))
}

/// The solid of a mesh on a body of a kind; `hull` is set if the file requests its hull.
fn solid(hull: bool, kind: BodyKind) -> Solid {
    match kind {
        _ if hull => Solid::Hull,
        BodyKind::Dynamic => Solid::Hulls,
        BodyKind::Static | BodyKind::Kinematic => Solid::Mesh,
    }
}

/// A positive length of a shape, or its default.
fn length(at: Option<&At<'_>>, key: &str, default: f32) -> Result<f32, SceneError> {
    at.and_then(|a| a.get(key)).map_or(Ok(default), |v| v.above_zero())
}

fn radius(at: Option<&At<'_>>, key: &str) -> Result<f32, SceneError> {
    at.and_then(|a| a.get(key)).map_or(Ok(0.25), |v| v.at_least_zero())
}

/// An implicit shape stretched by `scale` (positive) along its own axes.
fn implicit(
    shape: &At<'_>,
    scale: Vec3,
    kind: BodyKind,
    name: &str,
    notes: &mut Vec<String>,
) -> Result<Shape, SceneError> {
    let type_at = shape.need("type")?;
    let type_ = type_at.text()?;
    let inner = shape.get(type_);
    let inner = inner.as_ref();
    let round = same(scale.x, scale.z);
    let uniform = round && same(scale.x, scale.y);
    let mut stretched = |what: &str| {
        notes.push(format!(
            "{name}: its {what} is stretched unevenly and taken as a hull of points on it"
        ));
    };
    let made = match type_ {
        "sphere" => {
            let r = length(inner, "radius", 0.5)?;
            if uniform {
                Shape::sphere(r * scale.x)
            } else {
                stretched("sphere");
                hull_of(shape, &ring_points(&[(r, 0.0), (r, 0.0)], scale))?
            }
        }
        "box" => {
            let size = inner.and_then(|b| b.get("size"));
            let size = match &size {
                Some(at) => {
                    at.items()?.iter().try_for_each(|c| c.above_zero().map(|_| ()))?;
                    at.vec3()?
                }
                None => Vec3::ONE,
            };
            Shape::box_full(size.mul_each(scale))
        }
        "capsule" => {
            let half = 0.5 * length(inner, "height", 0.5)?;
            let (bottom, top) = (radius(inner, "radiusBottom")?, radius(inner, "radiusTop")?);
            positive_one(shape, bottom, top)?;
            if uniform && same(bottom, top) {
                Shape::capsule(half * scale.y, top * scale.x)
            } else {
                if uniform {
                    notes.push(format!(
                        "{name}: its capsule has two radii and is taken as a hull of points on it"
                    ));
                } else {
                    stretched("capsule");
                }
                hull_of(shape, &ring_points(&[(bottom, -half), (top, half)], scale))?
            }
        }
        "cylinder" => {
            let half = 0.5 * length(inner, "height", 0.5)?;
            let (bottom, top) = (radius(inner, "radiusBottom")?, radius(inner, "radiusTop")?);
            positive_one(shape, bottom, top)?;
            if !round {
                stretched("cylinder");
                hull_of(shape, &rim_points(&[(bottom, -half), (top, half)], scale))?
            } else if same(bottom, top) {
                Shape::cylinder(half * scale.y, top * scale.x)
            } else {
                Shape::Cone {
                    half_height: half * scale.y,
                    radius_bottom: bottom * scale.x,
                    radius_top: top * scale.x,
                }
            }
        }
        "plane" => plane(shape, inner, scale, kind, name, notes)?,
        _ => {
            let allowed = "\"sphere\", \"box\", \"capsule\", \"cylinder\", \"plane\" or \"mesh\"";
            return Err(type_at.wrong(allowed));
        }
    };
    made.validate().map_err(|e| {
        let problem = format!("{} is {} at the scale of {name}", e.field, e.value);
        shape.error(problem, e.allowed)
    })?;
    Ok(made)
}

fn same(a: f32, b: f32) -> bool {
    (a - b).abs() <= 1.0e-4 * a.abs().max(b.abs())
}

fn positive_one(shape: &At<'_>, bottom: f32, top: f32) -> Result<(), SceneError> {
    if bottom > 0.0 || top > 0.0 {
        return Ok(());
    }
    Err(shape.error("both radii are 0", "one of the radii above 0"))
}

fn hull_of(at: &At<'_>, points: &[Vec3]) -> Result<Shape, SceneError> {
    let hull = Hull::from_points(points).map_err(|e| at.error(e, "a shape with a volume"))?;
    Ok(Shape::Hull(Arc::new(hull)))
}

/// Half a turn of latitudes and a turn of longitudes on a ball of `points`.
const LATITUDES: u16 = 10;
const LONGITUDES: u16 = 20;

/// Points on two balls (radius, height of the center), lower one first: southern half of the first,
/// northern half of the second; each point is then stretched.
fn ring_points(balls: &[(f32, f32); 2], scale: Vec3) -> Vec<Vec3> {
    let mut points = Vec::new();
    for (i, (radius, height)) in balls.iter().enumerate() {
        // Both balls in full: with unequal radii the larger one bulges past its equator.
        for latitude in 0..=LATITUDES {
            let (s, c) = trig::sin_cos(
                core::f32::consts::PI * (f32::from(latitude) / f32::from(LATITUDES) - 0.5),
            );
            let keep = if i == 0 { s <= 0.5 } else { s >= -0.5 };
            if keep {
                points.extend(ring(radius * c, height + radius * s, scale));
            }
        }
    }
    points
}

/// Points on two circles.
fn rim_points(rims: &[(f32, f32); 2], scale: Vec3) -> Vec<Vec3> {
    rims.iter().flat_map(|(radius, height)| ring(*radius, *height, scale)).collect()
}

fn ring(radius: f32, height: f32, scale: Vec3) -> Vec<Vec3> {
    let point = |k: u16| {
        let (s, c) = trig::sin_cos(core::f32::consts::TAU * f32::from(k) / f32::from(LONGITUDES));
        vec3(radius * c, height, radius * s).mul_each(scale)
    };
    (0..LONGITUDES).map(point).collect()
}

/// A plane: solid below it without end; with a size, two triangles.
fn plane(
    shape: &At<'_>,
    inner: Option<&At<'_>>,
    scale: Vec3,
    kind: BodyKind,
    name: &str,
    notes: &mut Vec<String>,
) -> Result<Shape, SceneError> {
    let edge = |key: &str, s: f32| -> Result<Option<f32>, SceneError> {
        let at = inner.and_then(|p| p.get(key));
        at.map(|v| Ok(v.above_zero()? * s)).transpose()
    };
    let (x, z) = (edge("sizeX", scale.x)?, edge("sizeZ", scale.z)?);
    if x.is_none() && z.is_none() && kind == BodyKind::Static {
        if inner.map_or(Ok(false), |p| p.flag("doubleSided"))? {
            notes.push(format!("{name}: its plane is solid below, not only on both of its sides"));
        }
        return Ok(Shape::half_space(Vec3::Y, 0.0));
    }
    if x.is_none() || z.is_none() {
        notes.push(format!("{name}: its endless plane is taken as {PLANE} m long"));
    }
    let (x, z) = (0.5 * x.unwrap_or(PLANE), 0.5 * z.unwrap_or(PLANE));
    if kind == BodyKind::Dynamic {
        let thickness = 0.01 * x.min(z);
        notes.push(format!(
            "{name}: its plane is taken as a plate {thickness} m thick, because the body is dynamic"
        ));
        return Ok(Shape::box_half(vec3(x, 0.5 * thickness, z)));
    }
    let points = vec![vec3(-x, 0.0, -z), vec3(-x, 0.0, z), vec3(x, 0.0, z), vec3(x, 0.0, -z)];
    let mesh = Mesh::new(points, vec![[0, 1, 2], [0, 2, 3]])
        .map_err(|e| shape.error(e, "a plane with an area"))?;
    Ok(Shape::Mesh(Arc::new(mesh)))
}
