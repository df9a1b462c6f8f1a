//! Soft constraints: a damped spring, integrated implicitly, as three numbers [Catto11].

use crate::base::trig;

/// A constraint is solved as `d = -mass K⁻¹ (velocity + rate · error) - impulse · accumulated`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Softness {
    /// Error removed per time [1/s], times `mass`.
    pub(crate) rate: f32,
    pub(crate) mass: f32,
    /// Part of the accumulated impulse that is given back.
    pub(crate) impulse: f32,
}

impl Softness {
    /// No spring: removes velocity and keeps the error.
    pub(crate) const RIGID: Self = Self { rate: 0.0, mass: 1.0, impulse: 0.0 };

    /// A spring of this frequency [Hz] and damping ratio, for substeps of `h` [s].
    pub(crate) fn new(hertz: f32, damping_ratio: f32, h: f32) -> Self {
        if !(hertz > 0.0) {
            return Self::RIGID;
        }
        let omega = 2.0 * core::f32::consts::PI * hertz;
        // [Catto11]: a1 = 2 zeta + h omega, a2 = h omega a1; rate = omega / a1.
        let a1 = 2.0 * damping_ratio + h * omega;
        let a2 = h * omega * a1;
        let impulse = 1.0 / (1.0 + a2);
        let mass = a2 * impulse;
        Self { rate: omega / a1 * mass, mass, impulse }
    }

    /// Hardness for a substep: `c h K + k h² K` of the spring, where K is the inverse mass that it
    /// acts on. Infinite for [`RIGID`](Self::RIGID).
    pub(crate) const fn hardness(&self) -> f32 {
        self.mass / self.impulse
    }
}

/// A soft constraint in a system of equations that is solved at once [Catto11]: `velocity + rate ·
/// error + compliance · K · accumulated = 0`, where K is the inverse mass that the spring acts on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Compliance {
    /// Error removed per time [1/s].
    pub(crate) rate: f32,
    pub(crate) compliance: f32,
}

impl Compliance {
    /// A spring of this frequency [Hz] and damping ratio, for substeps of `h` [s].
    pub(crate) fn new(hertz: f32, damping_ratio: f32, h: f32) -> Self {
        let omega = 2.0 * core::f32::consts::PI * hertz;
        let a1 = 2.0 * damping_ratio + h * omega;
        Self { rate: omega / a1, compliance: (1.0 / (h * omega * a1)).min(f32::MAX) }
    }
}

/// `1 / (1 + c h)`: velocity left after damping at rate `c` [1/s] for `h` [s]; never negative.
pub(crate) fn decay(c: f32, h: f32) -> f32 {
    1.0 / (1.0 + c * h)
}

/// Exact decay `exp(-c t)`.
pub(crate) fn exact_decay(c: f32, t: f32) -> f32 {
    if c > 0.0 { trig::exp(-c * t) } else { 1.0 }
}
