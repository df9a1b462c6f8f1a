//! Marks contacts for overlap correction, and holds its rows.

use super::block::{ContactBlock, K, PointRows};
use super::raw;
use crate::base::simd::wide::Lanes;
use crate::state::bodies::body::Body;
use crate::state::contacts::Traits;
use crate::step::context::softness::Softness;

/// Rows of a block in the overlap correction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parting {
    pub(crate) is_ready: bool,
    /// Target speed of each point [m/s]; a point below 0 may close.
    pub(crate) wanted: [Lanes; 4],
    /// 1/K_jj; 0 for points that take no part.
    pub(crate) mass: [Lanes; 4],
    pub(crate) impulse: [Lanes; 4],
}

/// True if only contacts act on a body.
pub(crate) fn is_free(body: &Body) -> bool {
    !body.is_dynamic() || body.ties.joints.is_empty() && !body.record.dragged
}

/// Equilibrium depth of a point per load: this, over the mass that it bears [m/(N s)].
pub(crate) const fn give(softness: &Softness) -> f32 {
    softness.impulse / softness.rate
}

/// Bit for each contact under overlap correction, or about to be. Contacts with their own spring
/// softness may be of any depth.
#[cold]
pub(crate) fn mark<const FIXED: bool>(
    source: &raw::Source<'_>,
    raw: &raw::Raw<'_>,
    block: &ContactBlock,
) -> u8 {
    let ctx = source.ctx;
    let softness = if FIXED { &ctx.soft_fixed } else { &ctx.soft };
    let mut parting = 0;
    for (lane, c) in raw.contacts.iter().enumerate() {
        let count = usize::from(c.count.min(4));
        let ends = [c.body_a, c.body_b].map(|row| source.bodies.at(row));
        // Idle lanes have no points.
        if !(raw.count[lane] > 0.0) || c.traits.may_soften() || !ends.into_iter().all(is_free) {
            continue;
        }
        let points = &block.points[..count];
        let load: f32 = points.iter().map(|point| point.impulse[lane]).sum();
        let given = load / raw.count[lane] * give(softness);
        let excess =
            |(j, point): (usize, &PointRows)| -point.s0[lane] - given * block.k[K[j][j]][lane];
        let maximum = points.iter().enumerate().map(excess).fold(0.0, f32::max);
        if c.traits.any(Traits::PARTING) || !source.is_renewed && maximum > ctx.deep {
            parting |= 1 << lane;
        }
    }
    parting
}

/// 1 for each bit.
pub(crate) fn lanes(bits: u8) -> Lanes {
    core::array::from_fn(|lane| f32::from(bits >> lane & 1))
}
