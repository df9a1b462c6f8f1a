//! The kinds of joints.

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use bevy_ecs::reflect::ReflectComponent;
use bevy_math::Vec3;
use bevy_reflect::Reflect;
use drystone::JointKind;
use drystone::joint::{
    Ball, ConeTwist, Distance, Fixed, Hinge, JointAxis, JointDrive, JointSpring, Rope, Slider,
    Spring,
};

use super::place::JointEnds;
use crate::queue::{look_at_joint, mend_joint};

/// Stops of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct JointLimits {
    /// Minimum coordinate [m; rad]; may be -∞.
    pub min: f32,
    /// Maximum coordinate [m; rad]; may be ∞.
    pub max: f32,
    /// Springs in place of hard stops; default `None`.
    pub spring: Option<JointSpringiness>,
}

/// Stiffness and damping of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub enum JointSpringiness {
    /// Given as a spring.
    Spring {
        /// Stiffness [N/m; N m/rad].
        stiffness: f32,
        /// Damping [N s/m; N m s/rad].
        damping: f32,
    },
    /// Given as the frequency of the two bodies on the spring.
    Frequency {
        /// Frequency [Hz].
        hertz: f32,
        /// Damping ratio; 1 is critical.
        damping_ratio: f32,
    },
}

impl JointSpringiness {
    fn spring(self) -> JointSpring {
        match self {
            Self::Spring { stiffness, damping } => JointSpring::new(stiffness, damping),
            Self::Frequency { hertz, damping_ratio } => JointSpring::hertz(hertz, damping_ratio),
        }
    }
}

/// A motor of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub enum JointMotor {
    /// Holds a speed; speed 0 is a brake.
    Speed {
        /// Target speed [m/s; rad/s].
        target: f32,
        /// Maximum force [N; N m]; may be ∞.
        max_force: f32,
    },
    /// Pulls to a position.
    Position {
        /// Target coordinate [m; rad].
        target: f32,
        /// The spring of the pull.
        spring: JointSpringiness,
        /// Maximum force [N; N m]; may be ∞.
        max_force: f32,
    },
}

impl JointMotor {
    fn drive(self) -> JointDrive {
        match self {
            Self::Speed { target, max_force } => JointDrive::motor(target, max_force),
            Self::Position { target, spring, max_force } => {
                JointDrive::servo(target, spring.spring(), max_force)
            }
        }
    }
}

/// The axis of a joint.
fn axis(limits: Option<JointLimits>, motor: Option<JointMotor>, friction: f32) -> JointAxis {
    let free = JointAxis::FREE.with_friction(friction);
    let stopped = match limits {
        None => free,
        Some(JointLimits { min, max, spring: None }) => free.with_limits(min, max),
        Some(JointLimits { min, max, spring: Some(spring) }) => {
            free.with_soft_limits(min, max, spring.spring())
        }
    };
    motor.map_or(stopped, |motor| stopped.with_drive(motor.drive()))
}

/// Writes the calls that place a joint.
macro_rules! placed {
    ($($joint:ident),+) => { $(
        impl $joint {
            /// At a point [m, world], for the poses of the bodies when the joint is made.
            #[must_use]
            pub fn at(self, point: Vec3) -> Self {
                self.between(point, point)
            }

            /// At a point for each body [m, world], for their poses when the joint is made.
            #[must_use]
            pub fn between(mut self, point1: Vec3, point2: Vec3) -> Self {
                self.ends.between(point1, point2);
                self
            }

            /// With its axis in this direction [any length; world after `at` or `between`, else
            /// frame of both bodies].
            #[must_use]
            pub fn with_axis(mut self, axis: Vec3) -> Self {
                self.ends.turn(axis);
                self
            }

            /// With these anchors [m, frame of each body, unscaled].
            #[must_use]
            pub fn with_local_anchors(mut self, anchor1: Vec3, anchor2: Vec3) -> Self {
                self.ends.anchor(anchor1, anchor2);
                self
            }
        }
    )+ };
}

placed!(FixedJoint, RevoluteJoint, PrismaticJoint, SphericalJoint, DistanceJoint, RopeJoint);

/// Holds two bodies together.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_insert = mend_joint, on_remove = look_at_joint)]
#[require(super::PhysicsJoint)]
#[reflect(Component)]
pub struct FixedJoint {
    /// Its bodies and place.
    pub ends: JointEnds,
    /// Softness; default `None`: rigid.
    pub spring: Option<JointSpringiness>,
}

impl FixedJoint {
    /// Holds two bodies together at their origins; place it with [`Self::at`].
    #[must_use]
    pub const fn new(body1: Entity, body2: Entity) -> Self {
        Self { ends: JointEnds::new(body1, body2), spring: None }
    }

    /// With this softness.
    #[must_use]
    pub const fn with_spring(self, spring: JointSpringiness) -> Self {
        Self { spring: Some(spring), ..self }
    }

    pub(super) fn kind(&self) -> JointKind {
        self.spring.map_or_else(Fixed::new, |spring| Fixed::soft(spring.spring())).into()
    }
}

/// A hinge: rotation about one axis.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_insert = mend_joint, on_remove = look_at_joint)]
#[require(super::PhysicsJoint)]
#[reflect(Component)]
pub struct RevoluteJoint {
    /// Its bodies and place.
    pub ends: JointEnds,
    /// Limits of the angle [rad]; default `None`.
    pub limits: Option<JointLimits>,
    /// Its motor; default `None`.
    pub motor: Option<JointMotor>,
    /// Maximum torque of its friction [N m]; default 0.
    pub friction: f32,
}

impl RevoluteJoint {
    /// A hinge at the origins of two bodies; place it with [`Self::at`] and [`Self::with_axis`].
    #[must_use]
    pub const fn new(body1: Entity, body2: Entity) -> Self {
        Self { ends: JointEnds::new(body1, body2), limits: None, motor: None, friction: 0.0 }
    }

    /// With these limits of the angle [rad].
    #[must_use]
    pub const fn with_angle_limits(self, min: f32, max: f32) -> Self {
        Self { limits: Some(JointLimits { min, max, spring: None }), ..self }
    }

    /// With this motor.
    #[must_use]
    pub const fn with_motor(self, motor: JointMotor) -> Self {
        Self { motor: Some(motor), ..self }
    }

    /// With friction of at most this torque [N m].
    #[must_use]
    pub const fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    pub(super) fn kind(&self) -> JointKind {
        Hinge::of(axis(self.limits, self.motor, self.friction)).into()
    }
}

/// A slider: translation along one axis.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_insert = mend_joint, on_remove = look_at_joint)]
#[require(super::PhysicsJoint)]
#[reflect(Component)]
pub struct PrismaticJoint {
    /// Its bodies and place.
    pub ends: JointEnds,
    /// Limits of the position [m]; default `None`.
    pub limits: Option<JointLimits>,
    /// Its motor; default `None`.
    pub motor: Option<JointMotor>,
    /// Maximum force of its friction [N]; default 0.
    pub friction: f32,
}

impl PrismaticJoint {
    /// A slider at the origins of two bodies; place it with [`Self::at`] and [`Self::with_axis`].
    #[must_use]
    pub const fn new(body1: Entity, body2: Entity) -> Self {
        Self { ends: JointEnds::new(body1, body2), limits: None, motor: None, friction: 0.0 }
    }

    /// With these limits of the position [m].
    #[must_use]
    pub const fn with_limits(self, min: f32, max: f32) -> Self {
        Self { limits: Some(JointLimits { min, max, spring: None }), ..self }
    }

    /// With this motor.
    #[must_use]
    pub const fn with_motor(self, motor: JointMotor) -> Self {
        Self { motor: Some(motor), ..self }
    }

    /// With friction of at most this force [N].
    #[must_use]
    pub const fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    pub(super) fn kind(&self) -> JointKind {
        Slider::of(axis(self.limits, self.motor, self.friction)).into()
    }
}

/// A ball joint: rotation about all axes.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_insert = mend_joint, on_remove = look_at_joint)]
#[require(super::PhysicsJoint)]
#[reflect(Component)]
pub struct SphericalJoint {
    /// Its bodies and place.
    pub ends: JointEnds,
    /// Half angle of the cone in which the axis may swing [rad]; default `None`: anywhere.
    pub swing: Option<f32>,
    /// Minimum and maximum twist about the axis [rad], with a cone; default `None`: any.
    pub twist: Option<(f32, f32)>,
    /// Maximum torque of its friction [N m]; default 0.
    pub friction: f32,
}

impl SphericalJoint {
    /// A ball joint at the origins of two bodies; place it with [`Self::at`].
    #[must_use]
    pub const fn new(body1: Entity, body2: Entity) -> Self {
        Self { ends: JointEnds::new(body1, body2), swing: None, twist: None, friction: 0.0 }
    }

    /// With this half angle of the cone in which the axis may swing [rad].
    #[must_use]
    pub const fn with_swing_limit(self, swing: f32) -> Self {
        Self { swing: Some(swing), ..self }
    }

    /// With these limits of the twist about the axis [rad]. Without a swing limit, the axis may
    /// swing by a half turn.
    #[must_use]
    pub const fn with_twist_limits(self, min: f32, max: f32) -> Self {
        Self { twist: Some((min, max)), ..self }
    }

    pub(super) fn kind(&self) -> JointKind {
        if self.swing.is_none() && self.twist.is_none() {
            return Ball::new().with_friction(self.friction).into();
        }
        let swing = self.swing.unwrap_or(core::f32::consts::PI);
        let cone = ConeTwist::new(swing, swing).with_friction(self.friction);
        self.twist.map_or(cone, |(min, max)| cone.with_twist(min, max)).into()
    }
}

/// Keeps the distance of two points between two lengths.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_insert = mend_joint, on_remove = look_at_joint)]
#[require(super::PhysicsJoint)]
#[reflect(Component)]
pub struct DistanceJoint {
    /// Its bodies and place.
    pub ends: JointEnds,
    /// Minimum distance [m], at least 0.
    pub min: f32,
    /// Maximum distance [m], at least `min`.
    pub max: f32,
    /// Rest length [m], frequency [Hz] and damping ratio of a spring between the limits; default
    /// `None`.
    pub spring: Option<[f32; 3]>,
}

impl DistanceJoint {
    /// A rod of this length [m] between two bodies.
    #[must_use]
    pub const fn new(body1: Entity, body2: Entity, length: f32) -> Self {
        Self { ends: JointEnds::new(body1, body2), min: length, max: length, spring: None }
    }

    /// With these limits of the distance [m].
    #[must_use]
    pub const fn with_limits(self, min: f32, max: f32) -> Self {
        Self { min, max, ..self }
    }

    /// With a spring of this rest length [m], frequency [Hz] and damping ratio.
    #[must_use]
    pub const fn with_spring(self, rest_length: f32, hertz: f32, damping_ratio: f32) -> Self {
        Self { spring: Some([rest_length, hertz, damping_ratio]), ..self }
    }

    pub(super) fn kind(&self) -> JointKind {
        let between = Distance::between(self.min, self.max);
        let spring = self.spring.map(|[rest, hertz, ratio]| Spring::new(rest, hertz, ratio));
        spring.map_or(between, |spring| between.with_spring(spring)).into()
    }
}

/// A rope without mass: keeps the distance of two points below a length.
#[derive(Clone, Component, Copy, Debug, PartialEq, Reflect)]
#[component(on_insert = mend_joint, on_remove = look_at_joint)]
#[require(super::PhysicsJoint)]
#[reflect(Component)]
pub struct RopeJoint {
    /// Its bodies and place.
    pub ends: JointEnds,
    /// Length [m], at least 0.
    pub length: f32,
}

impl RopeJoint {
    /// A rope of this length [m] between the origins of two bodies.
    #[must_use]
    pub const fn new(body1: Entity, body2: Entity, length: f32) -> Self {
        Self { ends: JointEnds::new(body1, body2), length }
    }

    pub(super) fn kind(&self) -> JointKind {
        Rope::new(self.length).into()
    }
}
