//! Joints that turn: balls, cones, hinges, universal joints.

use crate::state::def::JointKind;
use crate::state::sixdof::{JointAxis, JointCone, JointSpring, SixDof};

/// Two bodies turn freely about a point: a ball in its socket.
///
/// ```
/// use drystone::joint::Ball;
/// use drystone::{BodyId, JointDef};
///
/// fn shoulder(torso: BodyId, arm: BodyId) -> JointDef {
///     // The arm points along x and may swing by 60° from there, and turn about itself by 45° either way.
///     let socket = Ball::new().with_cone(1.05).with_twist(-0.79, 0.79);
///     JointDef::new(torso, arm, socket).at([0.2, 1.4, 0.0]).with_axis([1.0, 0.0, 0.0])
/// }
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ball {
    /// Greatest torque of dry friction about each axis [N m]; at least 0.
    pub friction: f32,
}

impl Ball {
    /// Turns without friction.
    #[must_use]
    pub const fn new() -> Self {
        Self { friction: 0.0 }
    }

    /// With dry friction of at most this torque about each axis [N m].
    #[must_use]
    pub const fn with_friction(self, friction: f32) -> Self {
        Self { friction }
    }

    /// Swings no farther than this from its x axis [rad], as a [`ConeTwist`].
    #[must_use]
    pub const fn with_cone(self, swing: f32) -> ConeTwist {
        ConeTwist::new(swing, swing).with_friction(self.friction)
    }
}

impl From<Ball> for JointKind {
    fn from(ball: Ball) -> Self {
        if ball.friction == 0.0 {
            return Self::Ball;
        }
        let axis = JointAxis::FREE.with_friction(ball.friction);
        Self::SixDof(SixDof { angular: [axis; 3], ..SixDof::FIXED })
    }
}

/// A ball in a socket that lets the second body's x axis swing within a cone about the first one's, and twist about it.
///
/// The limit of both swings is an ellipse. Twist is the turn about x; the swing is the shortest turn that takes one x axis
/// to the other. See [`Ball`] for an example.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeTwist {
    /// The turn about x.
    pub twist: JointAxis,
    /// Greatest swing about y and about z [rad]; above 0.
    pub cone: JointCone,
    /// Greatest torque of dry friction against swings [N m]; at least 0.
    pub swing_friction: f32,
}

impl ConeTwist {
    /// Swings this far about y and about z [rad], and twists freely.
    #[must_use]
    pub const fn new(about_y: f32, about_z: f32) -> Self {
        Self::of(JointAxis::FREE, about_y, about_z)
    }

    /// Twists as this axis says, and swings this far about y and about z [rad].
    #[must_use]
    pub const fn of(twist: JointAxis, about_y: f32, about_z: f32) -> Self {
        let cone = JointCone { swing: [about_y, about_z], spring: None };
        Self { twist, cone, swing_friction: 0.0 }
    }

    /// Twists between these angles [rad].
    #[must_use]
    pub const fn with_twist(self, min: f32, max: f32) -> Self {
        Self { twist: self.twist.with_limits(min, max), ..self }
    }

    /// Pushed back by this spring beyond the cone.
    #[must_use]
    pub const fn with_soft_cone(self, spring: JointSpring) -> Self {
        Self { cone: JointCone { spring: Some(spring), ..self.cone }, ..self }
    }

    /// With dry friction of at most this torque, against twist and swing [N m].
    #[must_use]
    pub const fn with_friction(self, friction: f32) -> Self {
        Self { twist: self.twist.with_friction(friction), swing_friction: friction, ..self }
    }

    /// Its six axes.
    #[must_use]
    pub const fn six_dof(self) -> SixDof {
        let swing = JointAxis::FREE.with_friction(self.swing_friction);
        SixDof { angular: [self.twist, swing, swing], cone: Some(self.cone), ..SixDof::FIXED }
    }
}

impl From<ConeTwist> for SixDof {
    fn from(joint: ConeTwist) -> Self {
        joint.six_dof()
    }
}

impl From<ConeTwist> for JointKind {
    fn from(joint: ConeTwist) -> Self {
        Self::SixDof(joint.six_dof())
    }
}

/// Turns about the x axis alone: a door, a wheel on an axle, an elbow.
///
/// Its angle is that of the second body against the first by the right hand, 0 as they were joined.
///
/// ```
/// use drystone::joint::{Hinge, JointSpring};
///
/// let door = Hinge::new().with_limits(0.0, 1.9).with_friction(0.5);
/// let fan = Hinge::new().with_motor(20.0, 4.0);
/// let elbow = Hinge::new().with_servo(0.7, JointSpring::hertz(4.0, 1.0), 60.0);
/// # let _ = (door, fan, elbow);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hinge {
    /// Its turn: limits [rad], drive and friction [N m].
    pub axis: JointAxis,
}

impl Hinge {
    /// Turns freely.
    #[must_use]
    pub const fn new() -> Self {
        Self::of(JointAxis::FREE)
    }

    /// Turns as this axis says.
    #[must_use]
    pub const fn of(axis: JointAxis) -> Self {
        Self { axis }
    }

    /// Between two hard stops [rad].
    #[must_use]
    pub const fn with_limits(self, min: f32, max: f32) -> Self {
        Self::of(self.axis.with_limits(min, max))
    }

    /// Pushed back by this spring beyond two angles [rad].
    #[must_use]
    pub const fn with_soft_limits(self, min: f32, max: f32, spring: JointSpring) -> Self {
        Self::of(self.axis.with_soft_limits(min, max, spring))
    }

    /// Driven at this speed [rad/s] with at most this torque [N m]. With speed 0 it is a brake.
    #[must_use]
    pub const fn with_motor(self, speed: f32, max_torque: f32) -> Self {
        Self::of(self.axis.with_motor(speed, max_torque))
    }

    /// Pulled to this angle [rad] with at most this torque [N m].
    #[must_use]
    pub const fn with_servo(self, angle: f32, spring: JointSpring, max_torque: f32) -> Self {
        Self::of(self.axis.with_servo(angle, spring, max_torque))
    }

    /// With dry friction of at most this torque [N m].
    #[must_use]
    pub const fn with_friction(self, torque: f32) -> Self {
        Self::of(self.axis.with_friction(torque))
    }

    /// Its six axes.
    #[must_use]
    pub const fn six_dof(self) -> SixDof {
        let angular = [self.axis, JointAxis::LOCKED, JointAxis::LOCKED];
        SixDof { angular, ..SixDof::FIXED }
    }
}

impl From<Hinge> for SixDof {
    fn from(joint: Hinge) -> Self {
        joint.six_dof()
    }
}

impl From<Hinge> for JointKind {
    fn from(joint: Hinge) -> Self {
        Self::SixDof(joint.six_dof())
    }
}

/// Turns about the x axis of the first body and the y axis of the second, which stay at right angles: the cross of a
/// driveshaft, a gimbal.
///
/// ```
/// use drystone::joint::{JointAxis, Universal};
///
/// let stick = Universal::of(JointAxis::limited(-0.4, 0.4), JointAxis::limited(-0.4, 0.4));
/// # let _ = stick;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Universal {
    /// The turn about x, which stays with the first body.
    pub x: JointAxis,
    /// The turn about y, which stays with the second body.
    pub y: JointAxis,
}

impl Universal {
    /// Turns freely about both.
    #[must_use]
    pub const fn new() -> Self {
        Self::of(JointAxis::FREE, JointAxis::FREE)
    }

    /// Turns as these axes say.
    #[must_use]
    pub const fn of(x: JointAxis, y: JointAxis) -> Self {
        Self { x, y }
    }

    /// Its six axes.
    #[must_use]
    pub const fn six_dof(self) -> SixDof {
        SixDof { angular: [self.x, self.y, JointAxis::LOCKED], ..SixDof::FIXED }
    }
}

impl From<Universal> for SixDof {
    fn from(joint: Universal) -> Self {
        joint.six_dof()
    }
}

impl From<Universal> for JointKind {
    fn from(joint: Universal) -> Self {
        Self::SixDof(joint.six_dof())
    }
}
