//! The file as serde reads it. A field that is left out has the engine's default. The doc comments
//! are the descriptions of the JSON schema.

mod body;
mod joint;
mod strand;
mod world;

pub(crate) use self::body::{
    Body, Bond, Box, Capsule, Combine, Cone, Cylinder, Filter, Fracture, Geometry, Glue, HalfSpace,
    Hull, Kind, Layer, Material, Mesh, Reports, Senses, Shape, Sphere, Strength,
};
pub(crate) use self::joint::{
    Axis, AxisName, Ball, Cone6, ConeTwist, Coupling, Cylindrical, Distance, Drive, Fatigue, Fixed,
    Joint, JointStrength, LengthSpring, Motor, Planar, Pulley, RopeJoint, SixAxes, Spring,
    Universal, Wheel,
};
pub(crate) use self::strand::{
    Cloth, Cloud, Drop, Hold, Link, LinkKind, LinkSpring, Load, Loads, Orbit, Particle, Removed,
    Rope, Script, Strand, Wave,
};
pub(crate) use self::world::{
    Breakage, Contact, Inertia, Joints, Method, ParticleForm, Particles, Penalty, Sleep, World,
};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::value::{Ref, Table, Triple, Turn};

/// A scene of drystone. Units are SI: meters, kilograms, seconds, radians. Round shapes have their
/// axis along y.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Scene of drystone")]
pub(crate) struct Document {
    /// Version of the format: 1.
    #[schemars(range(min = 1, max = 1))]
    pub(crate) drystone: u32,
    /// Where the schema of the format is, for editors.
    #[serde(rename = "$schema")]
    pub(crate) schema: Option<String>,
    /// Name of the scene; that of the file if left out.
    pub(crate) name: Option<String>,
    /// A summary of the scene, in a line.
    pub(crate) summary: Option<String>,
    /// Steps a second that it is made for; 0.001 to 1e6; default 60.
    pub(crate) hz: Option<f32>,
    /// How long it is worth simulating [s]; default 10.
    pub(crate) seconds: Option<f32>,
    /// Gravity, method and the other settings of the world: the keys of `--set`.
    pub(crate) world: Option<World>,
    /// Names of layers: the first one is layer 0, which shapes are in by default. At most 64.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) layers: Vec<String>,
    /// Materials by name.
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    pub(crate) materials: Table<Material>,
    /// Shapes by name, for several bodies.
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    pub(crate) shapes: Table<Geometry>,
    /// Bodies, in the order in which they are added.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) bodies: Vec<Body>,
    /// Scenes of other files. Their bodies and joints come after those of this file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) parts: Vec<Part>,
    /// Joints, in the order in which they are added.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) joints: Vec<Joint>,
    /// Gears, racks and screws: a coordinate of one joint follows one of another.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) couplings: Vec<Coupling>,
    /// Ropes, cloths and clouds of particles.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) strands: Vec<Strand>,
    /// Named places on bodies, for traces.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) frames: Vec<Frame>,
    /// Pairs of bodies that never collide.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) never_collide: Vec<[Ref; 2]>,
    /// Surfaces of pairs of layers, in place of what their materials make together. The first rule
    /// that fits counts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) surface_rules: Vec<SurfaceRule>,
    /// Surfaces of two bodies, in place of what their materials make together; they count before
    /// `surface_rules`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) surfaces_between: Vec<SurfaceBetween>,
    /// Actions on the bodies while the scene runs, besides physics.
    pub(crate) script: Option<Script>,
    /// A glTF file beside this one: bodies look as its node does whose number is their `user_data`.
    pub(crate) visuals: Option<String>,
}

/// A scene of another file as a part of this one: glTF, URDF, MJCF, Rigid-IPC, or this format.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Part {
    /// The file, beside this one or in a folder below.
    pub(crate) file: String,
    /// Prefix of the names of its bodies, joints and frames: `left` makes `left/hand` of `hand`.
    pub(crate) name: String,
    /// Where its origin is [m, world].
    pub(crate) position: Option<Triple>,
    /// How it is turned. Robots have z up.
    pub(crate) rotation: Option<Turn>,
    /// For URDF: whether the world holds the first link; default `auto`.
    pub(crate) base: Option<Base>,
    /// For glTF without physics and for `.obj`: what its meshes become.
    pub(crate) auto_colliders: Option<AutoColliders>,
}

/// The base of a robot's first link.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Base {
    /// As its joints look.
    Auto,
    /// The world.
    Fixed,
    /// Nothing.
    Floating,
}

/// The collision shape of a mesh without physics.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum AutoColliders {
    /// Its convex hull.
    Hull,
    /// Itself.
    Mesh,
    /// The box around it.
    Box,
}

/// A named place on a body.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Frame {
    /// Its name; unique among bodies and frames.
    pub(crate) name: String,
    /// The body.
    pub(crate) body: Ref,
    /// Where it is [m, frame of the body].
    pub(crate) position: Option<Triple>,
    /// How it is turned [frame of the body].
    pub(crate) rotation: Option<Turn>,
    /// The point whose velocity is its own [m, frame of the body]; its place if left out.
    pub(crate) center: Option<Triple>,
}

/// Rules for surfaces of shapes in some layers.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SurfaceRule {
    /// Layers of one shape: it is in one of them.
    pub(crate) first: Vec<Layer>,
    /// Layers of the other one.
    pub(crate) second: Vec<Layer>,
    /// Coulomb friction coefficient, at least 0; that of the materials if left out.
    pub(crate) friction: Option<f32>,
    /// Friction coefficient of what slides; the same part of the friction as the materials say if
    /// left out.
    pub(crate) kinetic_friction: Option<f32>,
    /// Coefficient of restitution, 0 to 1; that of the materials if left out.
    pub(crate) restitution: Option<f32>,
    /// How their contacts give; as those of the world if left out.
    pub(crate) softness: Option<Softness>,
}

/// Rules for the surfaces of two bodies.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SurfaceBetween {
    /// The two bodies.
    pub(crate) bodies: [Ref; 2],
    /// Coulomb friction coefficient, at least 0; that of the materials if left out.
    pub(crate) friction: Option<f32>,
    /// Friction coefficient of what slides; the same part of the friction as the materials say if
    /// left out.
    pub(crate) kinetic_friction: Option<f32>,
    /// Coefficient of restitution, 0 to 1; that of the materials if left out.
    pub(crate) restitution: Option<f32>,
    /// How their contacts give; as those of the world if left out.
    pub(crate) softness: Option<Softness>,
}

/// Contacts that are damped springs: a mattress, a trampoline.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Softness {
    /// Stiffness as a frequency [Hz], 1e-6 to 1e6: what lies on it sinks in by g/(2πf)².
    pub(crate) hertz: f32,
    /// Damping ratio; at least 0.
    pub(crate) damping_ratio: f32,
}
