//! Tied particles: the passes of a substep, in step with those of the bodies, and their constants.
//!
//! The same equations have three forms. *Soft*: velocities, soft rows that keep their impulses, a
//! relax sweep at the end of the step. *Aim*: velocities, bias 1/h, no stored impulses, no relax
//! sweep. *Verlet*: positions are projected, velocity is the displacement [Jakobsen01]; equal to
//! *aim* except for rounding.

use fearless_simd::Level;

use super::chain;
use crate::base::math::Vec3;
use crate::base::threads::disjoint::Rows;
use crate::state::def::config::{ParticleForm, WorldConfig};
use crate::step::context::StepContext;
use crate::step::context::caps::{Caps, SHORTEST_OF_PARTICLES};
use crate::step::context::softness::Softness;
use crate::step::solver_body::{SolverBody, Whitening};

/// Stiffness of links for a substep's rate, unless configured (docs/decisions/020-particles.md).
const HERTZ: f32 = 1.0;

/// Part of a substep's impulses with which the next one warm-starts. Keeping all of them reduced
/// the error to a tenth, until a rope snapped taut: the impact was repeated, and the rope never
/// came to rest.
const KEEP: f32 = 0.5;

/// Sweeps of a substep of the soft form, unless configured.
const SWEEPS: u32 = 2;

/// Minimum number of substeps of soft links beside a method with fewer.
const MIN_SUBSTEPS: u32 = 8;

/// Sweeps of a substep of the projecting forms, unless configured.
const PROJECTIONS: u32 = 10;

/// Form in which links and contacts of particles are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    Soft,
    Aim,
    Verlet,
}

/// Constants of tied particles in one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    pub(crate) form: Form,
    pub(crate) h: f32,
    pub(crate) inv_h: f32,
    pub(crate) substeps: u32,
    pub(crate) sweeps: u32,
    pub(crate) softness: Softness,
    /// Part of the error of a chain's link that a substep removes, divided by the substep [1/s].
    pub(crate) chain_rate: f32,
    /// Compliance of a chain's links, as a part of their response to an impulse.
    pub(crate) chain_give: f32,
    /// Factor of the last step's impulses.
    pub(crate) impulse_scale: f32,
    /// Part of a substep's impulses with which the next one warm-starts.
    pub(crate) keep: f32,
    /// Solver bodies repeat their impulses of the last substep.
    pub(crate) bodies_repeat: bool,
    /// Caps on the speed at which errors close.
    pub(crate) caps: Caps,
    pub(crate) push_speed: f32,
    pub(crate) restitution_speed: f32,
    pub(crate) gravity: Vec3,
    pub(crate) level: Level,
}

impl Pace {
    pub(crate) fn new(ctx: &StepContext, config: &WorldConfig, last_h: f32) -> Self {
        let particle = &config.particle;
        let form = match particle.form {
            ParticleForm::Own if config.method.is_verlet() => Form::Verlet,
            ParticleForm::Own | ParticleForm::Soft => Form::Soft,
            ParticleForm::Aim => Form::Aim,
            ParticleForm::Verlet => Form::Verlet,
        };
        let lone = config.method.is_classic() && form == Form::Soft;
        let substeps = if lone { ctx.substeps.max(MIN_SUBSTEPS) } else { ctx.substeps };
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let h = ctx.dt / substeps as f32;
        let keeps = form == Form::Soft && last_h > 0.0;
        let own = if form == Form::Soft { SWEEPS } else { PROJECTIONS };
        let hertz = if particle.hertz > 0.0 {
            particle.hertz
        } else {
            HERTZ / h.max(SHORTEST_OF_PARTICLES)
        };
        let softness = Softness::new(hertz, particle.damping_ratio, h);
        // Chains are as soft as configured; by default they hardly yield.
        let soft = if particle.hertz > 0.0 { softness.impulse / softness.mass } else { 0.0 };
        Self {
            form,
            h,
            inv_h: 1.0 / h,
            substeps,
            sweeps: if particle.sweeps > 0 { particle.sweeps } else { own },
            softness,
            // Chains are solved at once, so this is the only limit on their rate.
            chain_rate: (softness.rate / softness.mass).min(1.0 / SHORTEST_OF_PARTICLES),
            chain_give: soft.max(chain::GIVE),
            impulse_scale: if keeps { (h / last_h).min(4.0) * KEEP } else { 0.0 },
            keep: if form == Form::Soft { KEEP } else { 0.0 },
            bodies_repeat: !config.method.is_classic(),
            caps: ctx.caps,
            push_speed: ctx.push_speed,
            restitution_speed: ctx.restitution_speed,
            gravity: ctx.gravity,
            level: ctx.level,
        }
    }
}

/// Solver bodies, as lent to the particles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolverBodies<'a> {
    pub(crate) solver_row_of: &'a [u32],
    pub(crate) solver_bodies: Rows<'a, SolverBody>,
    pub(crate) whitening: Rows<'a, Whitening>,
}

/// A sweep over all rows.
#[derive(Clone, Copy, Debug)]
pub(super) enum ParticlePass {
    /// With bias. `first`: the first sweep of a substep after another one, or of a projecting form.
    Solve {
        first: bool,
    },
    Relax,
}
