//! Joints of six axes to blocks and back.

use fearless_simd::dispatch;

use super::Solver;
use super::joint::JointSweep;
use super::plan::{Group, SIX_ACTS, SIX_DIRECT, SIX_HOLDS};
use super::sixdof::{self, Axis, SixBlock};
use super::spring::Push;
use crate::base::jobs::{Executor, for_ranges, grain};
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;
use crate::base::wide::{LANES, at, put};
use crate::state::bodies::NONE;
use crate::state::joints::{Joint, Link};
use crate::state::sixdof::{JointAxis, JointMotion, JointSpring, Six};

/// Farther than anything is: a limit that is none.
const FAR: f32 = 1.0e30;

/// Stiffer than a substep can tell from rigid.
const STIFF: f32 = 1.0e20;

impl Solver<'_> {
    pub(super) fn prepare_sixdofs(&self, group: &Group, jobs: &dyn Executor) {
        for batch in &self.plan.sixdofs.batches[group.sixdofs.clone()] {
            let n = batch.blocks.len();
            for_ranges(jobs, n, grain(jobs, n, 8), |part| {
                for i in batch.blocks.start + part.start..batch.blocks.start + part.end {
                    self.pack_block(i, batch.class);
                }
            });
        }
    }

    pub(super) fn sweep_sixdofs(&self, group: &Group, sweep: &JointSweep, jobs: &dyn Executor) {
        for batch in &self.plan.sixdofs.batches[group.sixdofs.clone()] {
            if batch.class & SIX_DIRECT != 0 {
                // The trees do it.
                continue;
            }
            let n = batch.blocks.len();
            for_ranges(jobs, n, grain(jobs, n, 4), |part| {
                dispatch!(self.ctx.level, simd => {
                    for i in batch.blocks.start + part.start..batch.blocks.start + part.end {
                        sixdof::solve(simd, self.sixdofs.row(i), &self.lines, sweep);
                    }
                });
            });
        }
    }

    pub(super) fn store_sixdofs(&self, group: &Group, jobs: &dyn Executor) {
        let blocks = self.plan.sixdofs.blocks_of(&group.sixdofs);
        let n = blocks.len();
        for_ranges(jobs, n, grain(jobs, n, 32), |part| {
            for i in blocks.start + part.start..blocks.start + part.end {
                self.store_block(i);
            }
        });
    }

    /// Builds a block of this class and applies its impulses to the lines.
    fn pack_block(&self, block: usize, class: u8) {
        let owners = &self.plan.sixdofs.owners[block];
        let block = self.sixdofs.row(block);
        if owners[LANES - 1] == NONE {
            *block = SixBlock::default();
        }
        block.holds = SIX_HOLDS.map(|bit| class & bit != 0);
        block.acts = SIX_ACTS.map(|bit| class & bit != 0);
        block.is_direct = class & SIX_DIRECT != 0;
        for axis in &mut block.axes {
            (axis.acts, axis.drives, axis.limits, axis.yields) = (false, false, false, false);
        }
        for (lane, row) in owners.iter().enumerate() {
            if *row != NONE
                && let Some(joint) = self.joint_slots.read(*row as usize)
                && let Link::Six(six) = &joint.link
            {
                self.fill_six(joint, six, lane, block);
            }
        }
    }

    /// Writes the impulses of a block back.
    fn store_block(&self, block: usize) {
        let owners = &self.plan.sixdofs.owners[block];
        let block = self.sixdofs.read(block);
        let scale = self.ctx.store_scale();
        for (lane, row) in owners.iter().enumerate() {
            if *row != NONE
                && let Some(joint) = self.joint_slots.row(*row as usize)
                && let Link::Six(six) = &mut joint.link
            {
                for i in 0..6 {
                    six.held[i] = block.held[i][lane] * scale;
                    six.friction[i] = block.friction[i][lane] * scale;
                    six.limit[i] = block.limit[i][lane] * scale;
                }
                if six.def.cone.is_some() {
                    // The rows of the swings turn from step to step: kept along y and z.
                    let a = self.at_start(joint.body_a);
                    let axes = (a.rotation * six.def.frame_a).to_mat3();
                    let row = at(&block.n[1], lane);
                    let (c, s) = (row.dot(axes.y), row.dot(axes.z));
                    for of in [&mut six.held, &mut six.friction] {
                        let [along, across] = [of[4], of[5]];
                        (of[4], of[5]) = (c * along - s * across, s * along + c * across);
                    }
                }
                for i in 0..3 {
                    six.angles[i] = block.angles[i][lane];
                }
                six.force = at(&block.carried, lane) * scale;
                six.torque = at(&block.torque, lane) * scale;
            }
        }
    }

    fn fill_six(&self, joint: &Joint, six: &Six, lane: usize, block: &mut SixBlock) {
        let (ctx, line_of) = (self.ctx, self.line_of);
        let (a, b) = (self.at_start(joint.body_a), self.at_start(joint.body_b));
        let (la, lb) = (line_of[joint.body_a as usize], line_of[joint.body_b as usize]);
        let (wa, wb) = (*self.whitening.read(la as usize), *self.whitening.read(lb as usize));
        let (ra, rb) = (a.rotation.rotate(joint.anchor_a), b.rotation.rotate(joint.anchor_b));
        let gap = (b.center - a.center) + (rb - ra);
        let motion = |row: u32| {
            let body = self.bodies.at(row);
            let is_moved = !body.is_dynamic() && body.active();
            if is_moved { (body.v, body.w) } else { (Vec3::ZERO, Vec3::ZERO) }
        };
        let ((va, spin_a), (vb, spin_b)) = (motion(joint.body_a), motion(joint.body_b));

        (block.row_a[lane], block.row_b[lane]) = (la, lb);
        (block.alpha[lane], block.beta[lane]) = (wa.alpha(), wb.alpha());
        let numbers = |s: Sym3| [s.xx, s.yy, s.zz, s.xy, s.xz, s.yz];
        for (i, (sa, sb)) in numbers(wa.s()).into_iter().zip(numbers(wb.s())).enumerate() {
            (block.s_a[i][lane], block.s_b[i][lane]) = (sa, sb);
        }
        put(&mut block.r_a, lane, ra);
        put(&mut block.r_b, lane, rb);
        put(&mut block.gap, lane, gap);
        put(&mut block.drift, lane, vb - va);
        put(&mut block.spin_a, lane, spin_a);
        put(&mut block.spin_b, lane, spin_b);

        let pulled = |line: u32| {
            if line == 0 { Vec3::ZERO } else { *self.acceleration.read(line as usize) }
        };
        put(&mut block.pull, lane, pulled(lb) - pulled(la));
        let axes = (a.rotation * six.def.frame_a).to_mat3();
        let axes = [axes.x, axes.y, axes.z];
        let turns = six.turns(a.rotation, b.rotation);
        let (mut kept, mut rubbed) = (six.held, six.friction);
        if six.def.cone.is_some() {
            for of in [&mut kept, &mut rubbed] {
                let ([c, s], [.., y, z]) = (turns.swing, *of);
                (of[4], of[5]) = (c * y + s * z, c * z - s * y);
            }
        }
        if six.def.holds_all_motions() {
            // As in the kernel: the force stays as it is in the world.
            for i in 0..3 {
                kept[i] = axes[i].dot(six.force);
            }
        }
        for (i, axis) in six.def.acting(turns.swing).iter().enumerate() {
            let held = axis.held();
            block.locked[i][lane] = if held.is_some() { 1.0 } else { 0.0 };
            block.place[i][lane] = held.unwrap_or(0.0);
            // What is no more has left nothing that is carried on.
            let acts = held.is_some() || axis.is_scalar();
            let scale = if acts { ctx.impulse_scale } else { 0.0 };
            block.held[i][lane] = kept[i] * scale;
            block.friction[i][lane] = rubbed[i] * scale;
            block.limit[i][lane] = six.limit[i] * scale;
            if block.acts[i / 3] && held.is_none() {
                fill_axis(axis, ctx.h, &mut block.axes[i], lane);
            }
        }
        let (mut force, mut torque) = (Vec3::ZERO, Vec3::ZERO);
        for i in 0..3 {
            put(&mut block.u[i], lane, axes[i]);
            put(&mut block.n[i], lane, turns.rows[i]);
            block.angles[i][lane] = turns.angles[i];
            let given =
                |i: usize| block.held[i][lane] + block.friction[i][lane] + block.limit[i][lane];
            force += axes[i] * given(i);
            torque += turns.rows[i] * given(i + 3);
        }
        let moments = [(ra + gap).cross(force) + torque, rb.cross(force) + torque];
        put(&mut block.carried, lane, force);
        put(&mut block.carried_a, lane, moments[0]);
        put(&mut block.carried_b, lane, moments[1]);
        put(&mut block.torque, lane, torque);
        for (line, w, moment, sign) in [(la, wa, moments[0], -1.0), (lb, wb, moments[1], 1.0)] {
            if line == 0 || block.is_direct {
                continue;
            }
            let line = self.lines.row(line as usize);
            let (v, t) = (force * (sign * w.alpha()), w.s().mul(moment) * sign);
            for i in 0..3 {
                line.v[i] += v[i];
                line.w[i] += t[i];
            }
        }
    }
}

fn fill_axis(axis: &JointAxis, h: f32, out: &mut Axis, lane: usize) {
    out.acts |= axis.is_scalar();
    out.drives |= axis.drive.is_some();
    out.limits |= axis.motion != JointMotion::Free;
    let (mut low, mut high, mut hard) = (-FAR, FAR, 0.0);
    let mut limit = None;
    if let JointMotion::Limited { min, max, spring } = axis.motion {
        (low, high) = (min.max(-FAR), max.min(FAR));
        hard = if spring.is_none() { 1.0 } else { 0.0 };
        limit = spring;
        out.yields |= spring.is_some();
    }
    (out.low[lane], out.high[lane], out.hard[lane]) = (low, high, hard);
    fill_push(limit, 0.0, 0.0, &mut out.limit, lane);
    let drive = axis.drive.map(|d| d.spring);
    let (position, velocity) = axis.drive.map_or((0.0, 0.0), |d| (d.position, d.velocity));
    fill_push(drive, position, velocity, &mut out.drive, lane);
    out.most[lane] = axis.drive.map_or(0.0, |d| (d.max_force * h).min(FAR));
    out.friction[lane] = (axis.friction * h).min(FAR);
}

fn fill_push(spring: Option<JointSpring>, place: f32, speed: f32, out: &mut Push, lane: usize) {
    let spring = spring.unwrap_or(JointSpring::new(0.0, 0.0));
    out.stiffness[lane] = spring.stiffness.min(STIFF);
    // An infinite damping is a motor.
    out.damping[lane] = spring.damping.min(STIFF);
    out.per_mass[lane] = if spring.per_mass { 1.0 } else { 0.0 };
    (out.place[lane], out.speed[lane]) = (place, speed);
}
