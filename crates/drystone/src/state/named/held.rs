//! Joints that hold or pull to a pose, and wheels.

use crate::state::def::JointKind;
use crate::state::sixdof::{JointAxis, JointSpring, SixDof};

/// Holds the second body as it was joined to the first: glue, a weld, a bracket that gives. Placed by
/// [`crate::JointDef::at`] at any point, it holds the bodies as they lie.
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
    /// The spring that holds motions; `None`, the default: rigid.
    pub linear: Option<JointSpring>,
    /// The spring that holds turns; `None`, the default: rigid.
    pub angular: Option<JointSpring>,
}

impl Fixed {
    /// Rigid.
    #[must_use]
    pub const fn new() -> Self {
        Self { linear: None, angular: None }
    }

    /// Held by this spring along and about all axes.
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

/// Pulls the second body to a pose on the first, with no more than a given force and torque: a hand, a magnet, a muscle.
///
/// The pose is that where both frames meet: [`crate::JointMut::set_anchors`] and [`crate::JointMut::set_frames`] move it.
/// Bodies that are to feel the world collide with it while they are pulled.
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
    /// The law of the force.
    pub linear: JointSpring,
    /// The law of the torque; `None`: any turn is free.
    pub angular: Option<JointSpring>,
    /// Greatest force along each axis [N]; may be ∞.
    pub max_force: f32,
    /// Greatest torque about each axis [N m]; may be ∞.
    pub max_torque: f32,
}

impl Servo {
    /// Pulls place and rotation, with at most this force [N] and torque [N m].
    #[must_use]
    pub const fn new(spring: JointSpring, max_force: f32, max_torque: f32) -> Self {
        Self { linear: spring, angular: Some(spring), max_force, max_torque }
    }

    /// Pulls the anchors together as a hand does, with at most this force [N]: any turn is free.
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

/// A wheel, the second body, on a chassis: sprung along the x axis, spinning about the y axis, and steered about the x axis if
/// asked for. Point x up and y along the axle ([`crate::JointDef::with_axes`]).
///
/// A positive spin rolls it toward axle × up: with the axle to the left that is forward.
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
    /// The spring along x; positions above 0 are those of a wheel that the ground pushes in [m; N].
    pub suspension: JointAxis,
    /// The turn about y [rad; N m].
    pub spin: JointAxis,
    /// The turn about x [rad; N m]; locked by default.
    pub steering: JointAxis,
}

impl Wheel {
    /// Sprung so, spins freely, and is not steered. Without load it is where it was joined.
    #[must_use]
    pub const fn new(suspension: JointSpring) -> Self {
        let suspension = JointAxis::FREE.with_servo(0.0, suspension, f32::INFINITY);
        Self { suspension, spin: JointAxis::FREE, steering: JointAxis::LOCKED }
    }

    /// On an axle without a spring.
    #[must_use]
    pub const fn rigid() -> Self {
        Self { suspension: JointAxis::LOCKED, spin: JointAxis::FREE, steering: JointAxis::LOCKED }
    }

    /// Moves between two hard stops of its spring [m]: below 0 it hangs out, above 0 it is pushed in.
    #[must_use]
    pub const fn with_travel(self, min: f32, max: f32) -> Self {
        Self { suspension: self.suspension.with_limits(min, max), ..self }
    }

    /// Driven at this speed [rad/s] with at most this torque [N m]. With speed 0 it is a brake.
    #[must_use]
    pub const fn with_motor(self, speed: f32, max_torque: f32) -> Self {
        Self { spin: self.spin.with_motor(speed, max_torque), ..self }
    }

    /// Steered to this angle about x [rad] with at most this torque [N m].
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
