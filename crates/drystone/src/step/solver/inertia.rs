//! Load-adaptive inertia: what is squeezed hard answers slowly, so that stacks and heavy loads do not
//! sink into what carries them.
//!
//! A soft contact under a load N gives by N / (m ω²): in a tall stack the lowest contacts carry a hundred
//! times what one body weighs, and give a hundred times as much. Shock propagation makes the bodies below
//! infinitely heavy [Guendelman03]; this is its bounded heir. A body that is squeezed by more than what
//! its contacts may give (`overlap`) has mass and inertia multiplied by s, 1 to `most`, within the
//! solver, and forces on it keep their size, so that its acceleration is divided by s. Statics do not
//! know mass: loads, the limits of friction and of tipping stay exact; only the answer to a change is
//! slower. See docs/decisions/011-load-adaptive-inertia.md for what each number below does.

use crate::base::math::Vec3;
use crate::state::bodies::Body;

/// Bodies that turn faster than this get their own inertia back [rad/s]: toppling keeps its time.
const TURNING: f32 = 0.2;

/// The factor goes up if the load asks for this much more, and down if for this much less: between, the
/// ripples of impulses cannot pump energy.
const HYSTERESIS: f32 = 0.2;

/// Part of the way up in a step, and down. Following the load down at once pumps energy.
const RISE: f32 = 0.5;
const FALL: f32 = 0.03;

/// A load below this part of the factor is gone: the body is free at once, and does not float.
const GONE: f32 = 0.1;

/// The numbers of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadInertia {
    /// Greatest factor; 1: off.
    pub(crate) most: f32,
    /// Acceleration that the load may give the body before the factor rises [m/s²].
    pub(crate) threshold: f32,
}

impl LoadInertia {
    /// `overlap`: what a contact may give before the factor rises [m]; `hertz`: its stiffness.
    ///
    /// A load N on a contact of stiffness m_e ω² gives N / (m_e ω²). Of two equal bodies m_e = m/2: the
    /// overlap is reached under the load N = m · overlap · ω² / 2.
    pub(crate) fn new(most: f32, overlap: f32, hertz: f32) -> Self {
        let omega = 2.0 * core::f32::consts::PI * hertz;
        Self { most, threshold: 0.5 * overlap * omega * omega }
    }

    pub(crate) fn is_on(&self) -> bool {
        self.most > 1.0
    }

    /// The body's factor in this step.
    pub(crate) fn factor(&self, body: &Body) -> f32 {
        let s = body.inertia_factor;
        let raw = body.load / (body.mass * self.threshold);
        let turning = body.w.length_squared() * (1.0 / (TURNING * TURNING));
        let wanted = 1.0 + (raw.clamp(1.0, self.most) - 1.0) / (1.0 + turning);
        if wanted > (1.0 + HYSTERESIS) * s {
            s + RISE * (wanted - s)
        } else if raw < GONE * s {
            wanted
        } else if wanted < (1.0 - HYSTERESIS) * s {
            s + FALL * (wanted - s)
        } else {
            s
        }
    }
}

/// How a body of the solver is squeezed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Squeeze {
    /// What its mass and inertia are multiplied by in this step.
    pub(crate) factor: f32,
    /// Half the sum of the normal impulses on it in the last substep [N s].
    pub(crate) impulse: f32,
}

impl Default for Squeeze {
    fn default() -> Self {
        Self { factor: 1.0, impulse: 0.0 }
    }
}

/// Momentum of an island, for its mean motion.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Momentum {
    mass: f64,
    p: [f64; 3],
    w: [f64; 3],
}

impl Momentum {
    pub(crate) fn add(&mut self, body: &Body) {
        let m = f64::from(body.mass);
        self.mass += m;
        for i in 0..3 {
            self.p[i] += m * f64::from(body.v[i]);
            self.w[i] += m * f64::from(body.w[i]);
        }
    }

    /// Mean velocity, and mean angular velocity.
    #[expect(clippy::cast_possible_truncation, reason = "a velocity of bodies that have f32")]
    pub(crate) fn mean(&self) -> (Vec3, Vec3) {
        let each = |x: [f64; 3]| {
            let of = |i: usize| (x[i] / self.mass) as f32;
            Vec3 { x: of(0), y: of(1), z: of(2) }
        };
        (each(self.p), each(self.w))
    }
}

/// Velocities of a body whose factor rises: it keeps its momentum against the motion of its island as it
/// becomes heavier. That takes energy, whatever the island's own motion is.
pub(crate) fn slowed(body: &Body, factor: f32, island: &Momentum) -> (Vec3, Vec3) {
    let (v, w) = island.mean();
    let part = 1.0 - body.inertia_factor / factor;
    (body.v + (v - body.v) * part, body.w + (w - body.w) * part)
}
