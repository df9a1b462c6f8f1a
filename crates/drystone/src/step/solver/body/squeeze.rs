//! Load that a body bears, summed over its contacts.

use crate::state::bodies::Fineness;

/// How a body of the solver is squeezed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Squeeze {
    /// What its mass and inertia are multiplied by in this step.
    pub(crate) factor: f32,
    /// In what parts its island takes the substeps.
    pub(crate) fineness: Fineness,
    /// The normal impulses on it in the last substep: their vector sum, and the sum of their sizes
    /// [N s].
    pub(crate) impulse: [f32; 4],
}

impl Default for Squeeze {
    fn default() -> Self {
        Self { factor: 1.0, fineness: Fineness::Whole, impulse: [0.0; 4] }
    }
}

impl Squeeze {
    /// What presses the body from both sides [N s]: half of what its impulses are more than their sum. A
    /// body that is hit, or rests alone, is not squeezed.
    pub(crate) fn pressure(&self) -> f32 {
        let [x, y, z, all] = self.impulse;
        (0.5 * (all - (x * x + y * y + z * z).sqrt())).max(0.0)
    }
}
