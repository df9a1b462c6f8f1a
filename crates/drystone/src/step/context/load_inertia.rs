//! Inertia that grows with load: its rule.

use crate::state::bodies::{Body, Fineness};

/// Bodies that turn faster than this get their own inertia back [rad/s]: toppling keeps its time. What is
/// larger than this [m], half the diagonal of a cube of 1 m, topples slower, as the root of its size; with
/// 0.2 rad/s for all, dominoes of 10 m fell 11 % late at 60 Hz, 36 % at 480. (Smaller ones for which the speed
/// goes up are late by that.)
pub(crate) const TURNING: f32 = 0.2;

const SIZE: f32 = 0.87;

/// The factor goes up if the load asks for this much more, and down if for this much less: between, the
/// ripples of impulses cannot pump energy.
const HYSTERESIS: f32 = 0.2;

/// Part of the way down in a step, slow, for to follow the load down at once pumps energy. Upward it is
/// followed at once.
const FALL: f32 = 0.03;

/// The load, over the greatest factor, from which on the factor grows on, and how many times the greatest it
/// may become. (With 16 for all loads a stack of 100 drifts by 0.2 m and an arch of 101 stones falls.)
const BEYOND: f32 = 5.0;

const GREATEST: f32 = 3.0;

/// A load below this part of the factor is gone: the body must not float, and loses this much of its
/// factor in a step. (All at once makes a tower hop: it loses its load at the top of each hop, sinks into
/// its soft contacts and is thrown again as the factor comes back.)
const GONE: f32 = 0.1;

const RELEASE: f32 = 0.5;

/// A load below this part of the threshold asks for no factor, and what a passing peak left of one goes by this part in
/// a step. (Within the hysteresis it would stay for good, and what is pushed would be too heavy for ever.)
pub(crate) const LIGHT: f32 = 1.0 / (1.0 + HYSTERESIS);

const EASE: f32 = 0.4;

/// The numbers of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadInertia {
    /// Greatest factor for what stands; 1: off.
    pub(crate) most: f32,
    /// What bears much takes its substeps in parts, and greater loads have no greater factors: 2000:1 on ten boxes was
    /// thrown off.
    pub(crate) in_parts: bool,
    /// Load per mass above which the factor rises [m/s²].
    pub(crate) threshold: f32,
    /// Length of a typical body [m].
    pub(crate) length: f32,
}

impl LoadInertia {
    pub(crate) fn is_on(&self) -> bool {
        self.most > 1.0
    }

    /// True if its island needs more substeps: from three quarters of the greatest factor on, where loads may
    /// be beyond what that can carry, until it falls below a fifth. (With one limit for both a stack near it
    /// would never rest: contacts become four times as stiff, so it hops, is not loaded, and goes back.)
    pub(crate) fn wants_refining(&self, body: &Body) -> bool {
        body.inertia_factor
            >= self.most * if body.fineness == Fineness::Loaded { 0.2 } else { 0.75 }
    }

    /// The factor for a load that is so many times the threshold: the load itself, then `most`, and beyond
    /// [`BEYOND`] times that growing as its root. What no stack weighs, but what is dropped on one, so finds
    /// the resistance without which the stack would be crushed and fall.
    fn at_load(&self, raw: f32) -> f32 {
        let beyond = raw / (BEYOND * self.most);
        if beyond > 1.0 && !self.in_parts {
            self.most * beyond.sqrt().min(GREATEST)
        } else {
            raw.clamp(1.0, self.most)
        }
    }

    /// The factor of a body that has rested under its load: that of a peak, fallen as far as it falls.
    pub(crate) fn at_rest(&self, body: &Body) -> f32 {
        let wanted = self.at_load(body.load / (body.mass * self.threshold));
        if wanted > 1.0 { wanted / (1.0 - HYSTERESIS) } else { 1.0 }
    }

    /// The body's factor in this step.
    pub(crate) fn factor(&self, body: &Body) -> f32 {
        let s = body.inertia_factor;
        // Most bodies: without a factor, and without a load that asks for one.
        if s <= 1.0 && body.load <= body.mass * self.threshold {
            return 1.0;
        }
        let raw = body.load / (body.mass * self.threshold);
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
