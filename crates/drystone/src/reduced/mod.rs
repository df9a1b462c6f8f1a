//! Trees of links in reduced coordinates: [`crate::articulation`] is the public face.

mod number;
mod spatial;
mod def;
mod check;
pub(crate) mod tree;
pub(crate) mod work;
mod kinematics;
mod dynamics;
#[cfg_attr(not(test), expect(dead_code, reason = "for long chains, when the solver has trees"))]
mod bodies;
mod row;
mod gather;
mod velocities;
pub(crate) mod conserve;
pub(crate) mod step;
pub(crate) mod linked;
pub(crate) mod whole;
#[cfg(test)]
mod tests;

pub use self::def::{
    LinkDef, RowSoftness, TreeCoupling, TreeDef, TreeError, TreeJoint, TreeJointKind, TreeLoop,
    TreeTendon,
};
pub use self::step::TreeStepConfig;
pub use self::whole::Articulation;
