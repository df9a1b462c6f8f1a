//! Particles, and what happens while a scene runs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::body::{Body, Filter, Material};
use super::joint::Joint;
use crate::own::value::{Or, Ref, Triple};

/// Particles: one of `rope`, `cloth`, `cloud`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Strand {
    /// Its name.
    pub(crate) name: Option<String>,
    /// Particles in a row, each linked to the next.
    pub(crate) rope: Option<Rope>,
    /// A rectangle of linked particles.
    pub(crate) cloth: Option<Cloth>,
    /// Particles at points.
    pub(crate) cloud: Option<Cloud>,
    /// Links between its particles, beside its own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) links: Vec<Link>,
    /// Numbers of its particles that are pinned where they are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) pins: Vec<usize>,
    /// Its particles that bodies hold.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) holds: Vec<Hold>,
}

/// A rope.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Rope {
    /// Where it begins [m, world].
    pub(crate) from: Triple,
    /// Where it ends [m, world].
    pub(crate) to: Triple,
    /// Number of links, 1 to 1,000,000.
    pub(crate) links: usize,
    /// Its length [m]; from one end to the other if left out.
    pub(crate) length: Option<f32>,
    /// Mass of all of it [kg]; default 1.
    pub(crate) mass: Option<f32>,
    /// Kind of its links; default `at_most`.
    pub(crate) kind: Option<LinkKind>,
    /// Its first and its last particle are pinned; default neither.
    pub(crate) pinned: Option<[bool; 2]>,
    /// All else of its particles; default radius 0.02 m.
    pub(crate) particle: Option<Particle>,
    /// A link tears when it is stretched by more than this part of its length; never if left out.
    pub(crate) tear_strain: Option<f32>,
    /// A link tears when it pulls harder than this [N]; never if left out.
    pub(crate) tear_force: Option<f32>,
}

/// A cloth.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cloth {
    /// Its first corner [m, world].
    pub(crate) corner: Triple,
    /// Its sides, from there [m, world].
    pub(crate) sides: [Triple; 2],
    /// Squares along each side, 1 to 4,000.
    pub(crate) squares: [usize; 2],
    /// Mass of all of it [kg]; default 1.
    pub(crate) mass: Option<f32>,
    /// Links along its threads; default `at_most`.
    pub(crate) stretch: Option<LinkKind>,
    /// Links across its squares; default springs of 20 Hz.
    pub(crate) shear: Option<LinkKind>,
    /// Links over two squares, which resist bending; default springs of 5 Hz.
    pub(crate) bend: Option<LinkKind>,
    /// All else of its particles; default radius 0.02 m, damping 0.1/s.
    pub(crate) particle: Option<Particle>,
    /// A link of its threads tears when it is stretched by more than this part of its length; never
    /// if left out.
    pub(crate) tear_strain: Option<f32>,
    /// A link of its threads tears when it pulls harder than this [N]; never if left out.
    pub(crate) tear_force: Option<f32>,
}

/// Particles at points.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cloud {
    /// The points [m, world].
    pub(crate) points: Vec<Triple>,
    /// Properties of the particles.
    pub(crate) particle: Option<Particle>,
}

/// The kind of a link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum LinkKind {
    /// The distance is the length: a rod.
    Equal,
    /// The distance is at most the length: a thread.
    AtMost,
    /// A damped spring draws the distance to the length.
    Spring(LinkSpring),
    /// There is no such link; of a cloth's shear and bend.
    None,
}

/// A damped spring: `stiffness` and `damping`, or `hertz` and `damping_ratio`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LinkSpring {
    /// Force for each meter of stretch [N/m]; at least 0.
    pub(crate) stiffness: Option<f32>,
    /// Force for each m/s of lengthening [N s/m]; at least 0.
    pub(crate) damping: Option<f32>,
    /// Undamped frequency of two such masses [Hz]; at least 0.
    pub(crate) hertz: Option<f32>,
    /// Damping ratio; at least 0; 1 is critical.
    pub(crate) damping_ratio: Option<f32>,
}

/// Properties of a particle.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Particle {
    /// Its velocity [m/s, world]; default 0.
    pub(crate) velocity: Option<Triple>,
    /// Its mass [kg]; above 0; default 0.01. Ropes and cloths have a mass of their own instead.
    pub(crate) mass: Option<f32>,
    /// How far its center keeps from shapes [m]; 1e-4 to 1e3; default 0.01.
    pub(crate) radius: Option<f32>,
    /// Nothing moves it but its own velocity; default false.
    pub(crate) pinned: Option<bool>,
    /// Factor to the world's gravity; default 1.
    pub(crate) gravity_scale: Option<f32>,
    /// Rate at which its velocity decays [1/s]; at least 0; default 0.
    pub(crate) damping: Option<f32>,
    /// Its surface: the name of one of the file's materials, or a material.
    pub(crate) material: Option<Or<Material>>,
    /// Which shapes it collides with.
    pub(crate) filter: Option<Filter>,
}

/// A link between two particles of a strand.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Link {
    /// Number of the first particle in the strand.
    pub(crate) a: usize,
    /// Number of the second particle.
    pub(crate) b: usize,
    /// Its kind.
    pub(crate) kind: LinkKind,
    /// Its length [m]; the distance of its particles if left out.
    pub(crate) length: Option<f32>,
    /// It tears when it is stretched by more than this part of its length; never if left out.
    pub(crate) tear_strain: Option<f32>,
    /// It tears when it pulls harder than this [N]; never if left out.
    pub(crate) tear_force: Option<f32>,
}

/// A particle that a body holds.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hold {
    /// Number of the particle in the strand.
    pub(crate) particle: usize,
    /// The body.
    pub(crate) body: Ref,
    /// Where [m, frame of the body].
    pub(crate) point: Triple,
}

/// Actions besides physics.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Script {
    /// A kinematic body goes round.
    Orbit(Orbit),
    /// Bodies join one after the other.
    Drop(Drop),
    /// Forces and torques act on bodies, from a step on.
    Loads(Loads),
    /// Groups of bodies come and go.
    Waves(Vec<Wave>),
}

/// A kinematic body goes round in the xz plane, from angle 0.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Orbit {
    /// The body.
    pub(crate) body: Ref,
    /// Center of the circle [m].
    pub(crate) center: Triple,
    /// Radius [m].
    pub(crate) radius: f32,
    /// Degrees a step, with sign.
    pub(crate) degrees_per_step: f32,
}

/// One more of the bodies is added before steps `every`, 2 `every`, … (counted from 0).
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Drop {
    /// Steps between two of them.
    pub(crate) every: u64,
    /// The bodies, in the order in which they come.
    pub(crate) bodies: Vec<Body>,
}

/// Lasting forces and torques.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Loads {
    /// The first step with them, counted from 0; default 0.
    pub(crate) from: Option<u64>,
    /// The loads.
    pub(crate) loads: Vec<Load>,
}

/// A force and a torque on a dynamic body.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Load {
    /// The body.
    pub(crate) body: Ref,
    /// At its center of mass [N, world]; default 0.
    pub(crate) force: Option<Triple>,
    /// About it [N m, world]; default 0.
    pub(crate) torque: Option<Triple>,
}

/// Bodies that leave and join before a step.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wave {
    /// Before which step, counted from 0; waves are in the order of their steps.
    pub(crate) step: u64,
    /// Bodies that leave, with their joints.
    pub(crate) removed: Option<Removed>,
    /// Bodies that join.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) bodies: Vec<Body>,
    /// Joints that are added then.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) joints: Vec<Joint>,
}

/// Bodies one after the other, in the order in which they came.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Removed {
    /// The first of them.
    pub(crate) first: Ref,
    /// How many.
    pub(crate) count: usize,
}
