//! Joints that go round fast: what frozen rows and soft joints make wrong of them grows as the square of the angle of a
//! substep (docs/derivations/joints.md), so their islands take substeps in parts.

use crate::base::math::Vec3;
use crate::state::bodies::{Bodies, Body, Fineness, NONE};
use crate::state::islands::Island;
use crate::state::joints::Joints;

/// Most bodies of an island that takes its substeps in parts: what one limb does is no reason to solve a whole pile finely.
const MOST_BODIES: u32 = 64;

/// From this part of its size on that a joint's anchor is off its tangent after a substep, times two: a tenth of a radian for
/// one at the body's end.
const ENTER: f32 = 0.01;

/// Until it falls below this: a mechanism at the limit does not change its stiffness in each step.
const LEAVE: f32 = 0.005;

/// True if some joint of the island, one that is small and awake, goes round so fast that substeps of `h` [s] are too long.
pub(super) fn whirls(island: &Island, bodies: &Bodies, joints: &Joints, h: f32) -> bool {
    if island.len > MOST_BODIES {
        return false;
    }
    let mut row = island.first;
    while row != NONE {
        let body = bodies.at(row);
        if !body.active() {
            return false;
        }
        let limit = if body.fineness == Fineness::Whirling { LEAVE } else { ENTER };
        for joint in body.joints.iter().map(|joint| joints.at(*joint)) {
            let sides = [(joint.body_a, joint.anchor_a), (joint.body_b, joint.anchor_b)];
            let is_bent = |end: u32, arm: Vec3| {
                let end = bodies.at(end);
                // Most turn so slowly that no arm could be: an arm's end is off by no more than this, and rounding.
                let most = end.w.length_squared() * (h * h);
                most > 0.99 * limit && bend(end, arm, h) > limit * body.extent.max(arm.length())
            };
            if sides.iter().any(|(end, arm)| is_bent(*end, *arm)) {
                return true;
            }
        }
        row = body.island_next;
    }
    false
}

/// Twice what the end of an arm is off its tangent after `h` [m].
fn bend(body: &Body, arm: Vec3, h: f32) -> f32 {
    let arm = body.rotation.rotate(arm);
    body.w.cross(body.w.cross(arm)).length() * (h * h)
}
