//! The rule by which a body's inertia grows with its load.

use crate::state::bodies::body::{Body, Subdivision};

/// Bodies that turn faster than this get their own inertia back [rad/s], so toppling takes its real
/// time. Bodies larger than this [m] (half the diagonal of a cube of 1 m) topple slower, as the
/// root of their size. With 0.2 rad/s for all, dominoes of 10 m fell 11 % late at 60 Hz, and 36 %
/// at 480 Hz. (Raising the speed for smaller bodies makes them late.)
pub(crate) const TURNING: f32 = 0.2;

const SIZE: f32 = 0.87;

/// The factor rises if the load requires this much more, and falls if it requires this much less.
/// The gap keeps ripples of the impulses from pumping energy.
const HYSTERESIS: f32 = 0.2;

/// Part of the difference by which the factor falls in a step. It is small, since following the
/// load down at once pumps energy. Upward the factor follows at once.
const FALL: f32 = 0.03;

/// Load, over the maximum factor, from which on the factor grows again, and the bound on that
/// growth in multiples of the maximum. (With 16 for all loads, a stack of 100 drifts by 0.2 m and
/// an arch of 101 stones falls.)
const BEYOND: f32 = 5.0;

const GREATEST: f32 = 3.0;

/// A load below this part of the factor counts as gone. The body must not float, so its factor
/// falls by this part in a step. (Removing it at once makes a tower hop: at the top of each hop the
/// tower loses its load, sinks into its soft contacts, and is thrown again as the factor returns.)
const GONE: f32 = 0.1;

const RELEASE: f32 = 0.5;

/// A load below this part of the threshold needs no factor, and the rest of a factor left by a
/// passing peak falls by this part in a step. (Within the hysteresis it would stay for good, and a
/// pushed body would be too heavy for ever.)
pub(crate) const LIGHT: f32 = 1.0 / (1.0 + HYSTERESIS);

const EASE: f32 = 0.4;

/// Parameters of the rule in one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadInertia {
    /// Maximum factor of a body at rest; 1: off.
    pub(crate) maximum: f32,
    /// Heavily loaded islands subdivide their substeps, and greater loads have no greater factors:
    /// a load of 2000:1 on ten boxes was thrown off.
    pub(crate) in_parts: bool,
    /// Load per mass above which the factor rises [m/s²].
    pub(crate) threshold: f32,
    /// Length of a typical body [m].
    pub(crate) length: f32,
}

impl LoadInertia {
    pub(crate) fn is_on(&self) -> bool {
        self.maximum > 1.0
    }

    /// True if the body's island needs more substeps: from three quarters of the maximum factor on,
    /// where loads may exceed its capacity, until the factor falls below a fifth. (With a single
    /// limit a stack near it would never rest: contacts become four times as stiff, so the stack
    /// hops, is not loaded, and goes back.)
    pub(crate) fn wants_refining(&self, body: &Body) -> bool {
        body.history.inertia_factor
            >= self.maximum
                * if body.history.subdivision == Subdivision::Loaded { 0.2 } else { 0.75 }
    }

    /// The factor for a load of `raw` thresholds: linear up to `maximum`, constant up to [`BEYOND`]
    /// times that, then growing as the root. No stack weighs that much, but a body dropped on one
    /// does. It then meets the resistance without which the stack would be crushed and fall.
    fn at_load(&self, raw: f32) -> f32 {
        let beyond = raw / (BEYOND * self.maximum);
        if beyond > 1.0 && !self.in_parts {
            self.maximum * beyond.sqrt().min(GREATEST)
        } else {
            raw.clamp(1.0, self.maximum)
        }
    }

    /// The factor of a body that has rested under its load: the value to which the factor of a peak
    /// falls.
    pub(crate) fn at_rest(&self, body: &Body) -> f32 {
        let wanted = self.at_load(body.history.load / (body.inertia.mass * self.threshold));
        if wanted > 1.0 { wanted / (1.0 - HYSTERESIS) } else { 1.0 }
    }

    /// The body's factor in this step.
    pub(crate) fn factor(&self, body: &Body) -> f32 {
        let s = body.history.inertia_factor;
        // Most bodies have neither a factor nor a load that requires one.
        if s <= 1.0 && body.history.load <= body.inertia.mass * self.threshold {
            return 1.0;
        }
        let raw = body.history.load / (body.inertia.mass * self.threshold);
        let size = (body.extent * (1.0 / (SIZE * self.length))).max(1.0);
        let turning = body.w.length_squared() * (size / (TURNING * TURNING));
        let wanted = 1.0 + (self.at_load(raw) - 1.0) / (1.0 + turning);
        if wanted > (1.0 + HYSTERESIS) * s {
            wanted
        } else if raw < GONE * s {
            s + RELEASE * (wanted - s)
        } else if raw < LIGHT {
            s + EASE * (wanted - s)
        } else if wanted < (1.0 - HYSTERESIS) * s {
            s + FALL * (wanted - s)
        } else {
            s
        }
    }
}
