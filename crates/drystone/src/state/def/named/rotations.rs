//! Joints with rotation: balls, cones, hinges, universal joints.

use crate::state::def::JointKind;
use crate::state::def::six_dof::{JointAxis, JointCone, JointSpring, SixDof};

/// Free rotation of two bodies about a point: a ball in its socket.
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
    /// Maximum torque of dry friction about each axis [N m]; at least 0.
    pub friction: f32,
}

impl Ball {
    /// A ball joint without friction.
    #[must_use]
    pub const fn new() -> Self {
        Self { friction: 0.0 }
    }

    /// With dry friction of at most this torque about each axis [N m].
    #[must_use]
    pub const fn with_friction(self, friction: f32) -> Self {
        Self { friction }
    }

    /// Limits the swing from its x axis to this angle [rad]: a [`ConeTwist`].
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

/// A ball in a socket. The second body's x axis may swing within a cone about the first body's x
/// axis, and twist about it.
///
/// The limit of both swings is an ellipse. Twist is the rotation about x. The swing is the shortest
/// rotation from one x axis to the other. See [`Ball`] for an example.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeTwist {
    /// The rotation about x.
    pub twist: JointAxis,
    /// Maximum swing about y and about z [rad]; above 0.
    pub cone: JointCone,
    /// Maximum torque of dry friction against swings [N m]; at least 0.
    pub swing_friction: f32,
}

impl ConeTwist {
    /// A joint with these maximum swings about y and about z [rad], and free twist.
    #[must_use]
    pub const fn new(about_y: f32, about_z: f32) -> Self {
        Self::of(JointAxis::FREE, about_y, about_z)
    }

    /// A joint with this twist axis, and these maximum swings about y and about z [rad].
    #[must_use]
    pub const fn of(twist: JointAxis, about_y: f32, about_z: f32) -> Self {
        let cone = JointCone { swing: [about_y, about_z], spring: None };
        Self { twist, cone, swing_friction: 0.0 }
    }

    /// With a twist between these angles [rad].
    #[must_use]
    pub const fn with_twist(self, min: f32, max: f32) -> Self {
        Self { twist: self.twist.with_limits(min, max), ..self }
    }

    /// With this spring that pushes back beyond the cone.
    #[must_use]
    pub const fn with_soft_cone(self, spring: JointSpring) -> Self {
        Self { cone: JointCone { spring: Some(spring), ..self.cone }, ..self }
    }

    /// With dry friction of at most this torque against twist and swing [N m].
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

/// Rotation about the x axis alone: a door, a wheel on an axle, an elbow.
///
/// Its angle is that of the second body relative to the first by the right-hand rule, 0 when they
/// were joined.
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
    /// Its axis: limits [rad], drive and friction [N m].
    pub axis: JointAxis,
}

impl Hinge {
    /// A free hinge.
    #[must_use]
    pub const fn new() -> Self {
        Self::of(JointAxis::FREE)
    }

    /// A hinge with this axis.
    #[must_use]
    pub const fn of(axis: JointAxis) -> Self {
        Self { axis }
    }

    /// With two hard stops [rad].
    #[must_use]
    pub const fn with_limits(self, min: f32, max: f32) -> Self {
        Self::of(self.axis.with_limits(min, max))
    }

    /// With limits [rad] beyond which this spring pushes back.
    #[must_use]
    pub const fn with_soft_limits(self, min: f32, max: f32, spring: JointSpring) -> Self {
        Self::of(self.axis.with_soft_limits(min, max, spring))
    }

    /// With a motor at this speed [rad/s] with at most this torque [N m]. Speed 0 makes it a brake.
    #[must_use]
    pub const fn with_motor(self, speed: f32, max_torque: f32) -> Self {
        Self::of(self.axis.with_motor(speed, max_torque))
    }

    /// With a servo to this angle [rad] with at most this torque [N m].
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

/// Rotation about the x axis of the first body and the y axis of the second, which stay at right
/// angles: the cross of a driveshaft, a gimbal.
///
/// ```
/// use drystone::joint::{JointAxis, Universal};
///
/// let stick = Universal::of(JointAxis::limited(-0.4, 0.4), JointAxis::limited(-0.4, 0.4));
/// # let _ = stick;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Universal {
    /// The rotation about x, which is fixed to the first body.
    pub x: JointAxis,
    /// The rotation about y, which is fixed to the second body.
    pub y: JointAxis,
}

impl Universal {
    /// A universal joint that is free about both axes.
    #[must_use]
    pub const fn new() -> Self {
        Self::of(JointAxis::FREE, JointAxis::FREE)
    }

    /// A universal joint with these axes.
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
