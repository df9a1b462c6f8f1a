//! Joints by name, defined by their six axes or by a distance.

mod held;
mod lengths;
mod slides;
mod turns;

pub use self::held::{Fixed, Servo, Wheel};
pub use self::lengths::{Distance, Rope};
pub use self::slides::{Cylindrical, Planar, Slider};
pub use self::turns::{Ball, ConeTwist, Hinge, Universal};

use super::JointKind;
use super::six_dof::SixDof;

impl From<SixDof> for JointKind {
    fn from(axes: SixDof) -> Self {
        Self::SixDof(axes)
    }
}
