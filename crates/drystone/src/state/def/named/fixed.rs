//! Joints that hold or pull a body to a pose, and wheels.

use crate::state::def::JointKind;
use crate::state::def::six_dof::{JointAxis, JointSpring, SixDof};

/// Holds the second body in its pose relative to the first: glue, a weld, an elastic bracket.
/// Placed by [`crate::JointDef::at`] at any point, it keeps the current poses.
///
/// ```
/// use drystone::joint::{Fixed, JointSpring};
///
/// let weld = Fixed::new();
/// // Both count per mass, so one law does for motions and turns.
/// let rubber = Fixed::soft(JointSpring::hertz(10.0, 0.3));
/// # let _ = (weld, rubber);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fixed {
    /// The spring that holds translations; `None` (the default): rigid.
    pub linear: Option<JointSpring>,
    /// The spring that holds rotations; `None` (the default): rigid.
    pub angular: Option<JointSpring>,
}

impl Fixed {
    /// A rigid joint.
    #[must_use]
    pub const fn new() -> Self {
        Self { linear: None, angular: None }
    }

    /// A joint with this spring along and about all axes.
    #[must_use]
    pub const fn soft(spring: JointSpring) -> Self {
        Self { linear: Some(spring), angular: Some(spring) }
    }

    /// Its six axes.
    #[must_use]
    pub const fn six_dof(self) -> SixDof {
        let linear = sprung(self.linear);
        let angular = sprung(self.angular);
        SixDof { linear: [linear; 3], angular: [angular; 3], ..SixDof::FIXED }
    }
}

const fn sprung(spring: Option<JointSpring>) -> JointAxis {
    match spring {
        Some(spring) => JointAxis::FREE.with_servo(0.0, spring, f32::INFINITY),
        None => JointAxis::LOCKED,
    }
}

impl From<Fixed> for SixDof {
    fn from(joint: Fixed) -> Self {
        joint.six_dof()
    }
}

impl From<Fixed> for JointKind {
    fn from(joint: Fixed) -> Self {
        Self::SixDof(joint.six_dof())
    }
}

/// Pulls the second body to a pose on the first with limited force and torque: a hand, a magnet, a
/// muscle.
///
/// The target is the pose in which both frames coincide: [`crate::JointMut::set_anchors`] and
/// [`crate::JointMut::set_frames`] move it. Pulled bodies still collide with other bodies.
///
/// ```
/// use drystone::joint::{JointSpring, Servo};
/// use drystone::{BodyId, JointDef};
///
/// /// The mouse is a kinematic body that follows the pointer.
/// fn drag(mouse: BodyId, crate_: BodyId, point: [f32; 3]) -> JointDef {
///     JointDef::new(mouse, crate_, Servo::grab(JointSpring::hertz(5.0, 1.0), 2000.0)).at(point)
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    /// Stiffness and damping of the force.
    pub linear: JointSpring,
    /// Stiffness and damping of the torque; `None`: rotation is free.
    pub angular: Option<JointSpring>,
    /// Maximum force along each axis [N]; may be ∞.
    pub max_force: f32,
    /// Maximum torque about each axis [N m]; may be ∞.
    pub max_torque: f32,
}

impl Servo {
    /// Pulls position and rotation, with at most this force [N] and torque [N m].
    #[must_use]
    pub const fn new(spring: JointSpring, max_force: f32, max_torque: f32) -> Self {
        Self { linear: spring, angular: Some(spring), max_force, max_torque }
    }

    /// Pulls the anchors together like a hand, with at most this force [N]. Rotation is free.
    #[must_use]
    pub const fn grab(spring: JointSpring, max_force: f32) -> Self {
        Self { linear: spring, angular: None, max_force, max_torque: 0.0 }
    }

    /// Its six axes.
    #[must_use]
    pub const fn six_dof(self) -> SixDof {
        let linear = JointAxis::FREE.with_servo(0.0, self.linear, self.max_force);
        let angular = match self.angular {
            Some(spring) => JointAxis::FREE.with_servo(0.0, spring, self.max_torque),
            None => JointAxis::FREE,
        };
        SixDof { linear: [linear; 3], angular: [angular; 3], ..SixDof::FIXED }
    }
}

impl From<Servo> for SixDof {
    fn from(joint: Servo) -> Self {
        joint.six_dof()
    }
}

impl From<Servo> for JointKind {
    fn from(joint: Servo) -> Self {
        Self::SixDof(joint.six_dof())
    }
}

/// A wheel, the second body, on a chassis. It has a spring along the x axis, spins about the y
/// axis, and can be steered about the x axis. Point x up and y along the axle
/// ([`crate::JointDef::with_axes`]).
///
/// A positive spin rolls it toward axle × up: forward, if the axle points to the left.
///
/// ```
/// use drystone::joint::{JointSpring, Wheel};
/// use drystone::{BodyId, JointDef};
///
/// /// One of four under 1200 kg; up is y, the car faces x, so that its left is -z.
/// fn front(chassis: BodyId, wheel: BodyId, hub: [f32; 3]) -> JointDef {
///     let spring = JointSpring::for_load(1.5, 0.4, 300.0);
///     let steering = JointSpring::hertz(8.0, 1.0);
///     let joint = Wheel::new(spring).with_travel(-0.15, 0.15).with_motor(20.0, 300.0);
///     let joint = joint.with_steering(0.0, steering, 1000.0);
///     JointDef::new(chassis, wheel, joint).at(hub).with_axes([0.0, 1.0, 0.0], [0.0, 0.0, -1.0])
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheel {
    /// The suspension along x [m; N]; positions above 0 are those of a wheel that the ground pushes
    /// in.
    pub suspension: JointAxis,
    /// The rotation about y [rad; N m].
    pub spin: JointAxis,
    /// The rotation about x [rad; N m]; locked by default.
    pub steering: JointAxis,
}

impl Wheel {
    /// A wheel with this suspension, free spin and no steering. Its rest position is the one where
    /// it was joined.
    #[must_use]
    pub const fn new(suspension: JointSpring) -> Self {
        let suspension = JointAxis::FREE.with_servo(0.0, suspension, f32::INFINITY);
        Self { suspension, spin: JointAxis::FREE, steering: JointAxis::LOCKED }
    }

    /// A wheel on an axle without suspension.
    #[must_use]
    pub const fn rigid() -> Self {
        Self { suspension: JointAxis::LOCKED, spin: JointAxis::FREE, steering: JointAxis::LOCKED }
    }

    /// With two hard stops of its suspension [m]: below 0 it hangs out, above 0 it is pushed in.
    #[must_use]
    pub const fn with_travel(self, min: f32, max: f32) -> Self {
        Self { suspension: self.suspension.with_limits(min, max), ..self }
    }

    /// With a motor at this speed [rad/s] with at most this torque [N m]. Speed 0 makes it a brake.
    #[must_use]
    pub const fn with_motor(self, speed: f32, max_torque: f32) -> Self {
        Self { spin: self.spin.with_motor(speed, max_torque), ..self }
    }

    /// With steering to this angle about x [rad] with at most this torque [N m].
    #[must_use]
    pub const fn with_steering(self, angle: f32, spring: JointSpring, max_torque: f32) -> Self {
        Self { steering: JointAxis::FREE.with_servo(angle, spring, max_torque), ..self }
    }

    /// Its six axes.
    #[must_use]
    pub const fn six_dof(self) -> SixDof {
        SixDof {
            linear: [self.suspension, JointAxis::LOCKED, JointAxis::LOCKED],
            angular: [self.steering, self.spin, JointAxis::LOCKED],
            ..SixDof::FIXED
        }
    }
}

impl From<Wheel> for SixDof {
    fn from(joint: Wheel) -> Self {
        joint.six_dof()
    }
}

impl From<Wheel> for JointKind {
    fn from(joint: Wheel) -> Self {
        Self::SixDof(joint.six_dof())
    }
}
