//! Conversions between the doubles of trees and the rows of bodies and blocks.

use crate::base::limits;
use crate::base::math::{Vec3, vec3};
use crate::base::quat::Quat;
use crate::reduced::linked::LinkMotion;
use crate::state::bodies::body::Body;
use crate::step::solver::body::state::BodyState;
use crate::step::solver::contact::block::ContactBlock;

/// Impulse of row `k` of a lane: of a point, or of the tangents and the twist after these.
pub(super) fn impulse_of(block: &ContactBlock, lane: usize, k: usize, count: usize) -> f64 {
    f64::from(if k < count {
        block.points[k].impulse[lane]
    } else {
        block.friction[k - count][lane]
    })
}

/// The same impulse for changes.
pub(super) fn impulse_mut(
    block: &mut ContactBlock,
    lane: usize,
    k: usize,
    count: usize,
) -> &mut f32 {
    if k < count {
        &mut block.points[k].impulse[lane]
    } else {
        &mut block.friction[k - count][lane]
    }
}

/// Moments of inertia, times a vector [world], about the principal axes of a body.
pub(super) fn turned(body: &Body, moments: Vec3, w: Vec3) -> Vec3 {
    let axes = body.rotation * body.inertia.principal;
    let w = axes.unrotate(w);
    axes.rotate(vec3(w.x * moments.x, w.y * moments.y, w.z * moments.z))
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
