//! drystone
