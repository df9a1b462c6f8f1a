//! Joints to blocks and back.

use fearless_simd::dispatch;

use super::Solver;
use super::joint::{self, JointSweep};
use super::plan::{DISTANCE, Group};
use super::rows::JointBlock;
use super::softness::Softness;
use crate::base::jobs::{Executor, for_ranges, grain};
use crate::base::math::{Vec3, vec3};
use crate::base::sym3::Sym3;
use crate::base::wide::{LANES, Lanes};
use crate::state::bodies::Body;
use crate::state::joints::{Joint, Link};

impl Solver<'_> {
    pub(super) fn prepare_joints(&self, group: &Group, jobs: &dyn Executor) {
        for batch in &self.plan.joints.batches[group.joints.clone()] {
            let n = batch.blocks.len();
            for_ranges(jobs, n, grain(jobs, n, 8), |part| {
                for i in batch.blocks.start + part.start..batch.blocks.start + part.end {
                    self.pack_joints(i);
                }
            });
        }
        self.prepare_sixdofs(group, jobs);
    }

    pub(super) fn sweep_joints(&self, group: &Group, sweep: &JointSweep, jobs: &dyn Executor) {
        for batch in &self.plan.joints.batches[group.joints.clone()] {
            let n = batch.blocks.len();
            for_ranges(jobs, n, grain(jobs, n, 8), |part| {
                dispatch!(self.ctx.level, simd => {
                    for i in batch.blocks.start + part.start..batch.blocks.start + part.end {
                        let block = self.joints.row(i);
                        self.joints.prefetch(i + 1, JointBlock::CACHE_LINES);
                        if batch.class == DISTANCE {
                            joint::solve_distance(simd, block, batch.fixed, &self.lines, sweep);
                        } else {
                            joint::solve_ball(simd, block, batch.fixed, &self.lines, sweep);
                        }
                    }
                });
            });
        }
    }

    /// Builds a block of joints and applies their impulses to the lines.
    pub(super) fn pack_joints(&self, block: usize) {
        let owners = &self.plan.joints.owners[block];
        let block = self.joints.row(block);
        if owners[LANES - 1] == u32::MAX {
            *block = JointBlock::default();
        }
        for (lane, row) in owners.iter().enumerate() {
            if *row != u32::MAX
                && let Some(joint) = self.joint_slots.read(*row as usize)
            {
                self.fill(joint, lane, block);
            }
        }
    }

    /// Writes the impulses of a block back.
    pub(super) fn store_joints(&self, block: usize) {
        let owners = &self.plan.joints.owners[block];
        let [x, y, z] = &self.joints.read(block).impulse;
        for (lane, row) in owners.iter().enumerate() {
            if *row != u32::MAX
                && let Some(joint) = self.joint_slots.row(*row as usize)
                && !self.swing(joint)
            {
                joint.impulse = vec3(x[lane], y[lane], z[lane]) * self.ctx.store_scale;
            }
        }
    }

    fn fill(&self, joint: &Joint, lane: usize, block: &mut JointBlock) {
        let (ctx, bodies, line_of) = (self.ctx, self.bodies, self.line_of);
        let (a, b) = (bodies.at(joint.body_a), bodies.at(joint.body_b));
        let (la, lb) = (line_of[joint.body_a as usize], line_of[joint.body_b as usize]);
        let (wa, wb) = (*self.whitening.read(la as usize), *self.whitening.read(lb as usize));
        let (ra, rb) = (a.rotation.rotate(joint.anchor_a), b.rotation.rotate(joint.anchor_b));
        let gap = (b.center - a.center) + (rb - ra);
        let moves = |body: &Body, r: Vec3| {
            if !body.is_dynamic() && body.active() { body.velocity_at(r) } else { Vec3::ZERO }
        };
        let impulse = joint.impulse * ctx.impulse_scale;

        (block.row_a[lane], block.row_b[lane]) = (la, lb);
        (block.alpha[lane], block.beta[lane]) = (wa.alpha(), wb.alpha());
        let (sa, sb) = (wa.s(), wb.s());
        let six = |s: Sym3| [s.xx, s.yy, s.zz, s.xy, s.xz, s.yz];
        for (i, (sa, sb)) in six(sa).into_iter().zip(six(sb)).enumerate() {
            (block.s_a[i][lane], block.s_b[i][lane]) = (sa, sb);
        }
        put(&mut block.r_a, lane, ra);
        put(&mut block.r_b, lane, rb);
        put(&mut block.gap, lane, gap);
        put(&mut block.drift, lane, moves(b, rb) - moves(a, ra));
        put(&mut block.impulse, lane, impulse);
        // The linear impulse along the gap (a distance) or in the world (a ball).
        let linear = match joint.link {
            Link::Six(_) | Link::Coupling(_) | Link::Pulley(_) => return,
            Link::Ball => impulse,
            Link::Distance { min, max, spring } => {
                let rest = spring.map_or(0.0, |s| s.rest_length);
                put(&mut block.limits, lane, vec3(min, max, rest));
                let soft = spring.map_or(Vec3::ZERO, |s| {
                    let soft = Softness::new(s.hertz, s.damping_ratio, ctx.h);
                    vec3(soft.rate, soft.mass, soft.impulse)
                });
                put(&mut block.spring, lane, soft);
                let linear = gap.normalize_or(Vec3::Y) * (impulse.x - impulse.y + impulse.z);
                put(&mut block.carried, lane, linear);
                linear
            }
        };
        put(&mut block.carried_a, lane, ra.cross(linear));
        put(&mut block.carried_b, lane, rb.cross(linear));
        for (line, w, r, sign) in [(la, wa, ra, -1.0), (lb, wb, rb, 1.0)] {
            if line == 0 {
                continue;
            }
            let line = self.lines.row(line as usize);
            let (v, t) = (linear * (sign * w.alpha()), w.s().mul(r.cross(linear)) * sign);
            for i in 0..3 {
                line.v[i] += v[i];
                line.w[i] += t[i];
            }
        }
    }
}

pub(super) fn put(lanes: &mut [Lanes; 3], lane: usize, v: Vec3) {
    lanes[0][lane] = v.x;
    lanes[1][lane] = v.y;
    lanes[2][lane] = v.z;
}
