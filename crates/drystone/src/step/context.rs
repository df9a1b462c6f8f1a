//! Numbers of one step, worked out once.

use fearless_simd::Level;

use super::solver::inertia::LoadInertia;
use super::solver::softness::Softness;
use crate::base::math::Vec3;
use crate::state::config::{PenaltyConfig, WorldConfig};

/// Constants of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepContext {
    /// Step and substep [s].
    pub(crate) dt: f32,
    pub(crate) h: f32,
    pub(crate) inv_h: f32,
    pub(crate) substeps: u32,
    pub(crate) gravity: Vec3,
    /// Speculative distance [m].
    pub(crate) margin: f32,
    pub(crate) rest_offset: f32,
    pub(crate) recycle_distance: f32,
    pub(crate) restitution_speed: f32,
    pub(crate) hit_speed: f32,
    pub(crate) push_speed: f32,
    /// Contacts of two dynamic bodies, and with static ones.
    pub(crate) soft: Softness,
    pub(crate) soft_fixed: Softness,
    pub(crate) soft_joint: Softness,
    pub(crate) inertia: LoadInertia,
    /// Factor of the last step's impulses: substeps may have had another length.
    pub(crate) impulse_scale: f32,
    /// Springs of the penalty methods.
    pub(crate) penalty: PenaltyConfig,
    pub(crate) level: Level,
}

impl StepContext {
    pub(crate) fn new(config: &WorldConfig, dt: f32, last_h: f32, level: Level) -> Self {
        let substeps =
            if config.substeps == 0 { config.method.substeps() } else { config.substeps }.max(1);
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let h = dt / substeps as f32;
        let inv_h = 1.0 / h;
        let c = &config.contact;
        // The stiffest contact that stays stable is tied to the substep: f h <= 0.11 to 0.125
        // (docs/derivations/soft-step.md).
        let hertz = if c.hertz > 0.0 { c.hertz.min(0.25 * inv_h) } else { 0.1125 * inv_h };
        let joint_hertz = if config.joint.hertz > 0.0 {
            config.joint.hertz.min(0.25 * inv_h)
        } else {
            0.25 * inv_h
        };
        let most = config.inertia.most;
        let most = if most > 0.0 { most } else { config.method.inertia() };
        Self {
            dt,
            h,
            inv_h,
            substeps,
            gravity: config.gravity,
            margin: c.margin,
            rest_offset: c.rest_offset,
            recycle_distance: c.recycle_distance,
            restitution_speed: c.restitution_speed,
            hit_speed: c.hit_speed,
            push_speed: c.push_speed,
            soft: Softness::new(hertz, c.damping_ratio, h),
            soft_fixed: Softness::new(2.0 * hertz, 0.5 * c.damping_ratio, h),
            inertia: LoadInertia { most, threshold: config.inertia.threshold },
            soft_joint: Softness::new(joint_hertz, config.joint.damping_ratio, h),
            impulse_scale: if last_h > 0.0 && config.method.persists() {
                (h / last_h).min(4.0)
            } else {
                0.0
            },
            penalty: config.penalty,
            level,
        }
    }
}
