//! Trees of links in reduced coordinates: robots, chains, mechanisms.
//!
//! The state of a tree is one number for each angle or displacement of a joint, so joints cannot
//! drift. An [`Articulation`] has forward kinematics, Jacobians, mass matrix, bias forces,
//! inverse and forward dynamics, and a step that gives no passive tree energy.
//!
//! ```
//! use drystone::articulation::{Articulation, LinkDef, TreeDef, TreeJoint};
//!
//! # fn main() -> Result<(), drystone::articulation::TreeError> {
//! // A pendulum: 1 kg at 0.5 m below a hinge about y, 0.1 m in size.
//! let bob = LinkDef::on(None)
//!     .with_joint(TreeJoint::hinge([0.0, 1.0, 0.0]))
//!     .with_mass(1.0, [0.0, 0.0, -0.5], [0.004, 0.004, 0.004, 0.0, 0.0, 0.0]);
//! let def = TreeDef { links: vec![bob], ..TreeDef::default() };
//! let mut pendulum = Articulation::new(&def, [0.0, 0.0, -9.81])?;
//! pendulum.set_state(&[0.1], &[0.0])?;
//! // Half of its period, π √((0.25 + 0.004)/(9.81 · 0.5)) s, later it is on the other side.
//! let half = core::f64::consts::PI * f64::sqrt(0.254 / (9.81 * 0.5));
//! for _ in 0..100 {
//!     pendulum.step(half / 100.0)?;
//! }
//! assert!((pendulum.q()[0] + 0.1).abs() < 1.0e-3);
//! # Ok(())
//! # }
//! ```
//!
//! # Conventions
//!
//! Coordinates `q` and velocities `v` are those of MuJoCo: joint after joint, link after link. A
//! hinge and a slide have one number in each; a ball four and three, a free joint seven and six.
//! Quaternions have the real part first. Angular velocities of ball and free joints are in the
//! link's axes, the linear velocity of a free joint in the world's. Generalized forces belong to
//! `v`. A link with several joints has them in a row; a fixed link has none.
//!
//! # How it is computed
//!
//! Spatial vectors stand in world axes about the origin of the first link (`spatial.rs`). The mass
//! matrix is made of composite bodies and factored along the branches as LᵀDL [Featherstone08]
//! (`dynamics.rs`). Articulated bodies (`bodies.rs`) give the same accelerations. A step
//! (`step.rs`) takes forces in the middle of the motion (`velocities.rs`), then restores momentum
//! and energy (`conserve.rs`). All code is over numbers or lanes (`number.rs`), so the same tree in
//! several worlds goes side by side with the same bits as alone.
//!
//! # Rows
//!
//! Limits, friction, couplings, tendons and closures are rows (`row.rs`, `gather.rs`): w with
//! impulse λ on whitened velocities y = √D L v. A row has up to two segments of y. A tree's
//! segment is D^-½ L^-ᵀ Jᵀ, a free body's is J over √m and √I. So a contact of a tree with a tree,
//! a body or the ground is a normal row and friction rows in the same sweep. The contact's Jacobian
//! is that of its point along the normal (`fill_direction`).

mod number;
mod spatial;
mod def;
mod check;
mod tree;
mod work;
mod kinematics;
mod dynamics;
#[cfg_attr(not(test), expect(dead_code, reason = "for long chains, when the solver has trees"))]
mod bodies;
mod row;
mod gather;
mod velocities;
mod conserve;
mod step;
mod whole;
#[cfg(test)]
mod tests;

pub use self::def::{
    LinkDef, RowSoftness, TreeCoupling, TreeDef, TreeError, TreeJoint, TreeJointKind, TreeLoop,
    TreeTendon,
};
pub use self::step::TreeStepConfig;
pub use self::whole::Articulation;
