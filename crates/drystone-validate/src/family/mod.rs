//! The tests, a file a family.

pub(crate) mod flight;
pub(crate) mod friction;
pub(crate) mod impact;
pub(crate) mod rolling;
pub(crate) mod rotation;
