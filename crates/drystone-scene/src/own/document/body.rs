//! Bodies, their shapes and surfaces.

use core::fmt;
use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::joint::AxisName;
use crate::own::value::{Bound, Mass, Or, Triple, Turn};

/// A body with its shapes.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Body {
    /// Its name, unique in the scene; `#n` for the n-th body, counted from 0, if left out.
    pub(crate) name: Option<String>,
    /// How it moves; default `dynamic`.
    pub(crate) kind: Option<Kind>,
    /// Where its origin is [m, world].
    pub(crate) position: Option<Triple>,
    /// How it is turned.
    pub(crate) rotation: Option<Turn>,
    /// Velocity of the center of mass [m/s, world].
    pub(crate) linear_velocity: Option<Triple>,
    /// Angular velocity [rad/s, world].
    pub(crate) angular_velocity: Option<Triple>,
    /// Mass [kg], or all of it; from shapes and their densities if left out.
    pub(crate) mass: Option<Mass>,
    /// Gravity counts this many times; default 1.
    pub(crate) gravity_scale: Option<f32>,
    /// Linear velocity decays at this rate [1/s]; at least 0; default 0.
    pub(crate) linear_damping: Option<f32>,
    /// Angular velocity decays at this rate [1/s]; at least 0; default 0.
    pub(crate) angular_damping: Option<f32>,
    /// Axes of the world that it cannot move along or turn about.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) locks: Vec<AxisName>,
    /// Whether it may fall asleep; default true.
    pub(crate) can_sleep: Option<bool>,
    /// Speed below which it is slow [m/s]; that of the world if left out.
    pub(crate) sleep_speed: Option<f32>,
    /// Whether it sleeps from the start; default false.
    pub(crate) asleep: Option<bool>,
    /// Whether it is in the world from the start; default true.
    pub(crate) enabled: Option<bool>,
    /// Its shapes; several make a compound.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) shapes: Vec<Shape>,
    /// Bonds between its shapes, which come apart under stress.
    pub(crate) glue: Option<Glue>,
    /// Breaks into pieces where it is hit.
    pub(crate) fracture: Option<Fracture>,
    /// Any number.
    pub(crate) user_data: Option<u64>,
}

/// How a body moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Kind {
    /// Nothing.
    Static,
    /// Its velocity, which nothing but a script changes.
    Kinematic,
    /// Forces, contacts and joints.
    Dynamic,
}

/// A shape of a body: one of `shape`, `sphere`, `capsule`, `box`, `cylinder`, `cone`, `half_space`,
/// `hull`, `mesh`, `hulls`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Shape {
    /// The name of one of the file's shapes.
    pub(crate) shape: Option<String>,
    /// A ball.
    pub(crate) sphere: Option<Sphere>,
    /// A cylinder along y with half balls on its ends.
    pub(crate) capsule: Option<Capsule>,
    /// A box.
    #[serde(rename = "box")]
    pub(crate) cuboid: Option<Box>,
    /// A cylinder along y.
    pub(crate) cylinder: Option<Cylinder>,
    /// A cone along y, truncated where both radii are above 0.
    pub(crate) cone: Option<Cone>,
    /// Solid ground without end; on static bodies.
    pub(crate) half_space: Option<HalfSpace>,
    /// A convex hull.
    pub(crate) hull: Option<Hull>,
    /// A triangle mesh; on static and kinematic bodies.
    pub(crate) mesh: Option<Mesh>,
    /// A triangle mesh taken apart into hulls, for bodies that move.
    pub(crate) hulls: Option<Hulls>,
    /// Where it sits [m, body].
    pub(crate) position: Option<Triple>,
    /// How it is turned [body].
    pub(crate) rotation: Option<Turn>,
    /// Density [kg/m³]; at least 0; default 1000.
    pub(crate) density: Option<f32>,
    /// Its surface: the name of one of the file's materials, or a material.
    pub(crate) material: Option<Or<Material>>,
    /// The shapes it collides with.
    pub(crate) filter: Option<Filter>,
    /// It reports what overlaps it and touches nothing; default false.
    pub(crate) sensor: Option<bool>,
    /// Things it senses besides, as a sensor.
    pub(crate) senses: Option<Senses>,
    /// How its surface moves over it, as a conveyor belt does [m/s, frame of the shape].
    pub(crate) surface_velocity: Option<Triple>,
    /// Angular velocity of its surface about its origin [rad/s, frame of the shape].
    pub(crate) surface_spin: Option<Triple>,
    /// It holds only what comes from the front, in this direction [frame of the shape, any length].
    pub(crate) one_way: Option<Triple>,
    /// Contact hooks of a program run for its contacts; default false.
    pub(crate) hooks: Option<bool>,
    /// Which events its contacts give.
    pub(crate) reports: Option<Reports>,
    /// Whether it is in the world from the start; default true.
    pub(crate) enabled: Option<bool>,
    /// Any number.
    pub(crate) user_data: Option<u64>,
}

/// A shape by name, without the settings of the body.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Geometry {
    /// A ball.
    Sphere(Sphere),
    /// A cylinder along y with half balls on its ends.
    Capsule(Capsule),
    /// A box.
    Box(Box),
    /// A cylinder along y.
    Cylinder(Cylinder),
    /// A cone along y.
    Cone(Cone),
    /// Solid ground without end.
    HalfSpace(HalfSpace),
    /// A convex hull.
    Hull(Hull),
    /// A triangle mesh.
    Mesh(Mesh),
    /// A triangle mesh taken apart into hulls.
    Hulls(Hulls),
}

/// A ball.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Sphere {
    /// Radius [m]; above 0.
    pub(crate) radius: f32,
}

/// A cylinder along y with half balls on its ends.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Capsule {
    /// Half the distance of the centers of the balls [m]; at least 0.
    pub(crate) half_height: f32,
    /// Radius [m]; above 0.
    pub(crate) radius: f32,
}

/// A box.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Box {
    /// Half the edge lengths [m]; each above 0.
    pub(crate) half_extents: Triple,
}

/// A cylinder along y.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cylinder {
    /// Half the height [m]; above 0.
    pub(crate) half_height: f32,
    /// Radius [m]; above 0.
    pub(crate) radius: f32,
}

/// A cone along y; its origin is at half height.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cone {
    /// Half the height [m]; above 0.
    pub(crate) half_height: f32,
    /// Radius at the bottom [m]; at least 0.
    pub(crate) radius_bottom: f32,
    /// Radius at the top [m]; at least 0; default 0.
    pub(crate) radius_top: Option<f32>,
}

/// All points `p` with `normal · p <= offset`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HalfSpace {
    /// Away from the solid [frame of the shape], of any length; default `[0, 1, 0]`.
    pub(crate) normal: Option<Triple>,
    /// Distance of the surface from the origin along the normal [m]; default 0.
    pub(crate) offset: Option<f32>,
}

/// The convex hull of points, or of the corners of a file.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hull {
    /// The points [m, frame of the shape]; at least 4.
    pub(crate) points: Option<Vec<Triple>>,
    /// Faces, counter-clockwise from outside, as numbers of points: for a hull that is to be
    /// exactly so. It needs planes too.
    pub(crate) faces: Option<Vec<Vec<u16>>>,
    /// The plane of each face, `[x, y, z, offset]`.
    pub(crate) planes: Option<Vec<[f32; 4]>>,
    /// An `.obj` or `.stl` file beside this one, in place of points.
    pub(crate) file: Option<String>,
    /// Factors of the file's lengths along x, y, z; default 1.
    pub(crate) scale: Option<Triple>,
}

/// A triangle mesh, or that of a file.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Mesh {
    /// Vertices [m, frame of the shape].
    pub(crate) vertices: Option<Vec<Triple>>,
    /// Three numbers of vertices a triangle, of any winding.
    pub(crate) triangles: Option<Vec<[u32; 3]>>,
    /// An `.obj` or `.stl` file beside this one, in place of vertices.
    pub(crate) file: Option<String>,
    /// Factors of the file's lengths along x, y, z; default 1.
    pub(crate) scale: Option<Triple>,
}

/// A triangle mesh taken apart into hulls, each of which becomes a shape of the body.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hulls {
    /// An `.obj` or `.stl` file beside this one.
    pub(crate) file: String,
    /// Factors of the file's lengths along x, y, z; default 1.
    pub(crate) scale: Option<Triple>,
}

/// A surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Material {
    /// Coulomb friction coefficient; at least 0; default 0.6.
    pub(crate) friction: Option<f32>,
    /// Friction coefficient of what slides; at least 0; the same if left out.
    pub(crate) kinetic_friction: Option<f32>,
    /// Coefficient of restitution, 0 to 1; default 0.
    pub(crate) restitution: Option<f32>,
    /// Torque against rolling, as a part of normal force times radius; at least 0; default 0.
    pub(crate) rolling_resistance: Option<f32>,
    /// Torque about the normal, as a part of normal force times radius; at least 0; default 0.
    pub(crate) spinning_resistance: Option<f32>,
    /// Rule for the friction of two surfaces; default `geometric_mean`.
    pub(crate) friction_combine: Option<Combine>,
    /// Rule for the restitution of two surfaces; default `maximum`.
    pub(crate) restitution_combine: Option<Combine>,
}

/// How the coefficients of two surfaces become one. If two surfaces have different rules, the later
/// one here counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Combine {
    /// √(a b).
    GeometricMean,
    /// a b.
    Multiply,
    /// The larger one.
    Maximum,
    /// The smaller one.
    Minimum,
    /// (a + b) / 2.
    Average,
}

/// Filter of collisions: two shapes collide if each lets the other through its filter.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Filter {
    /// The layers that it is in; default layer 0.
    pub(crate) layers: Option<Vec<Layer>>,
    /// It collides only with shapes in one of these layers; with any shape if left out.
    pub(crate) mask: Option<Vec<Layer>>,
    /// It never collides with shapes in one of these layers; default none.
    pub(crate) exclude: Option<Vec<Layer>>,
}

/// A layer: one of the file's names of layers, or a number from 0 to 63.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Layer {
    /// By name.
    Name(String),
    /// By number.
    Number(u8),
}

impl Serialize for Layer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Name(name) => serializer.serialize_str(name),
            Self::Number(n) => serializer.serialize_u8(*n),
        }
    }
}

impl<'de> Deserialize<'de> for Layer {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(LayerVisitor)
    }
}

struct LayerVisitor;

impl Visitor<'_> for LayerVisitor {
    type Value = Layer;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a layer, or a number from 0 to 63")
    }

    fn visit_str<E: Error>(self, v: &str) -> Result<Layer, E> {
        Ok(Layer::Name(v.to_owned()))
    }

    fn visit_u64<E: Error>(self, v: u64) -> Result<Layer, E> {
        let number = u8::try_from(v).ok().filter(|n| *n < 64).map(Layer::Number);
        number.ok_or_else(|| E::invalid_value(serde::de::Unexpected::Unsigned(v), &self))
    }
}

impl JsonSchema for Layer {
    fn schema_name() -> Cow<'static, str> {
        "Layer".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "One of the file's names of layers, or a number from 0 to 63.",
            "anyOf": [{"type": "string"}, {"type": "integer", "minimum": 0, "maximum": 63}]
        })
    }
}

/// Things that a sensor senses besides the shapes of bodies that can move.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Senses {
    /// On a static body it sees the shapes of static bodies; default false.
    pub(crate) statics: Option<bool>,
    /// It sees sensors; default false.
    pub(crate) sensors: Option<bool>,
}

/// Which events the contacts of a shape give.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Reports {
    /// Contacts that begin and end; default true.
    pub(crate) touches: Option<bool>,
    /// Landings; default true.
    pub(crate) hits: Option<bool>,
    /// Least approach speed of a hit [m/s]; that of the world if left out.
    pub(crate) hit_speed: Option<f32>,
    /// Forces, in every step in which the pair touches; default false.
    pub(crate) forces: Option<bool>,
}

/// Bonds between the shapes of a body: either each of them, or one on every face that two shapes
/// share.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Glue {
    /// The bonds; they hold all shapes but sensors together. If left out, they are on every face
    /// that two shapes share.
    pub(crate) bonds: Option<Vec<Bond>>,
    /// Strength of each bond that has none of its own.
    pub(crate) strength: Option<Strength>,
    /// Faces that are no farther apart than this are shared [m]; above 0; default 0.001.
    pub(crate) gap: Option<f32>,
}

/// Glue on a face that two shapes share.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Bond {
    /// The two shapes, by their numbers in the body's shapes.
    pub(crate) shapes: [usize; 2],
    /// Middle of the face [m, body].
    pub(crate) point: Triple,
    /// From the first shape to the second [body], of any length.
    pub(crate) normal: Triple,
    /// Area of the face [m²]; above 0.
    pub(crate) area: f32,
    /// Its strength; that of the glue if left out.
    pub(crate) strength: Option<Strength>,
}

/// How much glue bears.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Strength {
    /// Greatest tension [Pa]; above 0; may be `"inf"`.
    pub(crate) tension: Bound,
    /// Greatest shear [Pa]; above 0; may be `"inf"`.
    pub(crate) shear: Bound,
}

/// A body of one box or hull breaks into pieces where it is hit.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Fracture {
    /// Greatest impulse of a blow [N s]; above 0; any if left out.
    pub(crate) impulse: Option<Bound>,
    /// Greatest energy of a blow [J]; above 0; any if left out.
    pub(crate) energy: Option<Bound>,
    /// Most pieces, 2 to 1024; default 12.
    pub(crate) pieces: Option<u32>,
    /// Least size of a piece [m]; above 0; default 0.02.
    pub(crate) min_size: Option<f32>,
    /// How much denser pieces are near the hit, 0 to 8; default 1.
    pub(crate) focus: Option<u32>,
    /// How often pieces break again, 1 to 16; default 1: not.
    pub(crate) generations: Option<u32>,
    /// Chooses the pieces.
    pub(crate) seed: Option<u64>,
}
