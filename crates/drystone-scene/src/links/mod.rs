//! Bodies that hang on each other in a tree, as files of robots describe them. Links and the joints
//! between them become bodies and joints of a scene.
//!
//! A link that is held fast is one body with its parent: that is exact, and cheaper than a joint.
//! Its name lives on as a [`crate::SceneFrame`].

mod assemble;
mod compose;
mod hulls;
mod link;
mod reduce;

pub(crate) use self::assemble::{Anchored, Assembled, assemble};
pub(crate) use self::hulls::Hulls;
pub(crate) use self::link::{Dof, Hold, Link, Way, Weight};
pub use self::reduce::reduce;
