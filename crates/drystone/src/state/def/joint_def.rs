//! Definitions of joints and their validation.

mod strength;

pub use self::strength::{Fatigue, JointStrength};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::DefError;
use super::check::{above_zero, finite_vec, position, unit, within};
use super::six_dof::SixDof;
use crate::base::id::BodyId;
use crate::base::limits;
use crate::base::math::{Mat3, Vec3};
use crate::base::quat::Quat;
use crate::state::coupling::CouplingDef;

/// The kind of a joint, with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
#[expect(clippy::large_enum_variant, reason = "the tables box it; a definition is short-lived")]
pub enum JointKind {
    /// The two anchors coincide; rotation is free.
    Ball,
    /// The distance of the two anchors stays between two lengths.
    Distance {
        /// Minimum distance [m]; at least 0.
        min: f32,
        /// Maximum distance [m]; at least `min`.
        max: f32,
        /// A spring toward a rest length, between the limits.
        spring: Option<Spring>,
    },
    /// Each of six axes is free, locked, limited, sprung or driven. The anchors are the origins of
    /// the two frames.
    SixDof(SixDof),
    /// A rope over fixed points.
    Pulley(Pulley),
    /// A coordinate of one joint follows a coordinate of another. Only
    /// [`crate::World::add_coupling`] creates it.
    Coupling(CouplingDef),
    /// A link of an articulation and its parent. Only [`crate::World::add_articulation`] creates
    /// it.
    Link,
}

/// A rope from the first body over two fixed points to the second. `length_a + ratio · length_b` is
/// at most the length of the rope, where the two lengths are those from each anchor to its point.
///
/// ```
/// use drystone::joint::Pulley;
/// use drystone::{BodyId, JointDef};
///
/// /// Two buckets that hang 3 m below two wheels.
/// fn well(left: BodyId, right: BodyId) -> JointDef {
///     let rope = Pulley::rope([[-0.5, 4.0, 0.0], [0.5, 4.0, 0.0]], 6.0);
///     JointDef::new(left, right, rope).between([-0.5, 1.0, 0.0], [0.5, 1.0, 0.0])
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Pulley {
    /// The two fixed points, that of the first body first [m, world].
    pub points: [Vec3; 2],
    /// Length of the rope [m]; above 0.
    pub length: f32,
    /// Number of times that the rope runs to the second body, as in a block and tackle; 1e-3 to
    /// 1e3.
    pub ratio: f32,
    /// Whether the rope cannot go slack, like a chain of rods. Default false.
    pub is_rigid: bool,
}

impl Pulley {
    /// A rope of this length [m] over these points [m, world].
    #[must_use]
    pub fn rope(points: [impl Into<Vec3>; 2], length: f32) -> Self {
        Self { points: points.map(Into::into), length, ratio: 1.0, is_rigid: false }
    }

    /// Excess of the path over the rope [m], for these anchors [m, world].
    pub(crate) fn excess(&self, anchors: [Vec3; 2]) -> f32 {
        let [a, b] = [0, 1].map(|i| (anchors[i] - self.points[i]).length());
        a + self.ratio * b - self.length
    }

    fn validate(&self) -> Result<(), DefError> {
        position("points[0]", self.points[0])?;
        position("points[1]", self.points[1])?;
        within("length", self.length, &limits::LENGTH)?;
        if (1.0e-3..=1.0e3).contains(&self.ratio) {
            return Ok(());
        }
        Err(DefError::new("ratio", self.ratio, "a number from 1e-3 to 1e3"))
    }
}

/// A damped spring between two anchors: a joint by itself, or part of a [`crate::joint::Distance`].
///
/// ```
/// use drystone::joint::Spring;
/// use drystone::{BodyId, JointDef};
///
/// fn hang(ceiling: BodyId, lamp: BodyId) -> JointDef {
///     // 80 N/m under a lamp of 2 kg: 1 Hz.
///     let spring = Spring::with_stiffness(0.5, 80.0, 2.0, 2.0);
///     JointDef::new(ceiling, lamp, spring).between([0.0, 3.0, 0.0], [0.0, 2.5, 0.0])
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Spring {
    /// Rest length [m]; at least 0.
    pub rest_length: f32,
    /// Undamped frequency of the two bodies on the spring [Hz]; above 0.
    pub hertz: f32,
    /// Damping ratio; at least 0; 1 is critical.
    pub damping_ratio: f32,
}

impl Spring {
    /// A spring with this rest length [m], undamped frequency of the two bodies on it [Hz] and
    /// damping ratio (1: critical).
    #[must_use]
    pub const fn new(rest_length: f32, hertz: f32, damping_ratio: f32) -> Self {
        Self { rest_length, hertz, damping_ratio }
    }

    /// A spring with this rest length [m], stiffness [N/m] and damping [N s/m], for a mass on it
    /// [kg]. Between a body and an immovable one it is the body's mass, otherwise `1/(1/a + 1/b)`
    /// of both masses. The force is exact if the anchors are at the centers of mass, or in line
    /// with them. Elsewhere the bodies also rotate, which makes the spring softer.
    #[must_use]
    pub fn with_stiffness(rest_length: f32, stiffness: f32, damping: f32, mass: f32) -> Self {
        let omega = (stiffness / mass).sqrt();
        let hertz = omega / (2.0 * core::f32::consts::PI);
        Self::new(rest_length, hertz, damping / (2.0 * mass * omega))
    }
}

/// A joint between two bodies; one of them may be static or kinematic.
///
/// It defines the two bodies, the place and the kind: [`crate::joint`] has the kinds by name. The
/// manual: [joints](crate::manual::joints).
///
/// ```
/// use drystone::joint::Hinge;
/// use drystone::{BodyDef, JointDef, ShapeDef, World};
///
/// # fn main() -> Result<(), drystone::DefError> {
/// let mut world = World::default();
/// let wall = world.add_body(BodyDef::fixed())?;
/// let door = BodyDef::dynamic().with_position([0.5, 1.0, 0.0]);
/// let door = world.add_body(door.with_shape(ShapeDef::box_half([0.5, 1.0, 0.03])))?;
/// let hinge = JointDef::new(wall, door, Hinge::new().with_limits(0.0, 1.9));
/// let hinge = world.add_joint(hinge.at([0.0, 1.0, 0.0]).with_axis([0.0, 1.0, 0.0]))?;
/// assert_eq!(world.joint(hinge).and_then(|joint| joint.angle()), Some(0.0));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[expect(clippy::struct_excessive_bools, reason = "each is a question of its own")]
pub struct JointDef {
    /// First body.
    pub body_a: BodyId,
    /// Second body.
    pub body_b: BodyId,
    /// Anchor on the first body [m, frame of its origin; or world, see `world_anchors`].
    pub anchor_a: Vec3,
    /// Anchor on the second body [m, frame of its origin; or world, see `world_anchors`].
    pub anchor_b: Vec3,
    /// Whether the anchors are world points, for the poses of the bodies when the joint is added;
    /// default false.
    pub world_anchors: bool,
    /// Axes of both frames of a joint of six axes [world], for the poses of the bodies when it is
    /// added. All its coordinates are then 0 if the anchors coincide. `None` (the default): the
    /// frames are those of its kind.
    pub world_axes: Option<WorldAxes>,
    /// The kind of the joint.
    pub kind: JointKind,
    /// Whether the two bodies collide with each other; default false, except true for pulleys.
    pub collide_connected: bool,
    /// The load at which the joint breaks; `None` (the default): it never breaks.
    pub strength: Option<JointStrength>,
    /// Whether the whole tree of joints that contains this one is solved directly, whatever its
    /// loads; default false. Without it, only trees whose load exceeds `joint.tree_ratio` times a
    /// link's mass are. It is meant for robots and figures whose joints must hold exactly. A tree
    /// that closes a loop over moving bodies, or contains a rod or rope, is always solved joint by
    /// joint.
    pub articulated: bool,
    /// Whether the joint acts from the start; default true. See
    /// [`JointMut::set_enabled`](crate::JointMut::set_enabled).
    pub enabled: bool,
    /// A number for the user.
    pub user_data: u64,
}

/// Axes of a joint in the world, set by [`JointDef::with_axis`], [`JointDef::with_axes`] and
/// [`JointDef::with_rotation`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum WorldAxes {
    /// x is along this vector of any length; y and z are perpendicular to it and otherwise
    /// arbitrary.
    Along(Vec3),
    /// x is along the first vector; y is perpendicular to x and as near to the second vector as
    /// possible. The vectors have any length.
    Across(Vec3, Vec3),
    /// The world's axes, rotated.
    Turned(Quat),
}

impl WorldAxes {
    /// The axes as a rotation of the world's axes.
    ///
    /// # Errors
    /// A vector is not finite or has no length, both vectors are parallel, or a rotation is not a
    /// unit quaternion.
    pub(crate) fn rotation(&self) -> Result<Quat, DefError> {
        let direction = |name: &str, v: Vec3| {
            finite_vec(name, v)?;
            v.try_normalize()
                .ok_or_else(|| DefError::of_vec(name, v, "a direction of nonzero length"))
        };
        match *self {
            Self::Along(x) => Ok(Quat::from_arc(Vec3::X, direction("world_axes.x", x)?)),
            Self::Across(x, y) => {
                let (x, y) = (direction("world_axes.x", x)?, direction("world_axes.y", y)?);
                let z = x.cross(y);
                // Below this sine the plane of the two vectors is rounding of f32.
                if !(z.length() > 1.0e-5) {
                    let allowed = "a direction not parallel to the x axis";
                    return Err(DefError::of_vec("world_axes.y", y, allowed));
                }
                let z = z.normalize_or(Vec3::Z);
                Ok(Quat::from_mat3(Mat3 { x, y: z.cross(x), z }))
            }
            Self::Turned(frame) => {
                unit("world_axes", frame)?;
                Ok(frame.normalized())
            }
        }
    }
}

impl JointKind {
    /// Its name, for errors.
    pub(crate) const fn name(&self) -> &'static str {
        match self {
            Self::Ball => "a ball joint",
            Self::Distance { .. } => "a distance joint",
            Self::SixDof(_) => "a joint of six axes",
            Self::Pulley(_) => "a pulley",
            Self::Coupling(_) => "a coupling",
            Self::Link => "a link of an articulation",
        }
    }

    /// Checks every field. The world checks whether the joints of a coupling exist.
    pub(crate) fn validate(&self) -> Result<(), DefError> {
        match self {
            Self::Ball => Ok(()),
            Self::Link => Err(DefError::unsuitable(
                "kind",
                "a link of an articulation",
                "a kind of joint that `add_joint` makes",
            )),
            Self::Pulley(pulley) => pulley.validate().map_err(|e| e.within("pulley")),
            Self::SixDof(six_dof) => six_dof.validate(),
            Self::Coupling(coupling) => coupling.validate(),
            Self::Distance { min, max, spring } => {
                within("min", *min, &limits::DISTANCE)?;
                within("max", *max, &limits::DISTANCE)?;
                if max < min {
                    return Err(DefError::new("max", max, "at least `min`"));
                }
                let Some(s) = spring else { return Ok(()) };
                within("spring.rest_length", s.rest_length, &limits::DISTANCE)?;
                above_zero("spring.hertz", s.hertz)?;
                within("spring.hertz", s.hertz, &limits::FREQUENCY)?;
                within("spring.damping_ratio", s.damping_ratio, &limits::DAMPING_RATIO)
            }
        }
    }
}

impl JointDef {
    /// A joint of this kind between two bodies, with its anchors at their origins and the frames of
    /// its kind. Place it with [`Self::at`], or with [`Self::with_anchors`] and
    /// [`Self::with_frames`].
    #[must_use]
    pub fn new(body_a: BodyId, body_b: BodyId, kind: impl Into<JointKind>) -> Self {
        let kind = kind.into();
        Self {
            body_a,
            body_b,
            anchor_a: Vec3::ZERO,
            anchor_b: Vec3::ZERO,
            world_anchors: false,
            world_axes: None,
            kind,
            collide_connected: matches!(kind, JointKind::Pulley(_)),
            strength: None,
            articulated: false,
            enabled: true,
            user_data: 0,
        }
    }

    /// Places it at a point [m, world], for the poses of the bodies when it is added. Its axes are
    /// the world's unless they are set, so that a fixed joint holds the bodies in their current
    /// poses.
    #[must_use]
    pub fn at(self, point: impl Into<Vec3>) -> Self {
        let point = point.into();
        self.between(point, point)
    }

    /// Like [`Self::at`], with a point for each body [m, world]: the ends of a rope, a spring or a
    /// pulley.
    #[must_use]
    pub fn between(self, point_a: impl Into<Vec3>, point_b: impl Into<Vec3>) -> Self {
        let (anchor_a, anchor_b) = (point_a.into(), point_b.into());
        let world_axes = self.world_axes.or(Some(WorldAxes::Turned(Quat::IDENTITY)));
        Self { anchor_a, anchor_b, world_anchors: true, world_axes, ..self }
    }

    /// With its x axis along this direction [world, any length]: the axis of a hinge, a slider or a
    /// cone.
    #[must_use]
    pub fn with_axis(self, x: impl Into<Vec3>) -> Self {
        Self { world_axes: Some(WorldAxes::Along(x.into())), ..self }
    }

    /// With its x axis along the first direction, and its y axis perpendicular to x and as near to
    /// the second one as possible [world, any length]. The axes are suspension and axle of a wheel,
    /// or the two axes of a universal joint.
    #[must_use]
    pub fn with_axes(self, x: impl Into<Vec3>, y: impl Into<Vec3>) -> Self {
        Self { world_axes: Some(WorldAxes::Across(x.into(), y.into())), ..self }
    }

    /// With the world's axes, rotated by `rotation`.
    #[must_use]
    pub fn with_rotation(self, rotation: Quat) -> Self {
        Self { world_axes: Some(WorldAxes::Turned(rotation)), ..self }
    }

    /// With these anchors [m, each in the frame of its body's origin].
    #[must_use]
    pub fn with_anchors(self, anchor_a: impl Into<Vec3>, anchor_b: impl Into<Vec3>) -> Self {
        let (anchor_a, anchor_b) = (anchor_a.into(), anchor_b.into());
        Self { anchor_a, anchor_b, world_anchors: false, ..self }
    }

    /// With these frames of a joint of six axes [each in the frame of its body]; no effect on other
    /// kinds.
    #[must_use]
    pub fn with_frames(self, frame_a: Quat, frame_b: Quat) -> Self {
        let kind = match self.kind {
            JointKind::SixDof(six_dof) => JointKind::SixDof(SixDof { frame_a, frame_b, ..six_dof }),
            kind => kind,
        };
        Self { kind, world_axes: None, ..self }
    }

    /// Sets whether its two bodies collide with each other.
    #[must_use]
    pub fn with_collide_connected(self, collide_connected: bool) -> Self {
        Self { collide_connected, ..self }
    }

    /// Idle until [`JointMut::set_enabled`](crate::JointMut::set_enabled) enables it.
    #[must_use]
    pub fn starts_disabled(self) -> Self {
        Self { enabled: false, ..self }
    }

    /// With a number for the user.
    #[must_use]
    pub fn with_user_data(self, user_data: u64) -> Self {
        Self { user_data, ..self }
    }

    /// Sets whether it is solved directly with the tree of joints that contains it: see
    /// [`Self::articulated`].
    #[must_use]
    pub fn with_articulated(self, articulated: bool) -> Self {
        Self { articulated, ..self }
    }

    /// With a maximum force [N] and torque [N m], averaged over a substep, above which it breaks.
    #[must_use]
    pub fn with_strength(self, force: f32, torque: f32) -> Self {
        let strength = JointStrength { force, torque, ..self.strength.unwrap_or_default() };
        Self { strength: Some(strength), ..self }
    }

    /// With a maximum impulse in a step [N s], above which it breaks.
    #[must_use]
    pub fn with_impulse_limit(self, impulse: f32) -> Self {
        let strength = JointStrength { impulse, ..self.strength.unwrap_or_default() };
        Self { strength: Some(strength), ..self }
    }

    /// With wear by loads below its limits.
    #[must_use]
    pub fn with_fatigue(self, fatigue: Fatigue) -> Self {
        let fatigue = Some(fatigue);
        let strength = JointStrength { fatigue, ..self.strength.unwrap_or_default() };
        Self { strength: Some(strength), ..self }
    }

    /// Checks every field. The world checks whether the bodies exist.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        position("anchor_a", self.anchor_a)?;
        position("anchor_b", self.anchor_b)?;
        if let Some(axes) = &self.world_axes {
            axes.rotation()?;
        }
        if self.body_a == self.body_b {
            return Err(DefError::new(
                "body_b",
                "the same as body_a",
                "a body other than `body_a`",
            ));
        }
        if let JointKind::Coupling(_) = self.kind {
            return Err(DefError::new(
                "kind",
                "a coupling",
                "a kind other than a coupling; use World::add_coupling",
            ));
        }
        self.kind.validate()?;
        if let Some(strength) = self.strength {
            strength.validate().map_err(|e| e.within("strength"))?;
        }
        Ok(())
    }
}
