//! Trigonometry with the same bits on every target: from the `libm` crate, never the platform's.

/// Sine and cosine of `x` [rad].
#[must_use]
pub fn sin_cos(x: f32) -> (f32, f32) {
    libm::sincosf(x)
}

/// Tangent of `x` [rad].
#[must_use]
pub fn tan(x: f32) -> f32 {
    libm::tanf(x)
}

/// Angle of the point (x, y) [rad], −π to π.
#[must_use]
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// Angle whose cosine is `x` [rad]; `x` is clamped to −1 to 1.
#[must_use]
pub fn acos(x: f32) -> f32 {
    libm::acosf(x.clamp(-1.0, 1.0))
}

/// e to the power `x`.
#[must_use]
pub fn exp(x: f32) -> f32 {
    libm::expf(x)
}
