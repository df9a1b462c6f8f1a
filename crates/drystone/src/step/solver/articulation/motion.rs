//! Conversions between the doubles of trees and the rows of bodies and blocks.

use crate::base::limits;
use crate::base::math::{Vec3, vec3};
use crate::base::quat::Quat;
use crate::reduced::linked::LinkMotion;
use crate::step::context::softness::Softness;
use crate::step::solver::body::state::BodyState;
use crate::step::solver::contact::block::ContactBlock;
use crate::step::solver::contact::sweep::{self, ContactSweep};

/// Impulse of row `k` of a lane: of a point, or of the tangents and the twist after these.
pub(super) fn impulse_of(block: &ContactBlock, lane: usize, k: usize, count: usize) -> f64 {
    f64::from(if k < count {
        block.points[k].impulse[lane]
    } else {
        block.friction[k - count][lane]
    })
}

pub(super) fn link_sweep(
    inv_h: f32,
    softness: Softness,
    (relaxes, cap): (bool, f32),
    elapsed: f32,
) -> ContactSweep {
    ContactSweep { inv_h, softness, relaxes, cap, hit: sweep::HIT_SPEED, inner: 1, elapsed }
}

#[expect(clippy::cast_possible_truncation, reason = "bodies have this precision")]
pub(super) fn vector(v: [f64; 3]) -> Vec3 {
    vec3(v[0] as f32, v[1] as f32, v[2] as f32)
}

pub(super) fn wide(v: Vec3) -> [f64; 3] {
    v.to_array().map(f64::from)
}

#[expect(clippy::cast_possible_truncation, reason = "solver bodies have this precision")]
pub(super) fn four(v: [f64; 3]) -> [f32; 4] {
    [v[0] as f32, v[1] as f32, v[2] as f32, 0.0]
}

/// True if a body may have this motion.
pub(super) fn is_kept(motion: &LinkMotion) -> bool {
    let below = |v: [f64; 3], maximum: f32| v.iter().all(|x| x.abs() < f64::from(maximum));
    let fast = limits::SPEED_KEPT.maximum;
    below(motion.center, limits::POSITION_KEPT.maximum)
        && below(motion.v, fast)
        && below(motion.w, fast)
}

pub(crate) fn state_of(motion: &LinkMotion) -> BodyState {
    #[expect(clippy::cast_possible_truncation, reason = "bodies have this precision")]
    let [w, x, y, z] = motion.rotation.map(|part| part as f32);
    BodyState {
        center: vector(motion.center),
        rotation: Quat::new(x, y, z, w),
        v: vector(motion.v),
        w: vector(motion.w),
        w_low: Vec3::ZERO,
    }
}

/// A state that finalize refuses.
pub(super) fn lost() -> BodyState {
    let nothing = vec3(f32::NAN, f32::NAN, f32::NAN);
    BodyState {
        center: nothing,
        rotation: Quat::IDENTITY,
        v: nothing,
        w: nothing,
        w_low: Vec3::ZERO,
    }
}
