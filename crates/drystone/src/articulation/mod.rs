//! Trees of links in reduced coordinates: robots, chains, mechanisms.
//!
//! (written at the end)

mod number;
mod spatial;
mod def;
mod tree;
mod work;
mod kinematics;
mod dynamics;
mod bodies;
mod row;
mod gather;
mod step;
#[cfg(test)]
mod tests;

pub use self::bodies::ArticulatedWork;
pub use self::def::{
    LinkDef, RowSoftness, TreeCoupling, TreeDef, TreeError, TreeJoint, TreeJointKind, TreeLoop,
    TreeTendon,
};
pub use self::number::{Lanes, Number};
pub use self::spatial::{Rotation, Spatial, Vector};
pub use self::step::{TreeState, TreeStepConfig, TreeStepReport};
pub use self::tree::Tree;
pub use self::work::TreeWork;
