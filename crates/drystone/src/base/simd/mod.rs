//! SIMD lanes: numbers, vectors and quaternions, eight at a time.

pub(crate) mod wide;
pub(crate) mod wide_quat;
pub(crate) mod double_wide;
