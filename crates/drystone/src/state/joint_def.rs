//! What a user says of a joint, and how it is checked.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::check::{above_zero, finite_vec, position, unit, within};
use super::coupling::CouplingDef;
use super::def::DefError;
use super::sixdof::SixDof;
use crate::base::id::BodyId;
use crate::base::limits;
use crate::base::math::{Mat3, Vec3};
use crate::base::quat::Quat;

/// What a joint does.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
#[expect(clippy::large_enum_variant, reason = "the tables box it; a definition is short-lived")]
pub enum JointKind {
    /// The two anchors stay together; rotation is free.
    Ball,
    /// The distance of the two anchors stays between two lengths.
    Distance {
        /// Least distance [m]; at least 0.
        min: f32,
        /// Greatest distance [m]; at least `min`.
        max: f32,
        /// A spring toward a rest length, between the limits.
        spring: Option<Spring>,
    },
    /// Each of six axes is free, locked, limited, sprung or driven. Its anchors are the origins of its
    /// frames.
    SixDof(SixDof),
    /// A rope over fixed points.
    Pulley(Pulley),
    /// A coordinate of one joint follows one of another; made by [`crate::World::add_coupling`] only.
    Coupling(CouplingDef),
}

/// A rope from the first body over two fixed points to the second: `length_a + ratio · length_b` is no more than
/// its length, where the lengths are those from each anchor to its point.
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
    /// The points it goes over, that of the first body first [m, world].
    pub points: [Vec3; 2],
    /// Length of the rope [m]; above 0.
    pub length: f32,
    /// How many times the rope goes to the second body, as in a block and tackle; 1e-3 to 1e3.
    pub ratio: f32,
    /// It cannot go slack: a chain of rods. Default false.
    pub is_rigid: bool,
}

impl Pulley {
    /// A rope of this length [m] over these points [m, world].
    #[must_use]
    pub fn rope(points: [impl Into<Vec3>; 2], length: f32) -> Self {
        Self { points: points.map(Into::into), length, ratio: 1.0, is_rigid: false }
    }

    /// How much longer the way is than the rope [m], its anchors being here [m, world].
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

/// A damped spring between two anchors: a joint of its own, or part of a [`crate::joint::Distance`].
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
    /// Length without force [m]; at least 0.
    pub rest_length: f32,
    /// Undamped frequency of the two bodies on it [Hz]; above 0.
    pub hertz: f32,
    /// Damping ratio; at least 0; 1 is critical.
    pub damping_ratio: f32,
}

impl Spring {
    /// With this length without force [m], undamped frequency of the two bodies on it [Hz] and damping ratio (1: critical).
    #[must_use]
    pub const fn new(rest_length: f32, hertz: f32, damping_ratio: f32) -> Self {
        Self { rest_length, hertz, damping_ratio }
    }

    /// With this length without force [m], stiffness [N/m] and damping [N s/m], for a mass on it [kg]: that of the body
    /// that hangs on one that does not move, else `1/(1/a + 1/b)` of both. Its force is exact while the anchors are at the
    /// centers of mass, or in line with them; elsewhere a body that turns yields more, and the spring is softer by that.
    #[must_use]
    pub fn with_stiffness(rest_length: f32, stiffness: f32, damping: f32, mass: f32) -> Self {
        let omega = (stiffness / mass).sqrt();
        let hertz = omega / (2.0 * core::f32::consts::PI);
        Self::new(rest_length, hertz, damping / (2.0 * mass * omega))
    }
}

/// A joint between two bodies; one of them may be static or kinematic.
///
/// It says between whom, where, and of which kind: [`crate::joint`] has the kinds by name. The manual:
/// [joints](crate::manual::joints).
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
    /// The anchors are points of the world, where the bodies lie when the joint is added; default false.
    pub world_anchors: bool,
    /// Axes of both frames of a joint of six axes [world], as the bodies lie when it is added: all its coordinates are 0
    /// then if its anchors meet. `None`, the default: the frames are those of its kind.
    pub world_axes: Option<WorldAxes>,
    /// What it does.
    pub kind: JointKind,
    /// Whether the two bodies collide with each other; default false, but true for pulleys.
    pub collide_connected: bool,
    /// What it can bear; `None`, the default: anything.
    pub strength: Option<JointStrength>,
    /// Solve the whole tree of joints that this one belongs to at once, whatever loads it carries; default
    /// false. Without it trees are that carry `joint.tree_ratio` times a link's mass. For robots and
    /// figures whose joints must hold exactly; a tree that closes a loop over bodies that move, or has a rod or
    /// rope in it, is solved joint by joint all the same.
    pub articulated: bool,
    /// Whether it acts from the start; default true. See [`JointMut::set_enabled`](crate::JointMut::set_enabled).
    pub enabled: bool,
    /// Any number of the user's.
    pub user_data: u64,
}

/// Axes of a joint, told in the world: what [`JointDef::with_axis`], [`JointDef::with_axes`] and
/// [`JointDef::with_rotation`] set.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum WorldAxes {
    /// x is along this vector of any length; y and z are somewhere across it.
    Along(Vec3),
    /// x is along the first vector; y is as near to the second as a right angle allows. Both have any length.
    Across(Vec3, Vec3),
    /// The axes of the world, turned so.
    Turned(Quat),
}

impl WorldAxes {
    /// As a rotation of the world's axes.
    ///
    /// # Errors
    /// A vector is not finite or has no length, or both have one direction; a rotation that is not a unit quaternion.
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
                // Below this sine the plane of both is rounding of f32.
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

/// What a joint can bear. It breaks at the end of a step in which it had to bear more: it is removed, and
/// [`crate::events::Events::joint_break`] tells of it. Force and torque are the means of each substep of the
/// step, in whatever parts an island takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct JointStrength {
    /// Greatest force [N]; above 0; may be infinite, as by default.
    pub force: f32,
    /// Greatest torque of a joint of six axes [N m]; above 0; may be infinite, as by default.
    pub torque: f32,
    /// Greatest impulse in a step [N s]: the force times time, summed over the step; above 0; may be infinite, as by
    /// default. A blow passes it in whichever substep it comes.
    pub impulse: f32,
    /// Loads below these limits wear the joint out; default `None`: they do not.
    pub fatigue: Option<Fatigue>,
}

/// How loads below its limits wear a joint out: damage grows by (load / limit)^`exponent` × time / `life` while that
/// ratio, the largest of force and torque, is at least `endurance`, and the joint breaks when it reaches 1.
/// Damage adds up in whatever order loads come [Miner45], at a rate that is a power of the load
/// [Basquin10]. The impulse has no part in it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Fatigue {
    /// How long a load as large as the limit is borne [s]; above 0.
    pub life: f32,
    /// Power of the load, 1 to 32; metals have 3 to 10.
    pub exponent: u32,
    /// Part of the limits below which a load does no harm; 0 to 1.
    pub endurance: f32,
}

impl Default for JointStrength {
    /// Bears anything.
    fn default() -> Self {
        let force = f32::INFINITY;
        Self { force, torque: force, impulse: force, fatigue: None }
    }
}

impl JointStrength {
    pub(crate) fn validate(&self) -> Result<(), DefError> {
        let limits = [("force", self.force), ("torque", self.torque), ("impulse", self.impulse)];
        for (name, value) in limits {
            if value != f32::INFINITY {
                above_zero(name, value)?;
            }
        }
        let Some(fatigue) = self.fatigue else { return Ok(()) };
        fatigue.validate().map_err(|e| e.within("fatigue"))
    }
}

impl Fatigue {
    fn validate(&self) -> Result<(), DefError> {
        above_zero("life", self.life)?;
        if !(1..=32).contains(&self.exponent) {
            return Err(DefError::new("exponent", self.exponent, "a number from 1 to 32"));
        }
        if !(0.0..=1.0).contains(&self.endurance) {
            return Err(DefError::new("endurance", self.endurance, "a number from 0 to 1"));
        }
        Ok(())
    }

    /// Damage that a load of this part of the limit does in a time [s].
    pub(crate) fn damage(&self, part: f32, time: f32) -> f32 {
        if !(part >= self.endurance) {
            return 0.0;
        }
        (0..self.exponent).fold(time / self.life, |damage, _| damage * part)
    }
}

impl JointKind {
    /// Its name, in errors.
    pub(crate) const fn name(&self) -> &'static str {
        match self {
            Self::Ball => "a ball joint",
            Self::Distance { .. } => "a distance joint",
            Self::SixDof(_) => "a joint of six axes",
            Self::Pulley(_) => "a pulley",
            Self::Coupling(_) => "a coupling",
        }
    }

    /// Checks every field; whether the joints that a coupling names exist is checked by the world.
    pub(crate) fn validate(&self) -> Result<(), DefError> {
        match self {
            Self::Ball => Ok(()),
            Self::Pulley(pulley) => pulley.validate().map_err(|e| e.within("pulley")),
            Self::SixDof(six) => six.validate(),
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
    /// A joint of this kind between two bodies, with its anchors at their origins and the frames of its kind, until it is
    /// told where it is: [`Self::at`], or [`Self::with_anchors`] and [`Self::with_frames`].
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

    /// At a point [m, world], where the bodies lie when it is added. Its axes are the world's unless they are told, so that
    /// a fixed joint holds the bodies as they are.
    #[must_use]
    pub fn at(self, point: impl Into<Vec3>) -> Self {
        let point = point.into();
        self.between(point, point)
    }

    /// As [`Self::at`], with a point for each body [m, world]: the ends of a rope, a spring or a pulley.
    #[must_use]
    pub fn between(self, point_a: impl Into<Vec3>, point_b: impl Into<Vec3>) -> Self {
        let (anchor_a, anchor_b) = (point_a.into(), point_b.into());
        let world_axes = self.world_axes.or(Some(WorldAxes::Turned(Quat::IDENTITY)));
        Self { anchor_a, anchor_b, world_anchors: true, world_axes, ..self }
    }

    /// With its x axis along this direction [world, any length]: that of a hinge's turn, a slider's way, a cone.
    #[must_use]
    pub fn with_axis(self, x: impl Into<Vec3>) -> Self {
        Self { world_axes: Some(WorldAxes::Along(x.into())), ..self }
    }

    /// With its x axis along the first direction, its y axis as near to the second as a right angle allows [world, any
    /// length]: way and axle of a wheel, the two axes of a universal joint.
    #[must_use]
    pub fn with_axes(self, x: impl Into<Vec3>, y: impl Into<Vec3>) -> Self {
        Self { world_axes: Some(WorldAxes::Across(x.into(), y.into())), ..self }
    }

    /// With the world's axes, turned so.
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

    /// With these axes of a joint of six axes [each in the frame of its body]; other kinds have none.
    #[must_use]
    pub fn with_frames(self, frame_a: Quat, frame_b: Quat) -> Self {
        let kind = match self.kind {
            JointKind::SixDof(six) => JointKind::SixDof(SixDof { frame_a, frame_b, ..six }),
            kind => kind,
        };
        Self { kind, world_axes: None, ..self }
    }

    /// Lets its two bodies collide with each other, or not.
    #[must_use]
    pub fn with_collide_connected(self, collide_connected: bool) -> Self {
        Self { collide_connected, ..self }
    }

    /// Idle until [`JointMut::set_enabled`](crate::JointMut::set_enabled) switches it on.
    #[must_use]
    pub fn starts_disabled(self) -> Self {
        Self { enabled: false, ..self }
    }

    /// With a number of the user's.
    #[must_use]
    pub fn with_user_data(self, user_data: u64) -> Self {
        Self { user_data, ..self }
    }

    /// Solved at once with the tree of joints that it belongs to: see [`Self::articulated`].
    #[must_use]
    pub fn with_articulated(self, articulated: bool) -> Self {
        Self { articulated, ..self }
    }

    /// Breaks where it would have to bear more than this force [N] or torque [N m], as the mean of a substep.
    #[must_use]
    pub fn with_strength(self, force: f32, torque: f32) -> Self {
        let strength = JointStrength { force, torque, ..self.strength.unwrap_or_default() };
        Self { strength: Some(strength), ..self }
    }

    /// Breaks under more than this impulse in a step [N s].
    #[must_use]
    pub fn with_impulse_limit(self, impulse: f32) -> Self {
        let strength = JointStrength { impulse, ..self.strength.unwrap_or_default() };
        Self { strength: Some(strength), ..self }
    }

    /// Wears out under loads below its limits.
    #[must_use]
    pub fn with_fatigue(self, fatigue: Fatigue) -> Self {
        let fatigue = Some(fatigue);
        let strength = JointStrength { fatigue, ..self.strength.unwrap_or_default() };
        Self { strength: Some(strength), ..self }
    }

    /// Checks every field; whether the bodies exist is checked by the world.
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
