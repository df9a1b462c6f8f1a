//! Joints with translation: sliders, cylinders, planes.

use super::rotations::Hinge;
use crate::state::def::JointKind;
use crate::state::def::six_dof::{JointAxis, JointSpring, SixDof};

/// Translation along the x axis alone, without rotation: a lift, a piston, a drawer.
///
/// Its position is the displacement of the second body along the axis since they were joined,
/// relative to the first.
///
/// ```
/// use drystone::joint::Slider;
///
/// let drawer = Slider::new().with_limits(0.0, 0.4).with_friction(3.0);
/// let lift = Slider::new().with_limits(0.0, 12.0).with_motor(1.5, 9000.0);
/// # let _ = (drawer, lift);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slider {
    /// Its axis: limits [m], drive and friction [N].
    pub axis: JointAxis,
}

impl Slider {
    /// A free slider.
    #[must_use]
    pub const fn new() -> Self {
        Self::of(JointAxis::FREE)
    }

    /// A slider with this axis.
    #[must_use]
    pub const fn of(axis: JointAxis) -> Self {
        Self { axis }
    }

    /// With two hard stops [m].
    #[must_use]
    pub const fn with_limits(self, min: f32, max: f32) -> Self {
        Self::of(self.axis.with_limits(min, max))
    }

    /// With limits [m] beyond which this spring pushes back.
    #[must_use]
    pub const fn with_soft_limits(self, min: f32, max: f32, spring: JointSpring) -> Self {
        Self::of(self.axis.with_soft_limits(min, max, spring))
    }

    /// With a motor at this speed [m/s] with at most this force [N]. Speed 0 makes it a brake.
    #[must_use]
    pub const fn with_motor(self, speed: f32, max_force: f32) -> Self {
        Self::of(self.axis.with_motor(speed, max_force))
    }

    /// With a servo to this position [m] with at most this force [N].
    #[must_use]
    pub const fn with_servo(self, position: f32, spring: JointSpring, max_force: f32) -> Self {
        Self::of(self.axis.with_servo(position, spring, max_force))
    }

    /// With dry friction of at most this force [N].
    #[must_use]
    pub const fn with_friction(self, force: f32) -> Self {
        Self::of(self.axis.with_friction(force))
    }

    /// Its six axes.
    #[must_use]
    pub const fn six_dof(self) -> SixDof {
        SixDof { linear: [self.axis, JointAxis::LOCKED, JointAxis::LOCKED], ..SixDof::FIXED }
    }
}

impl From<Slider> for SixDof {
    fn from(joint: Slider) -> Self {
        joint.six_dof()
    }
}

impl From<Slider> for JointKind {
    fn from(joint: Slider) -> Self {
        Self::SixDof(joint.six_dof())
    }
}

/// Translation along the x axis and rotation about it: a rod in a sleeve.
///
/// ```
/// use drystone::joint::{Cylindrical, JointAxis};
///
/// // A bolt: it slides by 30 mm, and may be turned.
/// let bolt = Cylindrical::of(JointAxis::limited(0.0, 0.03), JointAxis::FREE);
/// # let _ = bolt;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cylindrical {
    /// The translation [m; N].
    pub along: JointAxis,
    /// The rotation [rad; N m].
    pub about: JointAxis,
}

impl Cylindrical {
    /// A free cylindrical joint.
    #[must_use]
    pub const fn new() -> Self {
        Self::of(JointAxis::FREE, JointAxis::FREE)
    }

    /// A cylindrical joint with these axes.
    #[must_use]
    pub const fn of(along: JointAxis, about: JointAxis) -> Self {
        Self { along, about }
    }

    /// Its six axes.
    #[must_use]
    pub const fn six_dof(self) -> SixDof {
        let linear = Slider::of(self.along).six_dof().linear;
        SixDof { linear, ..Hinge::of(self.about).six_dof() }
    }
}

impl From<Cylindrical> for SixDof {
    fn from(joint: Cylindrical) -> Self {
        joint.six_dof()
    }
}

impl From<Cylindrical> for JointKind {
    fn from(joint: Cylindrical) -> Self {
        Self::SixDof(joint.six_dof())
    }
}

/// Translation in the plane perpendicular to the x axis, and rotation about x: a puck on a table
/// that it cannot leave.
///
/// ```
/// use drystone::joint::Planar;
/// use drystone::{BodyId, JointDef};
///
/// fn puck(table: BodyId, puck: BodyId) -> JointDef {
///     JointDef::new(table, puck, Planar::new()).at([0.0; 3]).with_axis([0.0, 1.0, 0.0])
/// }
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Planar {
    /// The translation along y [m; N].
    pub y: JointAxis,
    /// The translation along z [m; N].
    pub z: JointAxis,
    /// The rotation about x [rad; N m].
    pub turn: JointAxis,
}

impl Planar {
    /// A free planar joint.
    #[must_use]
    pub const fn new() -> Self {
        Self { y: JointAxis::FREE, z: JointAxis::FREE, turn: JointAxis::FREE }
    }

    /// Its six axes.
    #[must_use]
    pub const fn six_dof(self) -> SixDof {
        SixDof { linear: [JointAxis::LOCKED, self.y, self.z], ..Hinge::of(self.turn).six_dof() }
    }
}

impl From<Planar> for SixDof {
    fn from(joint: Planar) -> Self {
        joint.six_dof()
    }
}

impl From<Planar> for JointKind {
    fn from(joint: Planar) -> Self {
        Self::SixDof(joint.six_dof())
    }
}
