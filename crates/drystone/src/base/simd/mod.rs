//! SIMD lanes: numbers, vectors and quaternions, eight at a time.

pub(crate) mod wide;
mod wide_vec;
pub(crate) mod wide_quat;
pub(crate) mod double_wide;
