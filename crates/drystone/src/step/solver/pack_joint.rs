//! Joints to blocks and back.

use super::rows::JointBlock;
use super::softness::Softness;
use super::{Batch, Scratch};
use crate::base::math::{Vec3, vec3};
use crate::base::sym3::Sym3;
use crate::base::wide::{LANES, Lanes};
use crate::state::bodies::{Bodies, Body};
use crate::state::colors::Colors;
use crate::state::def::JointKind;
use crate::state::joints::{Joint, Joints};
use crate::step::context::StepContext;

/// Builds the blocks of all colored joints and applies their impulses to the lines.
pub(super) fn prepare(
    ctx: &StepContext,
    bodies: &Bodies,
    joints: &Joints,
    colors: &mut Colors,
    scratch: &mut Scratch,
) {
    scratch.joint_batches.clear();
    let mut at = 0;
    for (fixed, coloring) in [(false, &mut colors.joints), (true, &mut colors.joints_fixed)] {
        for (color, members) in coloring.colors.iter().map(|c| &c.members).enumerate() {
            let first = at;
            for distances in [false, true] {
                let is_distance =
                    |row: &u32| matches!(joints.at(*row).kind, JointKind::Distance { .. });
                let mut lane = LANES;
                for row in members.iter().filter(|row| is_distance(row) == distances) {
                    if lane == LANES {
                        lane = 0;
                        at += 1;
                        scratch
                            .joints
                            .resize_with(scratch.joints.len().max(at), JointBlock::default);
                        scratch.joints[at - 1] =
                            JointBlock { is_distance: distances, ..JointBlock::default() };
                    }
                    fill(ctx, bodies, joints.at(*row), *row, lane, at - 1, scratch);
                    lane += 1;
                }
            }
            if at > first {
                scratch.joint_batches.push(Batch { blocks: first..at, fixed, color });
            }
        }
    }
    scratch.joints.truncate(at);
}

fn put(lanes: &mut [Lanes; 3], lane: usize, v: Vec3) {
    lanes[0][lane] = v.x;
    lanes[1][lane] = v.y;
    lanes[2][lane] = v.z;
}

fn fill(
    ctx: &StepContext,
    bodies: &Bodies,
    joint: &Joint,
    row: u32,
    lane: usize,
    block: usize,
    scratch: &mut Scratch,
) {
    let (a, b) = (bodies.at(joint.body_a), bodies.at(joint.body_b));
    let (la, lb) = (scratch.line_of[joint.body_a as usize], scratch.line_of[joint.body_b as usize]);
    let (wa, wb) = (scratch.whitening[la as usize], scratch.whitening[lb as usize]);
    let (ra, rb) = (a.rotation.rotate(joint.anchor_a), b.rotation.rotate(joint.anchor_b));
    let gap = (b.center - a.center) + (rb - ra);
    let moves = |body: &Body, r: Vec3| {
        if !body.is_dynamic() && body.active() { body.velocity_at(r) } else { Vec3::ZERO }
    };
    let impulse = joint.impulse * ctx.impulse_scale;

    let block = &mut scratch.joints[block];
    (block.row_a[lane], block.row_b[lane], block.joint[lane]) = (la, lb, row);
    (block.alpha[lane], block.beta[lane]) = (wa.alpha, wb.alpha);
    for i in 0..6 {
        block.s_a[i][lane] = wa.s[i];
        block.s_b[i][lane] = wb.s[i];
    }
    put(&mut block.r_a, lane, ra);
    put(&mut block.r_b, lane, rb);
    put(&mut block.gap, lane, gap);
    put(&mut block.drift, lane, moves(b, rb) - moves(a, ra));
    put(&mut block.impulse, lane, impulse);
    // The linear impulse along the gap (a distance) or in the world (a ball).
    let linear = match joint.kind {
        JointKind::Ball => impulse,
        JointKind::Distance { min, max, spring } => {
            let rest = spring.map_or(0.0, |s| s.rest_length);
            put(&mut block.limits, lane, vec3(min, max, rest));
            if let Some(s) = spring {
                let soft = Softness::new(s.hertz, s.damping_ratio, ctx.h);
                put(&mut block.spring, lane, vec3(soft.rate, soft.mass, soft.impulse));
            }
            gap.normalize_or(Vec3::Y) * (impulse.x - impulse.y + impulse.z)
        }
    };
    put(&mut block.last_r_a, lane, ra);
    put(&mut block.last_r_b, lane, rb);
    put(&mut block.last_p, lane, linear);
    let s_of = |s: [f32; 6]| Sym3 { xx: s[0], yy: s[1], zz: s[2], xy: s[3], xz: s[4], yz: s[5] };
    for (line, w, r, sign) in [(la, wa, ra, -1.0), (lb, wb, rb, 1.0)] {
        if line == 0 {
            continue;
        }
        let line = &mut scratch.lines[line as usize];
        let (v, t) = (linear * (sign * w.alpha), s_of(w.s).mul(r.cross(linear)) * sign);
        for i in 0..3 {
            line.v[i] += v[i];
            line.w[i] += t[i];
        }
    }
}

/// Writes the impulses back.
pub(super) fn store(joints: &mut Joints, scratch: &Scratch) {
    for block in &scratch.joints {
        for lane in 0..LANES {
            if block.joint[lane] != u32::MAX {
                joints.at_mut(block.joint[lane]).impulse =
                    vec3(block.impulse[0][lane], block.impulse[1][lane], block.impulse[2][lane]);
            }
        }
    }
}
