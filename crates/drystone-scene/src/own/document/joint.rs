//! Joints and couplings.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::own::value::{Bound, Ref, Triple, Turn};

/// A joint of two bodies: where it is, and one of `ball`, `cone_twist`, `hinge`, `slider`,
/// `cylindrical`, `universal`, `planar`, `fixed`, `wheel`, `servo`, `distance`, `rope`, `spring`,
/// `pulley`, `six_dof`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Joint {
    /// Its name, for couplings.
    pub(crate) name: Option<String>,
    /// First body.
    pub(crate) body_a: Ref,
    /// Second body.
    pub(crate) body_b: Ref,
    /// A point where both bodies are held [m, world].
    pub(crate) at: Option<Triple>,
    /// A point of each body [m, world]: the ends of a rope or a spring.
    pub(crate) between: Option<[Triple; 2]>,
    /// Direction of its x axis [world, any length]: that of a hinge's turn, a slider's way, a cone.
    pub(crate) axis: Option<Triple>,
    /// Directions of its x and y axis [world, any length].
    pub(crate) axes: Option<[Triple; 2]>,
    /// The axes of the world, turned so.
    pub(crate) rotation: Option<Turn>,
    /// Anchor on the first body [m, its frame], in place of `at`; default its origin.
    pub(crate) anchor_a: Option<Triple>,
    /// Anchor on the second body [m, its frame], in place of `at`; default its origin.
    pub(crate) anchor_b: Option<Triple>,
    /// Its axes on the first body [its frame], in place of `axis`.
    pub(crate) frame_a: Option<Turn>,
    /// Its axes on the second body [its frame], in place of `axis`.
    pub(crate) frame_b: Option<Turn>,
    /// Turns freely about a point.
    pub(crate) ball: Option<Ball>,
    /// A ball whose swing is within a cone about x, and whose twist is about x.
    pub(crate) cone_twist: Option<ConeTwist>,
    /// Turns about x.
    pub(crate) hinge: Option<Axis>,
    /// Moves along x.
    pub(crate) slider: Option<Axis>,
    /// Moves along x and turns about it.
    pub(crate) cylindrical: Option<Cylindrical>,
    /// Turns about x of the first body and y of the second.
    pub(crate) universal: Option<Universal>,
    /// Moves in the plane across x and turns about x.
    pub(crate) planar: Option<Planar>,
    /// Holds the second body as it was joined to the first.
    pub(crate) fixed: Option<Fixed>,
    /// A wheel on a chassis: sprung along x, spinning about y, steered about x.
    pub(crate) wheel: Option<Wheel>,
    /// Pulls the second body to a pose on the first.
    pub(crate) servo: Option<Servo>,
    /// The distance of the anchors is between two lengths.
    pub(crate) distance: Option<Distance>,
    /// The distance of the anchors is at most a length.
    pub(crate) rope: Option<RopeJoint>,
    /// A spring between the anchors.
    pub(crate) spring: Option<LengthSpring>,
    /// A rope over two points.
    pub(crate) pulley: Option<Pulley>,
    /// Each of six axes as it is said.
    pub(crate) six_dof: Option<SixAxes>,
    /// Whether its bodies collide; default false, of pulleys true.
    pub(crate) collide_connected: Option<bool>,
    /// The load it can bear; any load if left out.
    pub(crate) strength: Option<JointStrength>,
    /// The whole tree of its joints is solved at once; default false.
    pub(crate) articulated: Option<bool>,
    /// Whether it acts from the start; default true.
    pub(crate) enabled: Option<bool>,
    /// Any number.
    pub(crate) user_data: Option<u64>,
}

/// Two bodies turn freely about a point.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Ball {
    /// Greatest torque of dry friction about each axis [N m]; at least 0; default 0.
    pub(crate) friction: Option<f32>,
}

/// A ball in a socket with a cone.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ConeTwist {
    /// Greatest swing about y and about z [rad]; above 0.
    pub(crate) swing: [f32; 2],
    /// The spring that pushes back beyond the cone; hard if left out.
    pub(crate) spring: Option<Spring>,
    /// Greatest torque of dry friction against swings [N m]; at least 0; default 0.
    pub(crate) friction: Option<f32>,
    /// The turn about x; free if left out.
    pub(crate) twist: Option<Axis>,
}

/// An axis that bodies move along [m; N] or turn about [rad; N m]; free unless something is said.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Axis {
    /// It cannot move at all; default false.
    pub(crate) locked: Option<bool>,
    /// Least and greatest coordinate [m; rad]; either may be infinite.
    pub(crate) limits: Option<[Bound; 2]>,
    /// The spring that pushes back beyond the limits; hard if left out.
    pub(crate) limit_spring: Option<Spring>,
    /// Drives it at a speed.
    pub(crate) motor: Option<Motor>,
    /// Pulls it to a place.
    pub(crate) drive: Option<Drive>,
    /// Greatest force of dry friction [N; N m]; at least 0; default 0.
    pub(crate) friction: Option<Bound>,
}

/// Holds a speed with at most some force; a brake at speed 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Motor {
    /// The speed [m/s; rad/s].
    pub(crate) speed: f32,
    /// Greatest force [N; N m]; at least 0; may be `"inf"`.
    pub(crate) max_force: Bound,
}

/// Pulls to a coordinate that moves, by a damped spring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Drive {
    /// Coordinate without force [m; rad]; default 0.
    pub(crate) position: Option<f32>,
    /// Speed without damping [m/s; rad/s]; default 0.
    pub(crate) velocity: Option<f32>,
    /// The law of its force.
    pub(crate) spring: Spring,
    /// Greatest force [N; N m]; at least 0; any if left out.
    pub(crate) max_force: Option<Bound>,
}

/// A damped spring: by stiffness and damping, or by the frequency of the two bodies on it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Spring {
    /// Force per displacement [N/m; N m/rad; 1/s² if `per_mass`]; at least 0.
    pub(crate) stiffness: Option<f32>,
    /// Force per speed [N s/m; N m s/rad; 1/s if `per_mass`]; at least 0; may be `"inf"`.
    pub(crate) damping: Option<Bound>,
    /// Both count per effective mass of the two bodies; default false.
    pub(crate) per_mass: Option<bool>,
    /// Undamped frequency of the two bodies on it [Hz], in place of the stiffness.
    pub(crate) hertz: Option<f32>,
    /// Damping ratio beside `hertz`; 1 is critical.
    pub(crate) damping_ratio: Option<f32>,
}

/// Moves along x and turns about it.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cylindrical {
    /// The motion [m; N].
    pub(crate) along: Option<Axis>,
    /// The turn [rad; N m].
    pub(crate) about: Option<Axis>,
}

/// Turns about x of the first body and y of the second.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Universal {
    /// The turn about x.
    pub(crate) x: Option<Axis>,
    /// The turn about y.
    pub(crate) y: Option<Axis>,
}

/// Moves along y and z and turns about x.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Planar {
    /// The motion along y.
    pub(crate) y: Option<Axis>,
    /// The motion along z.
    pub(crate) z: Option<Axis>,
    /// The turn about x.
    pub(crate) turn: Option<Axis>,
}

/// Holds the second body on the first.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Fixed {
    /// The spring that holds motions; rigid if left out.
    pub(crate) linear: Option<Spring>,
    /// The spring that holds turns; rigid if left out.
    pub(crate) angular: Option<Spring>,
}

/// A wheel on a chassis.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wheel {
    /// The spring along x; a rigid axle if left out.
    pub(crate) suspension: Option<Spring>,
    /// Hard stops of the spring [m]: below 0 it hangs out, above 0 it is pushed in.
    pub(crate) travel: Option<[Bound; 2]>,
    /// The turn about y; free if left out.
    pub(crate) spin: Option<Axis>,
    /// The turn about x; locked if left out.
    pub(crate) steering: Option<Axis>,
}

/// Pulls the second body to a pose on the first.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Servo {
    /// The law of the force.
    pub(crate) linear: Spring,
    /// The law of the torque; any turn is free if left out.
    pub(crate) angular: Option<Spring>,
    /// Greatest force along each axis [N]; any if left out.
    pub(crate) max_force: Option<Bound>,
    /// Greatest torque about each axis [N m]; any if left out.
    pub(crate) max_torque: Option<Bound>,
}

/// The distance of two points stays between two lengths.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Distance {
    /// Least distance [m]; at least 0.
    pub(crate) min: f32,
    /// Greatest distance [m]; at least `min`.
    pub(crate) max: f32,
    /// A spring toward a length, between the limits.
    pub(crate) spring: Option<LengthSpring>,
}

/// The distance of two points is at most a length.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RopeJoint {
    /// The length [m]; at least 0.
    pub(crate) length: f32,
}

/// A damped spring between two points.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LengthSpring {
    /// Length without force [m]; at least 0.
    pub(crate) rest_length: f32,
    /// Undamped frequency of the two bodies on it [Hz]; above 0.
    pub(crate) hertz: f32,
    /// Damping ratio; at least 0; 1 is critical.
    pub(crate) damping_ratio: f32,
}

/// A rope from the first body over two fixed points to the second.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Pulley {
    /// The points that it goes over [m, world].
    pub(crate) points: [Triple; 2],
    /// Its length [m]; above 0.
    pub(crate) length: f32,
    /// How many times it goes to the second body, 1e-3 to 1e3; default 1.
    pub(crate) ratio: Option<f32>,
    /// It cannot go slack; default false.
    pub(crate) is_rigid: Option<bool>,
}

/// Six axes; one that is left out is locked, and `{}` is free.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SixAxes {
    /// Motion along x [m; N].
    pub(crate) x: Option<Axis>,
    /// Motion along y [m; N].
    pub(crate) y: Option<Axis>,
    /// Motion along z [m; N].
    pub(crate) z: Option<Axis>,
    /// Turn about x [rad; N m].
    pub(crate) turn_x: Option<Axis>,
    /// Turn about y [rad; N m].
    pub(crate) turn_y: Option<Axis>,
    /// Turn about z [rad; N m].
    pub(crate) turn_z: Option<Axis>,
    /// A limit of the turns about y and z together, which are free themselves.
    pub(crate) cone: Option<Cone6>,
}

/// A limit of both swings.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cone6 {
    /// Greatest swing about y and about z [rad]; above 0.
    pub(crate) swing: [f32; 2],
    /// The spring that pushes back beyond it; hard if left out.
    pub(crate) spring: Option<Spring>,
}

/// The load that a joint can bear.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct JointStrength {
    /// Greatest force [N]; above 0; any if left out.
    pub(crate) force: Option<f32>,
    /// Greatest torque [N m]; above 0; any if left out.
    pub(crate) torque: Option<f32>,
    /// Greatest impulse in a step [N s]; above 0; any if left out.
    pub(crate) impulse: Option<f32>,
    /// Loads below these limits wear it out.
    pub(crate) fatigue: Option<Fatigue>,
}

/// How loads below its limits wear a joint out.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Fatigue {
    /// How long a load as large as the limit is borne [s]; above 0.
    pub(crate) life: f32,
    /// Power of the load, 1 to 32.
    pub(crate) exponent: u32,
    /// Part of the limits below which a load does no harm, 0 to 1.
    pub(crate) endurance: f32,
}

/// `coordinate b = ratio · coordinate a + offset` between two joints of six axes.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Coupling {
    /// The joint that is followed.
    pub(crate) joint_a: Ref,
    /// Its axis.
    pub(crate) axis_a: AxisName,
    /// The joint that follows.
    pub(crate) joint_b: Ref,
    /// Its axis.
    pub(crate) axis_b: AxisName,
    /// How far b goes for each unit of a; not 0.
    pub(crate) ratio: f32,
    /// Where b is with a at 0 [m; rad]; default 0.
    pub(crate) offset: Option<f32>,
}

/// An axis of a joint, or of the world: a motion along it, or a turn about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum AxisName {
    /// Motion along x.
    X,
    /// Motion along y.
    Y,
    /// Motion along z.
    Z,
    /// Turn about x.
    TurnX,
    /// Turn about y.
    TurnY,
    /// Turn about z.
    TurnZ,
}
