//! Articulations in the solver: trees of links in reduced coordinates, and their contacts.
//!
//! A tree takes part in a group's passes. Velocities begin a substep of the tree
//! ([`begin`](crate::reduced::conserve)): half of the motion, the factor of the mass matrix,
//! free velocities. A solve pass sweeps the tree's own rows and the rows of its contacts over the
//! whitened velocities, in which a row is its own response. Positions end the substep: the other
//! half of the motion, then momentum and energy. A relax pass sweeps rigid rows.
//!
//! Contacts of links stay in blocks, which hold their geometry, bias and impulses. No kernel
//! sweeps these blocks; the tree does (`sweep.rs`). Overlaps are closed by displacement
//! (`overlaps.rs`). The solver body of a link shows the motion of
//! the tree. What other rows change in it is read back as an impulse on the link.
//!
//! Reads: bodies, contact blocks. Writes: articulations, solver bodies of links and of what they
//! touch, impulses in blocks. Runs: one worker for all trees of a group, in order.

mod begin;
mod drive;
pub(crate) mod group;
pub(crate) mod lent;
mod motion;
mod overlaps;
mod rows;
mod sweep;

pub(crate) use self::motion::state_of as link_state;
