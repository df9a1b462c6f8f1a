//! Definitions of joints of six axes: the motion, drive and friction of each axis of the joint's
//! frame.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::DefError;
use super::axis::Axis;
use super::check::{above_zero, at_least_zero, unit, within};
use crate::base::limits;
use crate::base::math::{Vec3, vec3};
use crate::base::quat::Quat;

/// A damped spring along or about an axis. The default methods clamp it to the stiffness of a
/// locked axis: its `c h + k h²` over the effective mass is at most that of
/// [`crate::config::JointConfig`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct JointSpring {
    /// Force per displacement [N/m; N m/rad; 1/s² if `per_mass`]; at least 0.
    pub stiffness: f32,
    /// Force per speed [N s/m; N m s/rad; 1/s if `per_mass`]; at least 0. Infinite for a drive that
    /// holds its speed as far as its maximum force allows.
    pub damping: f32,
    /// Whether both are per effective mass of the two bodies along the axis, so that they give an
    /// acceleration.
    pub per_mass: bool,
}

impl JointSpring {
    /// A spring with this stiffness [N/m or N m/rad] and damping [N s/m or N m s/rad].
    #[must_use]
    pub const fn new(stiffness: f32, damping: f32) -> Self {
        Self { stiffness, damping, per_mass: false }
    }

    /// A spring with this undamped frequency of the two bodies on it [Hz] and damping ratio (1:
    /// critical).
    ///
    /// The mass is the effective mass of the *two bodies of the joint*, 1/(1/a + 1/b) along an axis
    /// through both centers. Between a heavy chassis and a light wheel it is about the wheel's
    /// mass. Use [`Self::for_load`] for a spring that carries the chassis.
    #[must_use]
    pub fn hertz(hertz: f32, damping_ratio: f32) -> Self {
        let omega = 2.0 * core::f32::consts::PI * hertz;
        Self { stiffness: omega * omega, damping: 2.0 * damping_ratio * omega, per_mass: true }
    }

    /// A spring on which this load alone would oscillate at this undamped frequency [Hz], with this
    /// damping ratio (1: critical): `k = load (2πf)²`, `c = 2 ratio load 2πf`. The load is a mass
    /// [kg] along an axis, or a moment of inertia [kg m²] about one.
    ///
    /// A mass at rest on it sinks by `g/(2πf)²`, whatever its mass: 248 mm at 1 Hz, 62 mm at 2 Hz.
    ///
    /// ```
    /// use drystone::joint::JointSpring;
    ///
    /// // One of four wheels under a car of 1200 kg.
    /// let spring = JointSpring::for_load(1.5, 0.4, 1200.0 / 4.0);
    /// assert!((spring.stiffness - 26_648.0).abs() < 1.0 && !spring.per_mass);
    /// ```
    #[must_use]
    pub fn for_load(hertz: f32, damping_ratio: f32, load: f32) -> Self {
        let law = Self::hertz(hertz, damping_ratio);
        Self::new(law.stiffness * load, law.damping * load)
    }

    fn validate(&self) -> Result<(), DefError> {
        at_least_zero("stiffness", self.stiffness)?;
        if self.damping == f32::INFINITY {
            return Ok(());
        }
        at_least_zero("damping", self.damping)
    }
}

/// The motion of the second body relative to the first that an axis allows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum JointMotion {
    /// Any motion.
    #[default]
    Free,
    /// No motion.
    Locked,
    /// Motion between two limits [m; rad].
    Limited {
        /// Minimum coordinate; may be -∞.
        min: f32,
        /// Maximum coordinate; at least `min`; may be ∞.
        max: f32,
        /// Spring that pushes back beyond the limits; without one they are as stiff as the world's
        /// joints.
        spring: Option<JointSpring>,
    },
}

/// A drive: a spring toward a moving target, or a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct JointDrive {
    /// Target coordinate [m; rad].
    pub position: f32,
    /// Target speed [m/s; rad/s].
    pub velocity: f32,
    /// Stiffness and damping toward the targets.
    pub spring: JointSpring,
    /// Maximum force [N; N m]; at least 0; may be ∞. Against a hard limit of its own axis a drive
    /// presses with an impulse of at most 12,000 m/s (37,000 rad/s) times the effective mass in a
    /// substep; the stop bears that for any force.
    pub max_force: f32,
}

impl JointDrive {
    /// A motor that holds this speed [m/s; rad/s] with at most this force [N; N m]. Speed 0 makes
    /// it a brake.
    #[must_use]
    pub const fn motor(velocity: f32, max_force: f32) -> Self {
        let spring = JointSpring::new(0.0, f32::INFINITY);
        Self { position: 0.0, velocity, spring, max_force }
    }

    /// A spring toward this coordinate [m; rad] with at most this force [N; N m].
    #[must_use]
    pub const fn servo(position: f32, spring: JointSpring, max_force: f32) -> Self {
        Self { position, velocity: 0.0, spring, max_force }
    }

    pub(crate) fn validate(&self) -> Result<(), DefError> {
        within("position", self.position, &limits::TARGET)?;
        within("velocity", self.velocity, &limits::TARGET)?;
        self.spring.validate()?;
        if self.max_force == f32::INFINITY {
            return Ok(());
        }
        at_least_zero("max_force", self.max_force)
    }
}

/// One axis of a joint: motion, drive and friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct JointAxis {
    /// The motion that it allows.
    pub motion: JointMotion,
    /// The drive; ignored on a locked axis.
    pub drive: Option<JointDrive>,
    /// Maximum force of dry friction against any motion, in addition to the drive [N; N m]; at
    /// least 0; may be ∞. Ignored on a locked axis.
    pub friction: f32,
}

impl JointAxis {
    /// A free axis without drive and friction.
    pub const FREE: Self = Self { motion: JointMotion::Free, drive: None, friction: 0.0 };
    /// A locked axis.
    pub const LOCKED: Self = Self { motion: JointMotion::Locked, ..Self::FREE };

    /// An axis with two hard stops [m; rad].
    #[must_use]
    pub const fn limited(min: f32, max: f32) -> Self {
        Self { motion: JointMotion::Limited { min, max, spring: None }, ..Self::FREE }
    }

    /// A free axis with this drive.
    #[must_use]
    pub const fn driven(drive: JointDrive) -> Self {
        Self { drive: Some(drive), ..Self::FREE }
    }

    /// With this drive.
    #[must_use]
    pub const fn with_drive(self, drive: JointDrive) -> Self {
        Self { drive: Some(drive), ..self }
    }

    /// With dry friction of at most this force [N; N m].
    #[must_use]
    pub const fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    /// With two hard stops [m; rad].
    #[must_use]
    pub const fn with_limits(self, min: f32, max: f32) -> Self {
        Self { motion: JointMotion::Limited { min, max, spring: None }, ..self }
    }

    /// With limits [m; rad] beyond which this spring pushes back.
    #[must_use]
    pub const fn with_soft_limits(self, min: f32, max: f32, spring: JointSpring) -> Self {
        Self { motion: JointMotion::Limited { min, max, spring: Some(spring) }, ..self }
    }

    /// With a motor at this speed [m/s; rad/s] with at most this force [N; N m]:
    /// [`JointDrive::motor`].
    #[must_use]
    pub const fn with_motor(self, speed: f32, max_force: f32) -> Self {
        self.with_drive(JointDrive::motor(speed, max_force))
    }

    /// With a servo to this coordinate [m; rad] with at most this force [N; N m]:
    /// [`JointDrive::servo`].
    #[must_use]
    pub const fn with_servo(self, position: f32, spring: JointSpring, max_force: f32) -> Self {
        self.with_drive(JointDrive::servo(position, spring, max_force))
    }

    /// Its minimum and maximum coordinate [m; rad]; `None` where it is free. Both are 0 where it is
    /// locked.
    #[must_use]
    pub const fn limits(&self) -> Option<(f32, f32)> {
        match self.motion {
            JointMotion::Free => None,
            JointMotion::Locked => Some((0.0, 0.0)),
            JointMotion::Limited { min, max, .. } => Some((min, max)),
        }
    }

    /// The coordinate at which the axis is locked, if it is [m; rad].
    pub(crate) fn locked_at(&self) -> Option<f32> {
        match self.motion {
            JointMotion::Locked => Some(0.0),
            JointMotion::Limited { min, max, spring: None } if min >= max => Some(min),
            _ => None,
        }
    }

    /// True if a limit, a drive or friction acts on it.
    pub(crate) fn is_scalar(&self) -> bool {
        let acts = self.motion != JointMotion::Free || self.drive.is_some() || self.friction > 0.0;
        self.locked_at().is_none() && acts
    }

    /// Excess of a coordinate beyond the hard limits of the axis [m; rad]. Sprung limits have none.
    pub(crate) fn excess(&self, x: f32) -> f32 {
        match self.motion {
            JointMotion::Free | JointMotion::Limited { spring: Some(_), .. } => 0.0,
            JointMotion::Locked => x,
            JointMotion::Limited { min, max, .. } => (min - x).max(x - max).max(0.0),
        }
    }

    fn validate(&self) -> Result<(), DefError> {
        if let JointMotion::Limited { min, max, spring } = self.motion {
            if min.is_nan() || min == f32::INFINITY {
                return Err(DefError::new("min", min, "a number or -inf"));
            }
            if !(max >= min) || max == f32::NEG_INFINITY {
                return Err(DefError::new("max", max, "at least `min`"));
            }
            if let Some(spring) = spring {
                spring.validate().map_err(|e| e.within("spring"))?;
            }
        }
        if self.friction != f32::INFINITY {
            at_least_zero("friction", self.friction)?;
        }
        self.drive.map_or(Ok(()), |drive| drive.validate().map_err(|e| e.within("drive")))
    }
}

/// The maximum swing of the x axis of the second frame from that of the first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct JointCone {
    /// Maximum swing about y, and about z [rad]; above 0. Between them the limit is an ellipse.
    pub swing: [f32; 2],
    /// Spring that pushes back beyond the cone; without one it is as stiff as the world's joints.
    pub spring: Option<JointSpring>,
}

impl JointCone {
    /// The axes along and across a swing with this direction.
    pub(crate) fn axes(&self, y: JointAxis, z: JointAxis, [c, s]: [f32; 2]) -> [JointAxis; 2] {
        let [wide, high] = self.swing;
        let (p, q) = (c / wide, s / high);
        let max = 1.0 / (p * p + q * q).sqrt();
        let at = |along: f32, across: f32| {
            let (dy, dz) = (y.drive?, z.drive?);
            Some(JointDrive {
                position: along * dy.position + across * dz.position,
                velocity: along * dy.velocity + across * dz.velocity,
                ..dy
            })
        };
        let motion = JointMotion::Limited { min: f32::NEG_INFINITY, max, spring: self.spring };
        let friction = y.friction;
        [
            JointAxis { motion, drive: at(c, s), friction },
            JointAxis { motion: JointMotion::Free, drive: at(-s, c), friction },
        ]
    }
}

/// A joint of six axes: three translations and three rotations in the joint's frame on the first
/// body. Coordinates are those of the second body's frame in the first body's frame.
///
/// The meaning of the angles depends on the number of rotation axes that are not locked:
///
/// * One: the angle is the rotation about that axis, with full turns counted.
/// * Two: the first axis is fixed to body A, the second to body B, and they are always at right
///   angles (a universal joint).
/// * Three, or with a cone: x is the twist, y and z are the swing.
///
/// [`crate::joint`] has the usual joints by name; `six_dof()` converts each into this type.
///
/// ```
/// use drystone::joint::{JointAxis, SixDof, Slider};
/// use drystone::Axis;
///
/// // A slider that may turn about y as well.
/// let axes = Slider::new().six_dof().with_axis(Axis::TurnY, JointAxis::limited(-0.5, 0.5));
/// assert_eq!(axes.axis(Axis::TurnX), SixDof::FIXED.axis(Axis::TurnX));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct SixDof {
    /// The joint's axes [frame of the first body]; unit.
    pub frame_a: Quat,
    /// The joint's axes [frame of the second body]; unit.
    pub frame_b: Quat,
    /// Translations along x, y, z.
    pub linear: [JointAxis; 3],
    /// Rotations about x, y, z.
    pub angular: [JointAxis; 3],
    /// A common limit of both swings. The swings themselves must then be free and have the same
    /// friction. If they are driven, their drives must have the same law; the two targets may
    /// differ.
    pub cone: Option<JointCone>,
}

impl SixDof {
    /// All axes locked: the base for other joints of six axes.
    pub const FIXED: Self = Self {
        frame_a: Quat::IDENTITY,
        frame_b: Quat::IDENTITY,
        linear: [JointAxis::LOCKED; 3],
        angular: [JointAxis::LOCKED; 3],
        cone: None,
    };

    /// One of its axes.
    #[must_use]
    pub const fn axis(&self, axis: Axis) -> &JointAxis {
        match axis {
            Axis::X => &self.linear[0],
            Axis::Y => &self.linear[1],
            Axis::Z => &self.linear[2],
            Axis::TurnX => &self.angular[0],
            Axis::TurnY => &self.angular[1],
            Axis::TurnZ => &self.angular[2],
        }
    }

    /// The same joint with another axis.
    #[must_use]
    pub const fn with_axis(mut self, axis: Axis, def: JointAxis) -> Self {
        match axis {
            Axis::X => self.linear[0] = def,
            Axis::Y => self.linear[1] = def,
            Axis::Z => self.linear[2] = def,
            Axis::TurnX => self.angular[0] = def,
            Axis::TurnY => self.angular[1] = def,
            Axis::TurnZ => self.angular[2] = def,
        }
        self
    }

    /// Excess of this gap, from the first anchor to the second, beyond the limits of the
    /// translations [m, frame of the joint on the first body].
    #[must_use]
    pub fn linear_excess(&self, gap: impl Into<Vec3>) -> f32 {
        let gap = gap.into();
        let [x, y, z] = &self.linear;
        vec3(x.excess(gap.x), y.excess(gap.y), z.excess(gap.z)).length()
    }

    /// The axes: translations, then rotations.
    pub(crate) const fn axes(&self) -> [JointAxis; 6] {
        let ([x, y, z], [a, b, c]) = (self.linear, self.angular);
        [x, y, z, a, b, c]
    }

    /// Like [`Self::axes`]; with a cone, the swings are those along and across their direction.
    pub(crate) fn acting(&self, swing: [f32; 2]) -> [JointAxis; 6] {
        let mut axes = self.axes();
        if let Some(cone) = &self.cone {
            [axes[4], axes[5]] = cone.axes(axes[4], axes[5], swing);
        }
        axes
    }

    /// The parts that the solver has to solve.
    pub(crate) fn parts(&self) -> SixDofParts {
        SixDofParts {
            acts: self.scalars(),
            locks: self.locks(),
            locks_all_motions: self.linear.iter().all(|axis| axis.locked_at().is_some()),
        }
    }

    /// Whether a translation is locked, and whether a rotation is.
    pub(crate) fn locks(&self) -> [bool; 2] {
        let any = |axes: &[JointAxis]| axes.iter().any(|axis| axis.locked_at().is_some());
        [any(&self.linear), any(&self.angular)]
    }

    /// True if some axis is locked.
    pub(crate) fn holds_any(&self) -> bool {
        self.locks() != [false; 2]
    }

    /// Number of axes that are not locked: of the translations if something acts on one of them,
    /// plus likewise of the rotations.
    pub(crate) fn scalar_count(&self) -> usize {
        let free =
            |axes: &[JointAxis]| axes.iter().filter(|axis| axis.locked_at().is_none()).count();
        let [moves, turns] = self.scalars();
        let count = |acts: bool, axes: &[JointAxis]| if acts { free(axes) } else { 0 };
        count(moves, &self.linear) + count(turns, &self.angular)
    }

    /// Whether a drive, a limit or friction acts on a translation, and whether on a rotation.
    pub(crate) fn scalars(&self) -> [bool; 2] {
        let any = |axes: &[JointAxis]| axes.iter().any(JointAxis::is_scalar);
        [any(&self.linear), any(&self.angular) || self.cone.is_some()]
    }

    pub(crate) fn validate(&self) -> Result<(), DefError> {
        unit("frame_a", self.frame_a)?;
        unit("frame_b", self.frame_b)?;
        for (name, axes) in [("linear", &self.linear), ("angular", &self.angular)] {
            for (i, axis) in axes.iter().enumerate() {
                axis.validate().map_err(|e| e.within(&format!("{name}[{i}]")))?;
            }
        }
        self.cone.map_or(Ok(()), |cone| self.validate_cone(&cone))
    }

    fn validate_cone(&self, cone: &JointCone) -> Result<(), DefError> {
        for (i, swing) in cone.swing.into_iter().enumerate() {
            above_zero("swing", swing).map_err(|e| e.within(&format!("cone[{i}]")))?;
        }
        if let Some(spring) = cone.spring {
            spring.validate().map_err(|e| e.within("cone.spring"))?;
        }
        let [_, y, z] = &self.angular;
        for (i, axis) in [y, z].into_iter().enumerate() {
            if axis.motion != JointMotion::Free {
                let motion = format!("{:?}", axis.motion);
                return Err(DefError::unsuitable(
                    &format!("angular[{}].motion", i + 1),
                    motion,
                    FREE,
                ));
            }
        }
        let law = |axis: &JointAxis| axis.drive.map(|d| (d.spring, d.max_force));
        if law(y) != law(z) {
            return Err(DefError::unsuitable("angular[2].drive", "a different law", SAME));
        }
        if y.friction.to_bits() != z.friction.to_bits() {
            let same = "that of angular[1], as there is a cone";
            return Err(DefError::unsuitable("angular[2].friction", z.friction, same));
        }
        Ok(())
    }
}

/// The parts of a joint of six axes that the solver has to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SixDofParts {
    /// Whether a drive, friction or limit acts on a translation, and on a rotation.
    pub(crate) acts: [bool; 2],
    /// Whether a translation is locked, and a rotation.
    pub(crate) locks: [bool; 2],
    /// Whether all translations are locked.
    pub(crate) locks_all_motions: bool,
}

const FREE: &str = "free, because there is a cone";
const SAME: &str = "the same law as that of angular[1], because there is a cone";
