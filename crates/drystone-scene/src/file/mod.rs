//! Files on disk: written whole or not at all, and read no further than a limit.

mod limit;
mod partial;
mod whole;

pub use self::limit::{Kind, read, read_any};
pub use self::partial::remove_unfinished;
pub use self::whole::{Ending, WholeFile};

pub(crate) use self::limit::{open, rest};
