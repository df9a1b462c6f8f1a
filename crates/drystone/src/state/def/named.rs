//! Joints by name, defined by their six axes or by a distance.

mod fixed;
mod lengths;
mod translations;
mod rotations;

pub use self::fixed::{Fixed, Servo, Wheel};
pub use self::lengths::{Distance, Rope};
pub use self::rotations::{Ball, ConeTwist, Hinge, Universal};
pub use self::translations::{Cylindrical, Planar, Slider};

use super::JointKind;
use super::six_dof::SixDof;

impl From<SixDof> for JointKind {
    fn from(axes: SixDof) -> Self {
        Self::SixDof(axes)
    }
}
