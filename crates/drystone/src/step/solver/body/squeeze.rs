//! Sums the load on a body over its contacts.

use crate::state::bodies::body::Subdivision;

/// Load on a solver body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Squeeze {
    /// Factor on its mass and inertia in this step.
    pub(crate) factor: f32,
    /// Refinement of its island.
    pub(crate) subdivision: Subdivision,
    /// Normal impulses on it in the last substep: their vector sum, and the sum of their magnitudes
    /// [N s].
    pub(crate) impulse: [f32; 4],
}

impl Default for Squeeze {
    fn default() -> Self {
        Self { factor: 1.0, subdivision: Subdivision::Whole, impulse: [0.0; 4] }
    }
}

impl Squeeze {
    /// Impulse that presses the body from both sides [N s]: half the excess of the sum of
    /// magnitudes over the magnitude of the sum. It is 0 for a body that is hit or that nothing
    /// else rests on.
    pub(crate) fn pressure(&self) -> f32 {
        let [x, y, z, all] = self.impulse;
        (0.5 * (all - (x * x + y * y + z * z).sqrt())).max(0.0)
    }
}
